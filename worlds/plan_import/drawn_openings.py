"""Openings of an imported plan: each drawn stroke is moved onto the nearest wall."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from typing import Any

from worlds.errors import SpecError
from worlds.plan_import.drawn_plan import Stroke, validated
from worlds.spec import LeafSpec, OpeningSpec, Point, StoreySpec
from worlds.walls import Boundary, boundaries, opening_span

NEAR_M = 0.3
"""Largest distance from a stroke to the wall that it belongs to [m]."""
_DOOR_M = 0.9
"""Width of an opening if its stroke is only a point, or runs across the wall instead of along it [m]."""
_SAME_M = 0.05
"""Largest distance between the ends of two openings that are taken for one [m]."""
_OVERLAP_M = 0.1
"""Largest overlap of two openings that is taken for an imprecise drawing and removed [m]."""


def opening_on_wall(
    stroke: Stroke, points: Sequence[Point], storey: StoreySpec, names: Mapping[str, str]
) -> OpeningSpec | None:
    """Return the opening that a stroke stands for, or None if the stroke lies on an outer wall of the house.

    The stroke belongs to the nearest wall along it, or if there is none, to the nearest wall across it. Of two equally near
    walls, it belongs to the wall between two rooms.

    Args:
        stroke: the stroke as drawn.
        points: the points of the stroke after the plan was turned and moved [m].
        storey: the storey that the stroke lies on.
        names: the name of each room in the drawing, which may be empty, by the room's id.

    Raises:
        SpecError: if no wall is near, the wall is much shorter than the stroke, or its door leaf swings into another room.
    """
    middle = (points[0][0] + points[-1][0]) / 2, (points[0][1] + points[-1][1]) / 2
    near = [line for line in boundaries(storey) if _distance(line, middle) <= NEAR_M]
    if not near:
        raise SpecError(
            f"{stroke.where}: no wall between two rooms is within {NEAR_M} m of the {stroke.kind} at "
            f"({middle[0]:.2f}, {middle[1]:.2f}) m"
        )

    def unlikeness(line: Boundary) -> tuple[bool, float, bool]:
        runs_across = _span_along(line, points) < _span_across(line, points)
        return runs_across, round(_distance(line, middle), 6), None in line.rooms

    line = min(near, key=unlikeness)
    if None in line.rooms:
        return None
    start, end = (point[line.axis] for point in (points[0], points[-1]))
    if abs(end - start) < _span_across(line, points) or start == end:
        start, end = middle[line.axis] - _DOOR_M / 2, middle[line.axis] + _DOOR_M / 2
    low, high = _fitted_to_wall(stroke, line, min(start, end), max(start, end))
    ends = (low, high) if start < end else (high, low)
    a, b = (line.point(round(along, 6)) for along in ends)
    rooms = str(line.rooms[0]), str(line.rooms[1])
    details = _details(stroke, rooms, names)
    return validated(stroke.where, OpeningSpec, rooms=rooms, kind=stroke.kind, start_m=a, end_m=b, **details)


def _distance(line: Boundary, point: Point) -> float:
    along, across = point[line.axis], point[1 - line.axis]
    return math.hypot(max(line.low - along, 0.0, along - line.high), across - line.at)


def _span_along(line: Boundary, points: Sequence[Point]) -> float:
    return abs(points[-1][line.axis] - points[0][line.axis])


def _span_across(line: Boundary, points: Sequence[Point]) -> float:
    return abs(points[-1][1 - line.axis] - points[0][1 - line.axis])


def _fitted_to_wall(stroke: Stroke, line: Boundary, low: float, high: float) -> tuple[float, float]:
    """Return both ends of the opening, as coordinates along the wall [m], moved and cut so that it lies within the wall.

    `low` and `high` are the ends of the stroke along the wall [m]. Raises `SpecError` if the stroke is longer than the wall
    by more than 2 `NEAR_M`.
    """
    if high - low > line.length + 2 * NEAR_M:
        raise SpecError(
            f"{stroke.where}: the {stroke.kind} is {high - low:.2f} m wide, but the wall between {line.rooms[0]!r} and "
            f"{line.rooms[1]!r} is only {line.length:.2f} m long"
        )
    width = min(high - low, line.length)
    low = min(max(low, line.low), line.high - width)
    return low, low + width


def _details(stroke: Stroke, rooms: tuple[str, str], names: Mapping[str, str]) -> dict[str, Any]:
    """Return the further fields of an opening; its door leaf may name one of the two `rooms` by its id or as drawn."""
    details = dict(stroke.details)
    if isinstance(leaf := details.get("leaf"), dict):
        named = {names[room]: room for room in rooms} | {room: room for room in rooms}
        into = named.get(str(leaf.get("into")))
        if into is None:
            raise SpecError(f"{stroke.where}: the door leaf swings into {leaf.get('into')!r}; valid: {' or '.join(rooms)}")
        details["leaf"] = validated(stroke.where, LeafSpec, **{**leaf, "into": into})
    return details


def is_drawn_again(opening: OpeningSpec, other: OpeningSpec) -> bool:
    """Return whether two openings are one that was drawn twice, perhaps in the other direction or not quite alike."""
    ends, others = (sorted((each.start_m, each.end_m)) for each in (opening, other))
    same = opening.kind == other.kind and set(opening.rooms) == set(other.rooms)
    return same and all(math.dist(a, b) <= _SAME_M for a, b in zip(ends, others, strict=True))


def without_overlaps(openings: Mapping[OpeningSpec, str]) -> tuple[OpeningSpec, ...]:
    """Return the openings, with small overlaps removed. `openings` maps each opening to its place in the file, for messages.

    If two openings in one line overlap by at most 0.1 m, both are cut, so that they meet in the middle of the overlap.
    Raises `SpecError` if they overlap by more.
    """
    placed, where = list(openings), list(openings.values())
    for i, j in combinations(range(len(placed)), 2):
        (axis, at, low, high), (*line, start, stop) = opening_span(placed[i]), opening_span(placed[j])
        overlap = min(high, stop) - max(low, start)
        if [axis, at] != line or overlap <= 0.0:
            continue
        if overlap > _OVERLAP_M:
            raise SpecError(f"{where[i]} and {where[j]} overlap by {overlap:.2f} m; valid: openings that at most touch")
        first, second = (i, j) if low + high < start + stop else (j, i)
        meet = round((min(high, stop) + max(low, start)) / 2, 6)
        placed[first], placed[second] = (
            _with_end_at(placed[first], axis, meet, max),
            _with_end_at(placed[second], axis, meet, min),
        )
    return tuple(placed)


def _with_end_at(opening: OpeningSpec, axis: int, along: float, end: Callable[[float, float], float]) -> OpeningSpec:
    """Return the opening with its upper end (`end` is `max`) or its lower end (`end` is `min`) moved to `along` [m]."""
    moved = end(opening.start_m[axis], opening.end_m[axis])
    a, b = (
        (along if axis == 0 else x, along if axis == 1 else y) if (x, y)[axis] == moved else (x, y)
        for x, y in (opening.start_m, opening.end_m)
    )
    return opening.model_copy(update={"start_m": a, "end_m": b})
