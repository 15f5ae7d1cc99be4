"""Adds the openings that an imported plan lacks.

1. Stairs at which no passage (an opening that one walks through) is drawn get openings on every storey that they join: one
   opening to the foot of the flight that begins on the storey, and one opening to the head of the flight that ends there.
   Spiral stairs and lifts get a single opening on every storey.
2. Doors are added between rooms that neither drawn openings nor stairs connect, until every room can be reached on foot.
"""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from worlds.errors import HouseError, SpecError
from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.layout import Link, StoreyLayout
from worlds.openings.opening_draft import OpeningDraft
from worlds.openings.placement import MIN_DOOR_M, free_spans, place_openings
from worlds.spec import PASSABLE, HouseSpec, Leads, OpeningSpec, RoomSpec, StoreySpec
from worlds.stairs.build import build_stairs
from worlds.stairs.cells import Bounds, bounds, flight_places, is_same_cell, opening_that_leads, openings_of
from worlds.stairs.shafts import check_shafts
from worlds.walls import Boundary, boundaries

_HUBS = ("corridor", "entrance hall", "lobby", "open-plan office", "living room")
_SIDE_M = 0.05
_FLIGHT_M = 0.9
CellSide = tuple[int, bool]
"""A side of a rectangle: the axis along which the side runs (0: x, 1: y), and whether its coordinate on the other axis is
larger than the coordinate of the opposite side."""
_SIDES: tuple[CellSide, ...] = ((0, False), (0, True), (1, False), (1, True))


def added_openings(spec: HouseSpec) -> list[tuple[OpeningSpec, ...]]:
    """Return the openings to add on each storey, lowest first, so that every room can be reached on foot from all others.

    No opening is added between rooms that are already connected, or at stairs with a drawn passage (an opening that one
    walks through). Raises `WorldsError` if a needed opening fits nowhere, or if lifts or spirals are in unsuitable rooms.
    """
    check_shafts(spec)
    storeys = spec.storeys
    stairs: list[list[OpeningSpec]] = [[] for _ in storeys]
    for level, storey in enumerate(storeys):
        for cell in storey.rooms:
            if cell.label == STAIRS and not (level and _cells(storeys[level - 1], cell)) and not _has_passage(storeys, cell):
                for k, openings in enumerate(_stair_openings(spec, level, cell), start=level):
                    stairs[k] += openings
    group = _walked_groups(spec)
    rng = np.random.default_rng(0)
    added = []
    for storey, at_stairs in zip(storeys, stairs, strict=True):
        present = (*storey.openings, *at_stairs)
        links = tuple(_added_doors(storey, present, group))
        whole = place_openings(StoreyLayout(storey.rooms, links, present, storey.height_m), rng)
        added.append(whole[len(storey.openings) :])
    return added


def _has_passage(storeys: Sequence[StoreySpec], cell: RoomSpec) -> bool:
    """Whether a passage (an opening that one walks through) is drawn at these stairs on any storey.

    `cell` is the room of the stairs on one of the storeys.
    """
    cells = {room.id for storey in storeys for room in _cells(storey, cell)}
    drawn = (opening for storey in storeys for opening in storey.openings if opening.kind in PASSABLE)
    return any(not cells.isdisjoint(opening.rooms) for opening in drawn)


def _walked_groups(spec: HouseSpec) -> dict[str, str]:
    """Return the group of each room except stairs, by the room's id. Drawn openings and stairs connect the rooms of a group.

    The name of a group is the id of one of its rooms.
    """
    group = {room.id: room.id for storey in spec.storeys for room in storey.rooms if room.label != STAIRS}
    for opening in (opening for storey in spec.storeys for opening in storey.openings if opening.kind in PASSABLE):
        _merge(group, *opening.rooms)
    for level, cell in flight_places(spec):
        try:
            ends = _ends(spec, level, cell)
        except HouseError:
            continue  # the check of the finished house reports this error
        _merge(group, *(room for opening in ends for room in opening.rooms if room in group))
    return group


def _ends(spec: HouseSpec, level: int, below: RoomSpec) -> list[OpeningSpec]:
    """Return the openings at the foot and at the head of the flight, spiral or lift up from a room on storeys[`level`].

    `below` is this room. Raises `HouseError` if it is not clear which opening leads to a flight.
    """
    above = _cells(spec.storeys[level + 1], below)[0]
    if below.climb == "flights":
        return [opening_that_leads(spec, level, below, "up"), opening_that_leads(spec, level + 1, above, "down")]
    return [opening for k, cell in enumerate((below, above), level) for _, opening in openings_of(spec.storeys[k], cell)]


