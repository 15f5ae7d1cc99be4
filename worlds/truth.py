"""Exact truth about a house: who is where, what is open, what leads where, what stands where.

Everything here is a function of the house's polygons, openings and heights. The shortest walkable way between two points is
`worlds.walkable.Walkable.distance`.
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
AMBIGUOUS_FRAME_M = 1.2
"""From this width on a cased opening or an arch leaves it open where one room ends."""
NOWHERE = -1
FLOOR_TOLERANCE_M = 1e-6
"""A foot stands on a floor that it is this little below: heights that rays or sums give are rounded."""

Point3 = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class BoundaryLine:
    """A stretch of room boundary in the plan, all wall or all one opening."""

    storey: int
    rooms: tuple[str | None, str | None]
    """Ids of `house.rooms` on either side; None: outside."""
    kind: OpeningKind | Literal["wall"]
    line: LineString
    """On the wall's centre [m]."""


@dataclass(frozen=True)
class Passage:
    """An edge of the room graph: an opening that one can walk through."""

    rooms: tuple[str, str]
    """Ids of `house.rooms`; stairs are one room on all their storeys."""
    storey: int
    kind: OpeningKind
    point: Point3
    """The middle of the opening, on the floor, in W [m]."""
    width_m: float


@dataclass(frozen=True)
class RoomGraph:
    """Rooms and the passages between them; two rooms may have several. `rooms` and `passages` make any graph library's."""

    rooms: tuple[str, ...]
    passages: tuple[Passage, ...]


@dataclass(frozen=True)
class ObjectInstance:
    """A piece of furniture, a door's leaf or a window, in its box."""

    id: str
    kind: str
    room: str
    """That it stands in, looks out of or swings into."""
    centre: Point3
    """Of the box, in W [m]."""
    yaw: float
    """Of the box about z [rad]."""
    size: Point3
    """Width, depth, height of the box along its own axes [m]."""


def room_at(house: House, points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
    """Index into `house.rooms` of the room that holds each point of W [m], `NOWHERE` outside of all.

    Walls are split at their centre lines, of which a point right on one belongs to the later room of `house.rooms`; a room
    reaches from its floor to the next one's, both taken `FLOOR_TOLERANCE_M` lower, so that feet are in a room.
    """
    owner = np.full(len(points), NOWHERE)
    heights = points[:, 2] + FLOOR_TOLERANCE_M
    for i, room in enumerate(house.rooms):
        in_height = (heights >= room.floor_m) & (heights < room.ceiling_m + house.spec.slab_m)
        owner[in_height & shapely.intersects_xy(room.polygon, points[:, 0], points[:, 1])] = i
    return owner


def floor_at(house: House, points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
    """Storey of each point of W [m]: the one with the highest floor that is not above it."""
    return storey_of(points[:, 2], [storey.floor_m for storey in house.storeys])


def storey_of(heights: Float[np.ndarray, "n"], floors_m: Sequence[float]) -> Int[np.ndarray, "n"]:
    """Index of the highest floor that is not above each height, `FLOOR_TOLERANCE_M` aside; 0 below all floors [m]."""
    return np.clip(np.searchsorted(floors_m, heights + FLOOR_TOLERANCE_M, side="right") - 1, 0, None)


def ambiguity_at(
    house: House, points: Float[np.ndarray, "n 3"], band_m: float = AMBIGUITY_BAND_M
) -> Bool[np.ndarray, "n rooms"]:
    """Which rooms' labels count as right at each point.

    The room that holds the point always does. Where nothing closes a boundary - no wall, half a wall, a counter, a wide
    cased opening or arch - both sides do, straight before and behind the gap, within `band_m` [m].
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
    """Whether one cannot say from looking where one room ends."""
    if opening.kind in ("cased", "arch"):
        return opening.width_m >= AMBIGUOUS_FRAME_M - 1e-9
    return opening.kind != "door"


def boundary_openness(house: House) -> dict[tuple[str, str], float]:
    """For each pair of neighbouring indoor rooms, stairs left out: the share of the wall between them that is gap, exactly.

    Doors count as wall (they can be closed), everything else with what it takes out of the wall, floor to ceiling.
    """
    return {pair: gap / area for pair, (gap, area) in _gap_and_area(house).items()}


def openness(house: House) -> float:
    """The mean of `boundary_openness`, weighted by area, in [0, 1]; 0 for a house without inner walls.

    0: every room is behind doors; 1: there is no wall between rooms at all.
    """
    pairs = _gap_and_area(house).values()
    total = sum(area for _, area in pairs)
    return sum(gap for gap, _ in pairs) / total if total else 0.0


def _gap_and_area(house: House) -> dict[tuple[str, str], tuple[float, float]]:
    sums: dict[tuple[str, str], tuple[float, float]] = defaultdict(lambda: (0.0, 0.0))
    inner = {room.id for room in house.rooms if room.label != STAIRS and not room.outdoor}
    for level, boundary, opening in _pieces(house):
        a, b = boundary.rooms
        if a in inner and b in inner and a is not None and b is not None:
            height = house.spec.storeys[level].height_m
            # A gap across two stretches counts in each with its share.
            taken = 0.0 if opening is None else gap_area(opening, height) * boundary.length / opening.width_m
            gap, area = sums[min(a, b), max(a, b)]
            sums[min(a, b), max(a, b)] = gap + taken, area + boundary.length * height
    return dict(sums)


def boundary_lines(house: House) -> tuple[BoundaryLine, ...]:
    """All room boundaries of a house, in stretches. Room polygons are `house.rooms[i].polygon`."""
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
    """Which rooms one can walk between, and where; stairs are joined to the rooms at both ends."""
    passages = []
    for level, storey in enumerate(house.spec.storeys):
        for opening in storey.openings:
            if opening.kind in PASSABLE:
                rooms = house.room_by_id[opening.rooms[0]].id, house.room_by_id[opening.rooms[1]].id
                x, y = (opening.start_m[0] + opening.end_m[0]) / 2, (opening.start_m[1] + opening.end_m[1]) / 2
                passages.append(Passage(rooms, level, opening.kind, (x, y, house.storeys[level].floor_m), opening.width_m))
    return RoomGraph(tuple(room.id for room in house.rooms), tuple(passages))


def objects(house: House) -> tuple[ObjectInstance, ...]:
    """All objects of a house: furniture, then door leaves, then windows."""
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
    """Indoor area of all storeys, to the wall centre lines [m²]."""
    storeys = house.spec.storeys
    return float(
        sum(house.room_by_id[r.id].polygon.area for s in storeys for r in s.rooms if not house.room_by_id[r.id].outdoor)
    )


def _pieces(house: House) -> Iterator[tuple[int, Boundary, OpeningSpec | None]]:
    for level, pieces in enumerate(house.boundaries):
        for boundary, opening in pieces:
            yield level, boundary, opening


def _room(house: House, cell: str | None) -> str | None:
    return None if cell is None else house.room_by_id[cell].id
