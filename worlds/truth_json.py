"""`truth_json`: the ground truth about a house as JSON data for other programs."""

from typing import Any

from worlds.house import House, Room
from worlds.truth import (
    ObjectInstance,
    Passage,
    boundary_lines,
    boundary_openness,
    floor_area,
    is_ambiguous,
    objects,
    openness,
    room_graph,
)

TRUTH_SCHEMA = 1


def truth_json(house: House) -> dict[str, Any]:
    """Return the ground truth of a house as data for `json.dumps`; lengths in metres, angles in radians, all in W (z up).

    - `storeys`: heights of floor and ceiling.
    - `rooms`: id, label, storey, floor polygon (along the wall centre lines, counter-clockwise, first corner not repeated),
      heights of floor and ceiling, and whether the room is outdoors.
    - `boundaries`: straight stretches of room boundary, with the rooms on both sides (null: outside), the kind of opening
      (or "wall"), and whether the labels of both rooms count as right near the stretch (see `worlds.truth.ambiguity_at`).
    - `openness`: openness of the house, and of the boundary between every two neighbouring rooms.
    - `passages`: the edges of the room graph.
    - `stairs`: the walking line of every flight, upwards.
    - `objects`: furniture, doors and windows with their bounding boxes (centre, yaw about z, size).
    """
    return {
        "schema": TRUTH_SCHEMA,
        "name": house.spec.name,
        "area_m2": floor_area(house),
        "storeys": [{"floor_m": storey.floor_m, "ceiling_m": storey.ceiling_m} for storey in house.storeys],
        "rooms": [_room(room) for room in house.rooms],
        "boundaries": _boundaries(house),
        "openness": {
            "house": openness(house),
            "pairs": [{"rooms": list(pair), "openness": share} for pair, share in boundary_openness(house).items()],
        },
        "passages": [_passage(passage) for passage in room_graph(house).passages],
        "stairs": [
            {"room": house.room_by_id[flight.room].id, "walking_line_m": flight.walking_line.tolist()}
            for flight in house.stairs
        ],
        "objects": [_object(thing) for thing in objects(house)],
    }


def _room(room: Room) -> dict[str, Any]:
    return {
        "id": room.id,
        "label": room.label,
        "storey": room.storey,
        "polygon_m": [list(corner) for corner in room.polygon.exterior.coords[:-1]],
        "floor_m": room.floor_m,
        "ceiling_m": room.ceiling_m,
        "outdoor": room.outdoor,
    }


def _boundaries(house: House) -> list[dict[str, Any]]:
    ambiguous = [opening is not None and is_ambiguous(opening) for pieces in house.boundaries for _, opening in pieces]
    return [
        {
            "storey": piece.storey,
            "rooms": list(piece.rooms),
            "kind": piece.kind,
            "line_m": [list(end) for end in piece.line.coords],
            "ambiguous": both,
        }
        for piece, both in zip(boundary_lines(house), ambiguous, strict=True)
    ]


def _passage(passage: Passage) -> dict[str, Any]:
    return {
        "rooms": list(passage.rooms),
        "storey": passage.storey,
        "kind": passage.kind,
        "point_m": list(passage.point),
        "width_m": passage.width_m,
    }


def _object(thing: ObjectInstance) -> dict[str, Any]:
    return {
        "id": thing.id,
        "kind": thing.kind,
        "room": thing.room,
        "centre_m": list(thing.centre),
        "yaw_rad": thing.yaw,
        "size_m": list(thing.size),
    }