def _merge(group: dict[str, str], *rooms: str) -> bool:
    """Merge the groups of two rooms. Return whether the groups were different and have been merged.

    Nothing is merged if one of the rooms is stairs, because stairs belong to no group, or if `rooms` are not exactly two.
    """
    if len(rooms) != 2 or not group.keys() >= {*rooms} or group[rooms[0]] == group[rooms[1]]:
        return False
    old, new = (group[room] for room in rooms)
    group.update({room: new for room, its in group.items() if its == old})
    return True


def _added_doors(storey: StoreySpec, present: Sequence[OpeningSpec], group: dict[str, str]) -> Iterator[Link]:
    """Yield requests for doors that connect all groups of rooms, as far as walls allow; `group` is updated in place.

    The doors are chosen by Kruskal's algorithm, as in a minimum spanning tree. Doors to corridors, halls and living rooms
    are preferred; doors to gardens and balconies are the last choice. Among equally good doors, the one in the longest wall
    is chosen. `present` are the openings that already exist.
    """
    label = {room.id: room.label for room in storey.rooms}
    gaps = [OpeningDraft.of(opening, {room.id: room for room in storey.rooms}) for opening in present]
    walls: dict[tuple[str, str], float] = {}
    for line, low, high in free_spans((line for line in boundaries(storey) if None not in line.rooms), gaps):
        a, b = sorted(map(str, line.rooms))
        if STAIRS not in (label[a], label[b]) and high - low >= MIN_DOOR_M - 1e-9:
            walls[a, b] = max(high - low, walls.get((a, b), 0.0))
    for a, b in sorted(walls, key=lambda pair: (_rank(label[pair[0]], label[pair[1]]), -walls[pair], pair)):
        if _merge(group, a, b):
            yield Link((a, b))


def _rank(a: str, b: str) -> int:
    hubs = [_HUBS.index(label) for label in (a, b) if label in _HUBS]
    return min(hubs, default=len(_HUBS)) + 10 * (a in OUTDOOR_LABELS or b in OUTDOOR_LABELS)


def _cells(storey: StoreySpec, cell: RoomSpec) -> list[RoomSpec]:
    return [room for room in storey.rooms if is_same_cell(room, cell)]


def _stair_openings(spec: HouseSpec, lowest: int, cell: RoomSpec) -> list[list[OpeningSpec]]:
    """Return the openings of a staircase on each storey, from `lowest` on, in the first arrangement that can be built.

    `cell` is the room of the stairs on the storey `lowest`. Raises `SpecError` if no arrangement works; the message says
    what is wrong with the first one whose openings all fit.
    """
    stack = [spec.storeys[lowest]]
    while lowest + len(stack) < len(spec.storeys) and _cells(spec.storeys[lowest + len(stack)], cell):
        stack.append(spec.storeys[lowest + len(stack)])
    floors = np.cumsum([0.0, *(storey.height_m + spec.slab_m for storey in stack[:-1])]).tolist()
    if cell.climb == "flights":
        needed, arrangements = 2 * len(stack) - 2, _flight_openings(stack, cell)
    else:
        needed, arrangements = len(stack), _shaft_openings(stack, cell)
    problems = []
    for arrangement in (each for each in arrangements if sum(map(len, each)) == needed):
        problem = _problem(stack, cell, arrangement, spec.slab_m, floors)
        if problem is None:
            return arrangement
        problems.append(problem)
    if problems:
        raise SpecError(f"no openings could be added to stairs {cell.id!r}: {problems[0]}")
    raise SpecError(
        f"no openings could be added to stairs {cell.id!r}, because no side of them borders a single room for long enough "
        "on every storey; valid: stairs with drawn openings, or rooms beside them"
    )


def _flight_openings(stack: Sequence[StoreySpec], cell: RoomSpec) -> Iterator[list[list[OpeningSpec]]]:
    """Yield the openings of flights on each storey, for every pair of sides at which the flights begin and end.

    Pairs of equal sides (stairs that turn by 180 degrees) come first. Where an opening does not fit, it is left out.
    """
    for foot, head in sorted(product(_SIDES, repeat=2), key=lambda sides: sides[0] != sides[1]):
        yield [
            [
                *(_stair_opening(storey, cell, foot, _foot_span(cell, foot, head), "up") if k + 1 < len(stack) else ()),
                *(_stair_opening(storey, cell, head, _head_span(cell, foot, head), "down") if k else ()),
            ]
            for k, storey in enumerate(stack)
        ]


