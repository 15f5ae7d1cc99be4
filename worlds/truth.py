"""Ground truth about a house: the room at a point, the openness of boundaries, the graph of rooms, and the objects.

All functions compute exactly from the house's polygons, openings and heights. The length of the shortest walkable path
between two points is `worlds.walkable.Walkable.distance`.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Literal

import numpy as np
import shapely
from jaxtyping import Bool, Float, Int
from shapely.geometry import LineString

from worlds.house import House
from worlds.labels import STAIRS
from worlds.openings.partitions import gap_area
from worlds.spec import PASSABLE, OpeningKind, OpeningSpec
from worlds.walls import Boundary

AMBIGUITY_BAND_M = 0.75
"""Greatest distance from an open boundary at which the labels of both rooms count as correct [m]."""
AMBIGUOUS_FRAME_M = 1.2
"""Least width at which a cased opening or an arch counts as an open boundary [m]. Near an open boundary the true label is
ambiguous; near a narrower opening it is not."""
NOWHERE = -1
FLOOR_TOLERANCE_M = 1e-6
"""Greatest depth below a floor at which a point counts as on the floor [m]; it covers rounding errors of heights."""

Point3 = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class BoundaryLine:
    """A straight stretch of room boundary in the plan that is either wall or one opening along its whole length."""

    storey: int
    rooms: tuple[str | None, str | None]
    """Ids of the rooms (in `house.rooms`) on both sides; None: outside."""
    kind: OpeningKind | Literal["wall"]
    line: LineString
    """The part of the wall's centre line that the boundary takes, in W [m]."""


@dataclass(frozen=True)
class Passage:
    """An edge of the room graph: an opening that one can walk through."""

    rooms: tuple[str, str]
    """Ids of the rooms (in `house.rooms`) that the passage connects; a staircase is one room on all its storeys."""
    storey: int
    kind: OpeningKind
    point: Point3
    """Middle of the opening, on the floor, in W [m]."""
    width_m: float


@dataclass(frozen=True)
class RoomGraph:
    """The graph of rooms (nodes) and passages (edges); two rooms may have several passages between them."""

    rooms: tuple[str, ...]
    passages: tuple[Passage, ...]


@dataclass(frozen=True)
class ObjectInstance:
    """A piece of furniture, a door leaf or a window, with its oriented bounding box."""

    id: str
    kind: str
    room: str
    """Id of the room in which the object stands; for a door leaf, the room that the leaf swings into."""
    centre: Point3
    """Centre of the box in W [m]."""
    yaw: float
    """Rotation of the box about z [rad]."""
    size: Point3
    """Width, depth, height of the box along its own axes [m]."""


