"""Proofs that a house can stand and be walked; each failure names the place."""

from itertools import combinations

from worlds.errors import HouseError
from worlds.house import House
from worlds.labels import STAIRS
from worlds.spec import OpeningSpec
from worlds.walkable import Walkable
from worlds.walls import opening_span

BODY_RADIUS_M = 0.25
_MIN_OPENING_M = 2 * BODY_RADIUS_M + 0.1
_MIN_HEIGHT_M = 1.9
_TOLERANCE_M = 1e-3


def validate(house: House) -> None:
    """Raise `HouseError` at the first rule that the house breaks.

    Rooms of a storey do not overlap; every opening lies in the wall between its two rooms, clear of the others, and lets the
    body through; stairs join storeys; furniture stays in its room; every room can be reached on foot from every other.
    """
    for level in range(len(house.storeys)):
        _check_overlap(house, level)
        _check_openings(house, level)
    _check_stairs(house)
    _check_furniture(house)
    _check_reachable(house)


def _check_overlap(house: House, level: int) -> None:
    rooms = [(room.id, house.room_by_id[room.id].polygon) for room in house.spec.storeys[level].rooms]
    for (a, polygon_a), (b, polygon_b) in combinations(rooms, 2):
        if polygon_a.intersects(polygon_b) and (area := polygon_a.intersection(polygon_b).area) > _TOLERANCE_M:
            raise HouseError(f"storeys[{level}]: rooms {a!r} and {b!r} overlap by {area:.2f} m²; rooms may only touch")


def _check_openings(house: House, level: int) -> None:
    height = house.storeys[level].ceiling_m - house.storeys[level].floor_m
    _check_apart(house, level)
    for i, opening in enumerate(house.spec.storeys[level].openings):
        place = f"storeys[{level}].openings[{i}] ({opening.rooms[0]} - {opening.rooms[1]})"
        in_shared_wall = _length_in_shared_wall(house, level, opening)
        if in_shared_wall < opening.width_m - _TOLERANCE_M:
            raise HouseError(
                f"{place}: only {in_shared_wall:.2f} of its {opening.width_m:.2f} m lie in the wall between the two rooms"
            )
        if opening.width_m < _MIN_OPENING_M:
            raise HouseError(f"{place}: {opening.width_m:.2f} m wide; a body needs at least {_MIN_OPENING_M:.2f} m")
        if opening.kind != "open" and not _MIN_HEIGHT_M <= opening.height_m <= height:
            raise HouseError(f"{place}: {opening.height_m:.2f} m high; valid: {_MIN_HEIGHT_M} ... {height:.2f} m")


def _check_apart(house: House, level: int) -> None:
    spans = [opening_span(opening) for opening in house.spec.storeys[level].openings]
    for (i, (*line, low, high)), (j, (*other, start, stop)) in combinations(enumerate(spans), 2):
        if line == other and min(high, stop) - max(low, start) > _TOLERANCE_M:
            raise HouseError(f"storeys[{level}]: openings[{i}] and openings[{j}] overlap; openings may only touch")


def _length_in_shared_wall(house: House, level: int, opening: OpeningSpec) -> float:
    return sum(b.length for b, o in house.boundaries[level] if o is opening and set(b.rooms) == set(opening.rooms))


def _check_stairs(house: House) -> None:
    for room in house.rooms:
        if room.label == STAIRS and room.ceiling_m == house.storeys[room.storey].ceiling_m:
            raise HouseError(f"stairs {room.id!r} join no storeys; they need stairs with the same corners above or below")


def _check_furniture(house: House) -> None:
    for piece in house.furniture:
        room = house.room_by_id[piece.room]
        if not room.polygon.buffer(_TOLERANCE_M).contains(piece.footprint):
            raise HouseError(f"furniture {piece.id!r} ({piece.kind}) sticks out of its room {room.id!r}")
        storey, bottom = house.storeys[piece.storey], piece.position[2]
        if not storey.floor_m - _TOLERANCE_M <= bottom <= bottom + piece.size[2] <= storey.ceiling_m + _TOLERANCE_M:
            raise HouseError(
                f"furniture {piece.id!r} ({piece.kind}) reaches from {bottom:.2f} to {bottom + piece.size[2]:.2f} m; "
                f"valid: {storey.floor_m:.2f} ... {storey.ceiling_m:.2f} m, floor to ceiling"
            )


def _check_reachable(house: House) -> None:
    reached = Walkable(house, radius_m=BODY_RADIUS_M).reachable_rooms()
    missing = [room.id for room in house.rooms if room.id not in reached]
    if missing:
        raise HouseError(
            f"not reachable on foot (body radius {BODY_RADIUS_M} m): {', '.join(missing)}; "
            "add an opening, stairs or free space"
        )