def _shaft_openings(stack: Sequence[StoreySpec], cell: RoomSpec) -> Iterator[list[list[OpeningSpec]]]:
    """Yield the openings of a spiral or a lift on each storey, for every side of its room.

    All openings are in the same side. Where an opening does not fit, it is left out.
    """
    for side in _SIDES:
        low, high = _extent(cell, side)
        yield [[*_stair_opening(storey, cell, side, (low + _SIDE_M, high - _SIDE_M), None)] for storey in stack]


def _foot_span(cell: RoomSpec, foot: CellSide, head: CellSide) -> tuple[float, float]:
    """Return both ends of the opening at a flight's foot, as coordinates along the side `foot` of the stairs' room [m]."""
    low, high = _extent(cell, foot)
    if foot == head:
        return low + _SIDE_M, (low + high) / 2
    return (low + _SIDE_M, high - _SIDE_M) if foot[0] == head[0] else _away_from(head[1], low, high)


def _head_span(cell: RoomSpec, foot: CellSide, head: CellSide) -> tuple[float, float]:
    """Return both ends of the opening at a flight's head, as coordinates along the side `head` of the stairs' room [m]."""
    low, high = _extent(cell, head)
    if foot == head:
        return (low + high) / 2, high - _SIDE_M
    return (low + _SIDE_M, high - _SIDE_M) if foot[0] == head[0] else _away_from(foot[1], low, high)


def _away_from(larger: bool, low: float, high: float) -> tuple[float, float]:
    """Return both ends of an opening of L-shaped stairs, as coordinates along its side of the room [m].

    The side reaches from `low` to `high` [m]. The other opening of the flight is in an adjacent side, which is at `high` if
    `larger`, else at `low`. The opening lies as far as possible from that adjacent side.
    """
    return (low + _SIDE_M, low + _SIDE_M + _FLIGHT_M) if larger else (high - _SIDE_M - _FLIGHT_M, high - _SIDE_M)


def _extent(cell: RoomSpec, side: CellSide) -> tuple[float, float]:
    box: Bounds = bounds(cell)
    return box[side[0]], box[side[0] + 2]


def _stair_opening(
    storey: StoreySpec, cell: RoomSpec, side: CellSide, span: tuple[float, float], leads: Leads | None
) -> Iterator[OpeningSpec]:
    """Yield an opening in one side of the stairs' room, to the room behind this side, from `span[0]` to `span[1]` [m].

    Yield nothing unless a single room, which is no stairs, lies behind the whole interval `span`. Raises `HouseError` where
    rooms of the storey overlap.
    """
    lines = boundaries(storey)  # refuses stairs that are drawn twice, which are two cells
    (own,) = _cells(storey, cell)
    stairs = {room.id for room in storey.rooms if room.label == STAIRS}
    axis, larger = side
    at = bounds(cell)[1 - axis + 2 * larger]
    for line in lines:
        behind = {*line.rooms} - {own.id}
        if line.axis == axis and own.id in line.rooms and not behind & {None, *stairs} and _holds(line, at, span):
            a, b = (line.point(round(along, 3)) for along in span)
            yield OpeningSpec(rooms=(str(line.rooms[0]), str(line.rooms[1])), kind="open", start_m=a, end_m=b, leads=leads)


def _holds(line: Boundary, at: float, span: tuple[float, float]) -> bool:
    return abs(line.at - at) < 1e-6 and line.low <= span[0] and span[1] <= line.high


def _problem(
    stack: Sequence[StoreySpec], cell: RoomSpec, arrangement: list[list[OpeningSpec]], slab_m: float, floors: list[float]
) -> str | None:
    """Return why stairs with these openings cannot be built in a house without any other stairs; None if they can.

    `stack` are the storeys that the stairs join, `arrangement` their openings on each storey, and `floors` the heights of
    the storeys' floors [m].
    """
    trial = tuple(
        StoreySpec(
            rooms=tuple(room for room in storey.rooms if room.label != STAIRS or is_same_cell(room, cell)),
            openings=tuple(openings),
            height_m=storey.height_m,
        )
        for storey, openings in zip(stack, arrangement, strict=True)
    )
    try:
        build_stairs(HouseSpec(storeys=trial, slab_m=slab_m), floors)
    except HouseError as error:
        return str(error)
    return None
