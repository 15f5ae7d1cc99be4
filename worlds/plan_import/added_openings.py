"""Openings that a plan lacks: doors to rooms that the drawn ones do not reach, and a way up and a way down for stairs."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from worlds.errors import HouseError, SpecError
from worlds.floor_plans.layout import Link, StoreyLayout
from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.openings.opening_draft import OpeningDraft
from worlds.openings.placement import MIN_DOOR_M, free_spans, place_openings
from worlds.spec import PASSABLE, HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.stairs.build import build_stairs
from worlds.stairs.cells import Bounds, Leads, bounds, flights, is_same_cell, opening_that_leads
from worlds.walls import Boundary, boundaries

_HUBS = ("corridor", "entrance hall", "lobby", "open-plan office", "living room")
_SIDE_M = 0.05
_FLIGHT_M = 0.9
Side = tuple[int, bool]
"""The axis that a side of a rectangle runs along, and whether it is the one of larger cross coordinate."""
_SIDES: tuple[Side, ...] = ((0, False), (0, True), (1, False), (1, True))


def made_up(storeys: Sequence[StoreySpec], slab_m: float) -> list[tuple[OpeningSpec, ...]]:
    """For each storey, openings to add so that one can walk from every room to every other; none where one can already.

    Where stairs have any drawn opening that one walks through, none is added to them. Raises `WorldsError` where no place
    is left for an opening.
    """
    stairs: list[list[OpeningSpec]] = [[] for _ in storeys]
    for level, storey in enumerate(storeys):
        for cell in storey.rooms:
            if cell.label == STAIRS and not (level and _cells(storeys[level - 1], cell)) and not _has_a_way(storeys, cell):
                for k, openings in enumerate(_ways(storeys, level, cell, slab_m), start=level):
                    stairs[k] += openings
    group = _walked_groups(storeys)
    rng = np.random.default_rng(0)
    added = []
    for storey, ways in zip(storeys, stairs, strict=True):
        present = (*storey.openings, *ways)
        links = tuple(_links(storey, present, group))
        whole = place_openings(StoreyLayout(storey.rooms, links, present, storey.height_m), rng)
        added.append(whole[len(storey.openings) :])
    return added


def _has_a_way(storeys: Sequence[StoreySpec], cell: RoomSpec) -> bool:
    """Whether an opening that one walks through is drawn anywhere in a stack of cells."""
    cells = {room.id for storey in storeys for room in _cells(storey, cell)}
    drawn = (opening for storey in storeys for opening in storey.openings if opening.kind in PASSABLE)
    return any(not cells.isdisjoint(opening.rooms) for opening in drawn)


def _walked_groups(storeys: Sequence[StoreySpec]) -> dict[str, str]:
    """For each room but stairs, one room that stands for all those that the drawn openings and stairs join it to."""
    spec = HouseSpec(storeys=tuple(storeys))
    group = {room.id: room.id for storey in storeys for room in storey.rooms if room.label != STAIRS}
    for opening in (opening for storey in storeys for opening in storey.openings if opening.kind in PASSABLE):
        _join(group, *opening.rooms)
    for level, place in flights(spec):
        below = storeys[level].rooms[place]
        above = _cells(storeys[level + 1], below)[0]
        try:
            foot, head = opening_that_leads(spec, level, below, "up"), opening_that_leads(spec, level + 1, above, "down")
        except HouseError:
            continue  # the proof of the whole house will tell
        _join(group, *(room for opening in (foot, head) for room in opening.rooms if room in group))
    return group


def _join(group: dict[str, str], *rooms: str) -> bool:
    """Make one group of two rooms' groups; whether they were two. Stairs are in no group."""
    if len(rooms) != 2 or not group.keys() >= {*rooms} or group[rooms[0]] == group[rooms[1]]:
        return False
    old, new = (group[room] for room in rooms)
    group.update({room: new for room, its in group.items() if its == old})
    return True


def _links(storey: StoreySpec, present: Sequence[OpeningSpec], group: dict[str, str]) -> Iterator[Link]:
    """Doors that join all groups of rooms: through halls rather than rooms, through long walls rather than short ones.

    `group` is changed to what the doors make of it.
    """
    label = {room.id: room.label for room in storey.rooms}
    gaps = [OpeningDraft.of(opening, {room.id: room for room in storey.rooms}) for opening in present]
    walls: dict[tuple[str, str], float] = {}
    for line, low, high in free_spans((line for line in boundaries(storey) if None not in line.rooms), gaps):
        a, b = sorted(map(str, line.rooms))
        if STAIRS not in (label[a], label[b]) and high - low >= MIN_DOOR_M - 1e-9:
            walls[a, b] = max(high - low, walls.get((a, b), 0.0))
    for a, b in sorted(walls, key=lambda pair: (_rank(label[pair[0]], label[pair[1]]), -walls[pair], pair)):
        if _join(group, a, b):
            yield Link((a, b))