def room_at(house: House, points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
    """Return the index into `house.rooms` of the room that contains each point in W [m]; `NOWHERE` outside of all rooms.

    Rooms end at the centre lines of walls; a point exactly on a centre line belongs to the room that comes later in
    `house.rooms`. A room extends from its floor to the top of the slab above its ceiling. Both ends are lowered by
    `FLOOR_TOLERANCE_M`, so that a point on the floor is in the room.
    """
    owner = np.full(len(points), NOWHERE)
    heights = points[:, 2] + FLOOR_TOLERANCE_M
    for i, room in enumerate(house.rooms):
        in_height = (heights >= room.floor_m) & (heights < room.ceiling_m + house.spec.slab_m)
        owner[in_height & shapely.intersects_xy(room.polygon, points[:, 0], points[:, 1])] = i
    return owner


def floor_at(house: House, points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
    """Return the index of the storey of each point in W [m].

    This is the highest storey whose floor is not above the point, and storey 0 for points below all floors.
    """
    return storey_of(points[:, 2], [storey.floor_m for storey in house.storeys])


def storey_of(heights: Float[np.ndarray, "n"], floors_m: Sequence[float]) -> Int[np.ndarray, "n"]:
    """Return the index of the highest floor that is not above each height [m]; 0 for heights below all floors.

    A floor that is at most `FLOOR_TOLERANCE_M` above a height counts as not above it.
    """
    return np.clip(np.searchsorted(floors_m, heights + FLOOR_TOLERANCE_M, side="right") - 1, 0, None)


def ambiguity_at(
    house: House, points: Float[np.ndarray, "n 3"], band_m: float = AMBIGUITY_BAND_M
) -> Bool[np.ndarray, "n rooms"]:
    """Return whether the label of each room counts as right at each point in W [m].

    The label of the room that contains the point always counts. Where the boundary between two rooms is open, an image does
    not show where a room ends. So the labels of both rooms count at points of these rooms that are straight in front of the
    opening and at most `band_m` [m] away. `is_ambiguous` says which openings count as open.
    """
    owner, storey = room_at(house, points), floor_at(house, points)
    allowed = owner[:, None] == np.arange(len(house.rooms))
    index_of = {room.id: i for i, room in enumerate(house.rooms)}
    for level, boundary, opening in _pieces(house):
        if opening is None or not is_ambiguous(opening):
            continue
        sides = [index_of[house.room_by_id[name].id] for name in opening.rooms]
        along, across = points[:, boundary.axis], points[:, 1 - boundary.axis] - boundary.at
        near = (np.abs(across) <= band_m) & (along >= boundary.low) & (along <= boundary.high)
        near &= (storey == level) & np.isin(owner, sides)
        allowed[near] |= np.isin(np.arange(len(house.rooms)), sides)
    return np.asarray(allowed)


def is_ambiguous(opening: OpeningSpec) -> bool:
    """Return whether a boundary with this opening is so open that an image does not show where a room ends.

    This is the case for removed walls, half walls and counters, and for arches and cased openings at least 1.2 m wide. It is
    never the case for doors.
    """
    if opening.kind in ("cased", "arch"):
        return opening.width_m >= AMBIGUOUS_FRAME_M - 1e-9
    return opening.kind != "door"


def boundary_openness(house: House) -> dict[tuple[str, str], float]:
    """Return the openness of the boundary between each pair of neighbouring indoor rooms, by the sorted pair of their ids.

    The openness is the share of the boundary's area, from floor to ceiling, that is permanently open; doors count as wall.
    Stairs are not included.
    """
    return {pair: gap / area for pair, (gap, area) in _gap_and_area(house).items()}


def openness(house: House) -> float:
    """Return the openness of a house: the mean of `boundary_openness` over all boundaries, weighted by area, in [0, 1].

    0: all openings are doors, or there are no boundaries between rooms; 1: there is no wall between any two rooms.
    """
    pairs = _gap_and_area(house).values()
    total = sum(area for _, area in pairs)
    return sum(gap for gap, _ in pairs) / total if total else 0.0


def _gap_and_area(house: House) -> dict[tuple[str, str], tuple[float, float]]:
    """Return the open area and the whole area of the boundary between each pair of neighbouring indoor rooms [m²].

    Stairs are not included.
    """
    sums: dict[tuple[str, str], tuple[float, float]] = defaultdict(lambda: (0.0, 0.0))
    inner = {room.id for room in house.rooms if room.label != STAIRS and not room.outdoor}
    for level, boundary, opening in _pieces(house):
        a, b = boundary.rooms
        if a in inner and b in inner and a is not None and b is not None:
            height = house.spec.storeys[level].height_m
            # An opening may extend over two stretches of boundary; each stretch gets its share of the area.
            taken = 0.0 if opening is None else gap_area(opening, height) * boundary.length / opening.width_m
            gap, area = sums[min(a, b), max(a, b)]
            sums[min(a, b), max(a, b)] = gap + taken, area + boundary.length * height
    return {pair: (min(gap, area), area) for pair, (gap, area) in sums.items()}  # rounding may leave a larger gap


def boundary_lines(house: House) -> tuple[BoundaryLine, ...]:
    """Return all room boundaries of a house, as straight stretches."""
    return tuple(
        BoundaryLine(
            level,
            (_room(house, boundary.rooms[0]), _room(house, boundary.rooms[1])),
            "wall" if opening is None else opening.kind,
            LineString([boundary.point(boundary.low), boundary.point(boundary.high)]),
        )
        for level, boundary, opening in _pieces(house)
    )


def room_graph(house: House) -> RoomGraph:
    """Return the graph of rooms and passages; a staircase is one room, with passages on all storeys that it joins."""
    passages = []
    for level, storey in enumerate(house.spec.storeys):
        for opening in storey.openings:
            if opening.kind in PASSABLE:
                rooms = house.room_by_id[opening.rooms[0]].id, house.room_by_id[opening.rooms[1]].id
                point = (*opening.middle_m, house.storeys[level].floor_m)
                passages.append(Passage(rooms, level, opening.kind, point, opening.width_m))
    return RoomGraph(tuple(room.id for room in house.rooms), tuple(passages))


def objects(house: House) -> tuple[ObjectInstance, ...]:
    """Return all objects of a house: furniture, then door leaves, then windows."""
    placed = chain(
        ((piece, piece.kind, piece.room) for piece in house.furniture),
        ((leaf, "door", leaf.into) for leaf in house.leaves),
        ((window, "window", window.room) for window in house.windows),
    )
    return tuple(
        ObjectInstance(
            thing.id,
            kind,
            house.room_by_id[room].id,
            (thing.position[0], thing.position[1], thing.position[2] + thing.size[2] / 2),
            thing.yaw,
            thing.size,
        )
        for thing, kind, room in placed
    )


def floor_area(house: House) -> float:
    """Return the indoor area of all storeys, measured to the centre lines of the walls [m²]; stairs count on each storey."""
    storeys = house.spec.storeys
    return float(
        sum(house.room_by_id[r.id].polygon.area for s in storeys for r in s.rooms if not house.room_by_id[r.id].outdoor)
    )


def _pieces(house: House) -> Iterator[tuple[int, Boundary, OpeningSpec | None]]:
    """Yield every stretch of room boundary, as (index of the storey, stretch, opening that fills the stretch or None)."""
    for level, pieces in enumerate(house.boundaries):
        for boundary, opening in pieces:
            yield level, boundary, opening


def _room(house: House, cell: str | None) -> str | None:
    """Return the id in `house.rooms` for a room id of the spec; the two ids can differ for stairs only. None stays None."""
    return None if cell is None else house.room_by_id[cell].id
