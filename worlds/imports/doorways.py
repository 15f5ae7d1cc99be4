"""Openings of an imported plan: drawn strokes go to the nearest wall between two rooms; without any, doors are made up."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from worlds.errors import SpecError
from worlds.imports.drawing import Stroke
from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.layout import Link, StoreyLayout
from worlds.openings import CORNER_M, MIN_DOOR_M, place_openings
from worlds.spec import LeafSpec, OpeningSpec, Point, RoomSpec, StoreySpec
from worlds.stair_cells import Leads, bounds
from worlds.walls import Boundary, boundaries

NEAR_M = 0.3
"""A stroke belongs to a wall that is so near."""
_DOOR_M = 0.9
_HUBS = ("corridor", "entrance hall", "lobby", "open-plan office", "living room")
_SIDE_M = 0.05


def on_walls(stroke: Stroke, points: Sequence[Point], storey: StoreySpec, ids: dict[str, str]) -> OpeningSpec | None:
    """The opening that a stroke (its turned points) means; None where it leads out of the house.

    `ids`: of rooms, by their names as drawn. Raises `SpecError` where there is no wall near, or one that is too short.
    """
    middle = (points[0][0] + points[-1][0]) / 2, (points[0][1] + points[-1][1]) / 2
    near = [line for line in boundaries(storey) if _distance(line, middle) <= NEAR_M]
    shared = [line for line in near if None not in line.rooms]
    if not shared:
        if near:
            return None
        raise SpecError(
            f"{stroke.where}: no wall between two rooms is within {NEAR_M} m of the {stroke.kind} at "
            f"({middle[0]:.2f}, {middle[1]:.2f}) m"
        )
    line = min(shared, key=lambda line: (_spread(line, points) < _spread_across(line, points), _distance(line, middle)))
    start, end = (point[line.axis] for point in (points[0], points[-1]))
    if abs(end - start) < _spread_across(line, points) or start == end:
        start, end = middle[line.axis] - _DOOR_M / 2, middle[line.axis] + _DOOR_M / 2
    low, high = _fitted(stroke, line, min(start, end), max(start, end))
    ends = (low, high) if start < end else (high, low)
    a, b = (line.point(round(along, 6)) for along in ends)
    rooms = str(line.rooms[0]), str(line.rooms[1])
    return OpeningSpec(rooms=rooms, kind=stroke.kind, start_m=a, end_m=b, **_details(stroke, rooms, ids))


def _distance(line: Boundary, point: Point) -> float:
    along, across = point[line.axis], point[1 - line.axis]
    return math.hypot(max(line.low - along, 0.0, along - line.high), across - line.at)


def _spread(line: Boundary, points: Sequence[Point]) -> float:
    return abs(points[-1][line.axis] - points[0][line.axis])


def _spread_across(line: Boundary, points: Sequence[Point]) -> float:
    return abs(points[-1][1 - line.axis] - points[0][1 - line.axis])


def _fitted(stroke: Stroke, line: Boundary, low: float, high: float) -> tuple[float, float]:
    """The part of the wall that is meant: strokes end a little beside it, or stand a little off."""
    if high - low > line.length + 2 * NEAR_M:
        raise SpecError(
            f"{stroke.where}: the {stroke.kind} is {high - low:.2f} m wide, but the wall between {line.rooms[0]!r} and "
            f"{line.rooms[1]!r} {line.length:.2f} m long"
        )
    width = min(high - low, line.length)
    low = min(max(low, line.low), line.high - width)
    return low, low + width


def _details(stroke: Stroke, rooms: tuple[str, str], ids: dict[str, str]) -> dict[str, Any]:
    details = dict(stroke.details)
    if isinstance(leaf := details.get("leaf"), dict):
        into = ids.get(str(leaf.get("into")), "")
        if into not in rooms:
            raise SpecError(f"{stroke.where}: its leaf swings into {leaf.get('into')!r}; valid: {' or '.join(rooms)}")
        details["leaf"] = LeafSpec.model_validate({**leaf, "into": into})
    return details


def made_up(storeys: Sequence[StoreySpec]) -> Iterator[tuple[int, tuple[OpeningSpec, ...]]]:
    """For each storey, openings that let one walk from every room to every other. Raises `WorldsError`."""
    sides = _sides_of_stairs(storeys)
    for level, storey in enumerate(storeys):
        stairs = tuple(
            _way(level, room, sides[bounds(room)], leads, storey)
            for room in storey.rooms
            if room.label == STAIRS
            for leads, other in _flights(level)
            if 0 <= other < len(storeys) and any(bounds(room) == bounds(cell) for cell in _cells(storeys[other]))
        )
        layout = StoreyLayout(storey.rooms, tuple(_links(storey)), stairs, storey.height_m)
        yield level, place_openings(layout, np.random.default_rng(0))


def _flights(level: int) -> tuple[tuple[Leads, int], tuple[Leads, int]]:
    return ("up", level + 1), ("down", level - 1)


def _links(storey: StoreySpec) -> Iterator[Link]:
    """A tree of doors through the rooms: through halls rather than rooms, through long walls rather than short ones."""
    label = {room.id: room.label for room in storey.rooms}
    walls: dict[tuple[str, str], float] = {}
    for line in boundaries(storey):
        a, b = line.rooms
        if a is not None and b is not None and STAIRS not in (label[a], label[b]):
            pair = (min(a, b), max(a, b))
            walls[pair] = max(line.length, walls.get(pair, 0.0))
    wide = [pair for pair, length in walls.items() if length >= MIN_DOOR_M + 2 * CORNER_M]
    group = {room: room for room in label}
    for a, b in sorted(wide, key=lambda pair: (_rank(label[pair[0]], label[pair[1]]), -walls[pair], pair)):
        if group[a] != group[b]:
            old, new = group[a], group[b]
            group = {room: new if its == old else its for room, its in group.items()}
            yield Link((a, b))


def _rank(a: str, b: str) -> int:
    hubs = [_HUBS.index(label) for label in (a, b) if label in _HUBS]
    return min(hubs, default=len(_HUBS)) + 10 * (a in OUTDOOR_LABELS or b in OUTDOOR_LABELS)


def _cells(storey: StoreySpec) -> list[RoomSpec]:
    return [room for room in storey.rooms if room.label == STAIRS]


def _sides_of_stairs(storeys: Sequence[StoreySpec]) -> dict[tuple[float, ...], tuple[int, float]]:
    """For every cell, the side (axis and coordinate of its wall) that one room lies along on each of its storeys."""
    sides: dict[tuple[float, ...], set[tuple[int, float]]] = {}
    for storey in storeys:
        for cell in _cells(storey):
            x0, y0, x1, y1 = bounds(cell)
            long = {(0, y0): x1 - x0, (0, y1): x1 - x0, (1, x0): y1 - y0, (1, x1): y1 - y0}
            whole = {
                (line.axis, line.at)
                for line in boundaries(storey)
                if cell.id in line.rooms
                and None not in line.rooms
                and line.length >= long.get((line.axis, line.at), math.inf)
            }
            sides[x0, y0, x1, y1] = sides.get((x0, y0, x1, y1), whole) & whole
    short = {
        cell: sorted(found, key=lambda side: (cell[side[0] + 2] - cell[side[0]], side)) for cell, found in sides.items()
    }
    return {cell: found[0] for cell, found in short.items() if found} | {
        cell: (-1, 0.0) for cell in short if not short[cell]
    }


def _way(level: int, room: RoomSpec, side: tuple[int, float], leads: Leads, storey: StoreySpec) -> OpeningSpec:
    axis = side[0]
    if axis < 0:
        raise SpecError(
            f"no side of stairs {room.id!r} has one room along all of it on every storey, so there is no place to make up "
            "their openings; draw them"
        )
    low, high = bounds(room)[axis], bounds(room)[axis + 2]
    middle = (low + high) / 2
    ends = (low + _SIDE_M, middle) if leads == "up" else (middle, high - _SIDE_M)
    line = next(line for line in boundaries(storey) if (line.axis, line.at) == side and room.id in line.rooms)
    a, b = (line.point(round(along, 6)) for along in ends)
    rooms = str(line.rooms[0]), str(line.rooms[1])
    return OpeningSpec(rooms=rooms, kind="open", start_m=a, end_m=b, leads=leads)