def _rank(a: str, b: str) -> int:
    hubs = [_HUBS.index(label) for label in (a, b) if label in _HUBS]
    return min(hubs, default=len(_HUBS)) + 10 * (a in OUTDOOR_LABELS or b in OUTDOOR_LABELS)


def _cells(storey: StoreySpec, cell: RoomSpec) -> list[RoomSpec]:
    return [room for room in storey.rooms if is_same_cell(room, cell)]


def _ways(storeys: Sequence[StoreySpec], lowest: int, cell: RoomSpec, slab_m: float) -> list[list[OpeningSpec]]:
    """Openings of a stack of cells, storey by storey, for the first kind of stairs that can be built in it."""
    stack = [storeys[lowest]]
    while lowest + len(stack) < len(storeys) and _cells(storeys[lowest + len(stack)], cell):
        stack.append(storeys[lowest + len(stack)])
    floors = np.cumsum([0.0, *(storey.height_m + slab_m for storey in stack[:-1])]).tolist()
    for foot, head in sorted(product(_SIDES, repeat=2), key=lambda sides: sides[0] != sides[1]):
        ways = [
            [
                *(_way(storey, cell, foot, _foot(cell, foot, head), "up") if k + 1 < len(stack) else ()),
                *(_way(storey, cell, head, _head(cell, foot, head), "down") if k else ()),
            ]
            for k, storey in enumerate(stack)
        ]
        if sum(map(len, ways)) == 2 * len(stack) - 2 and _stand(stack, cell, ways, slab_m, floors):
            return ways
    raise SpecError(f"no openings could be made up for stairs {cell.id!r}; draw them, and see how large stairs have to be")


def _foot(cell: RoomSpec, foot: Side, head: Side) -> tuple[float, float]:
    """From where to where along its side the way up lies."""
    low, high = _extent(cell, foot)
    if foot == head:
        return low + _SIDE_M, (low + high) / 2
    return (low + _SIDE_M, high - _SIDE_M) if foot[0] == head[0] else _away_from(head[1], low, high)


def _head(cell: RoomSpec, foot: Side, head: Side) -> tuple[float, float]:
    low, high = _extent(cell, head)
    if foot == head:
        return (low + high) / 2, high - _SIDE_M
    return (low + _SIDE_M, high - _SIDE_M) if foot[0] == head[0] else _away_from(foot[1], low, high)


def _away_from(larger: bool, low: float, high: float) -> tuple[float, float]:
    """The end of a side that is farther from the side that the L turns to."""
    return (low + _SIDE_M, low + _SIDE_M + _FLIGHT_M) if larger else (high - _SIDE_M - _FLIGHT_M, high - _SIDE_M)


def _extent(cell: RoomSpec, side: Side) -> tuple[float, float]:
    box: Bounds = bounds(cell)
    return box[side[0]], box[side[0] + 2]


def _way(storey: StoreySpec, cell: RoomSpec, side: Side, span: tuple[float, float], leads: Leads) -> Iterator[OpeningSpec]:
    """The opening, if one room lies along all of it."""
    (own,) = _cells(storey, cell)
    axis, larger = side
    at = bounds(cell)[1 - axis + 2 * larger]
    for line in boundaries(storey):
        if (line.axis, own.id in line.rooms, None in line.rooms) == (axis, True, False) and _holds(line, at, span):
            a, b = (line.point(round(along, 3)) for along in span)
            yield OpeningSpec(rooms=(str(line.rooms[0]), str(line.rooms[1])), kind="open", start_m=a, end_m=b, leads=leads)


def _holds(line: Boundary, at: float, span: tuple[float, float]) -> bool:
    return abs(line.at - at) < 1e-6 and line.low <= span[0] and span[1] <= line.high


def _stand(
    stack: Sequence[StoreySpec], cell: RoomSpec, ways: list[list[OpeningSpec]], slab_m: float, floors: list[float]
) -> bool:
    trial = tuple(
        StoreySpec(
            rooms=tuple(room for room in storey.rooms if room.label != STAIRS or is_same_cell(room, cell)),
            openings=tuple(openings),
            height_m=storey.height_m,
        )
        for storey, openings in zip(stack, ways, strict=True)
    )
    try:
        build_stairs(HouseSpec(storeys=trial, slab_m=slab_m), floors)
    except HouseError:
        return False
    return True
