"""Turns drawn outlines into rectilinear polygons.

1. `main_direction` finds the direction of most walls, and `turned` rotates the plan so that these walls run along x and y.
2. `straighten` turns each wall into a line along x or y, merges lines that nearly coincide, and intersects the lines of
   consecutive walls.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from worlds.errors import SpecError
from worlds.plan_import.drawn_plan import DrawnRoom
from worlds.rectangles import polygon_sides
from worlds.spec import Point

_SLOPE = 0.02
"""Greatest slope, relative to x or y, of a wall that is taken to run along this axis [m/m]. In addition, each end of the
wall may be off by `snap_m`."""
_AGREE_RAD = math.radians(3.0)
"""Largest angle between walls that count as having the same direction [rad]."""
_LEAST_AREA_M2 = 0.25
"""Least area of a room [m²]."""
_ROUNDING_M = 1e-6
"""Tolerance for rounding [m]: lines 0.1 m apart in a file may be slightly more than 0.1 m apart in floating point."""
_TURN_RAD = 1e-3
"""Least angle between a plan's main direction and the axes at which the plan is turned to the axes [rad]."""


def main_direction(rooms: Sequence[DrawnRoom]) -> float:
    """Return the angle from the x and y axes to the walls, counter-clockwise, in [-pi/4, pi/4] [rad].

    The angle is 0 if the walls that agree on a direction make up less than half of the total length of all walls, or if no
    wall has a length.
    """
    edges = [edge for room in rooms for edge in polygon_sides(room.corners)]
    length = np.array([math.dist(a, b) for a, b in edges])
    angle = np.array([math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in edges])
    # Directions modulo 90 degrees, weighted by length. Only walls near the most common one enter the mean, so that a few
    # oblique walls do not shift it.
    by_degree = np.bincount((np.degrees(angle) % 90.0).astype(int) % 90, length, 90)
    near_by = by_degree + np.roll(by_degree, 1) + np.roll(by_degree, -1)
    mode = math.radians(float(np.argmax(near_by)) + 0.5)
    off = (angle - mode + math.pi / 4) % (math.pi / 2) - math.pi / 4
    agree = np.abs(off) <= _AGREE_RAD
    if length[agree].sum() < 0.5 * length.sum() or not length[agree].any():
        return 0.0
    main = mode + float(np.average(off[agree], weights=length[agree]))
    main = (main + math.pi / 4) % (math.pi / 2) - math.pi / 4
    return main if abs(main) > _TURN_RAD else 0.0


def turned(points: Sequence[Point], angle: float) -> tuple[Point, ...]:
    """Return the points, rotated clockwise about the origin by `angle` [rad]."""
    cos, sin = math.cos(angle), math.sin(angle)
    return tuple((cos * x + sin * y, cos * y - sin * x) for x, y in points) if angle else tuple(points)


def straighten(outlines: Sequence[tuple[DrawnRoom, tuple[Point, ...]]], snap_m: float) -> list[tuple[Point, ...]]:
    """Return rectilinear, counter-clockwise polygons for outlines that have been turned to the axes.

    Raises `SpecError`, which names the room, if a wall runs along neither x nor y, if a room has too few corners, and if
    nothing, or too small an area, is left of a room once its corners have moved to common lines.
    """
    walls = [list(_walls(room, corners, snap_m)) for room, corners in outlines]
    x, y = (_common_lines([at for room in walls for axis, at in room if axis == across], snap_m) for across in (1, 0))
    polygons = []
    for (room, _), around in zip(outlines, walls, strict=True):
        lines = [(axis, (y if axis == 0 else x)[at]) for axis, at in around]
        polygon = _corners(lines)
        if len(polygon) < 4:
            raise SpecError(
                f"{room.where}: nothing is left of the room once its corners have snapped to common lines; "
                f"valid: a room wider than {snap_m} m"
            )
        if (area := abs(_area(polygon))) < _LEAST_AREA_M2:
            raise SpecError(f"{room.where}: has an area of {area:.3g} m²; valid: at least {_LEAST_AREA_M2} m²")
        polygons.append(polygon if _area(polygon) > 0 else polygon[::-1])
    return polygons


def _walls(room: DrawnRoom, corners: Sequence[Point], snap_m: float) -> Iterator[tuple[int, float]]:
    """Yield (0, y) for each wall along x and (1, x) for each wall along y, in their order around the room.

    Edges no longer than `snap_m` are left out. Raises `SpecError` if a wall runs along neither x nor y, or if fewer than 4
    corners are left.
    """
    kept = [corner for corner, after in polygon_sides(corners) if math.dist(corner, after) > snap_m]
    if len(kept) < 4:
        raise SpecError(
            f"{room.where}: has too few corners; valid: at least 4 corners farther apart than {snap_m} m, at the scale of "
            "the plan and after all transforms"
        )
    for i, ((x0, y0), (x1, y1)) in enumerate(polygon_sides(kept)):
        dx, dy = abs(x1 - x0), abs(y1 - y0)
        if min(dx, dy) > 2 * snap_m + _SLOPE * max(dx, dy) or min(dx, dy) > 0.5 * max(dx, dy):
            raise SpecError(
                f"{room.where}: the wall from corner {i} ({x0:.2f}, {y0:.2f}) m to ({x1:.2f}, {y1:.2f}) m is oblique; "
                "valid: walls at right angles"
            )
        yield (0, (y0 + y1) / 2) if dx > dy else (1, (x0 + x1) / 2)


def _common_lines(values: list[float], snap_m: float) -> dict[float, float]:
    """Group the coordinates of walls, and return the common line of its group for the coordinate of every wall [m].

    Neighbouring coordinates in a group differ by at most `snap_m`, and the whole group spans at most 2 `snap_m`.
    """
    groups: list[list[float]] = []
    for value in sorted(values):
        if groups and value - groups[-1][0] <= 2 * snap_m + _ROUNDING_M and value - groups[-1][-1] <= snap_m + _ROUNDING_M:
            groups[-1].append(value)
        else:
            groups.append([value])
    return {value: _line(group) for group in groups for value in group}


def _line(group: Sequence[float]) -> float:
    """Return the common line of a group of coordinates [m].

    If more than half of the coordinates are equal when rounded to 1 mm, the line is at this value. Otherwise it is at the
    mean of all coordinates, rounded to 1 mm.
    """
    millimetres = Counter(round(value, 3) for value in group)
    (line, times), middle = millimetres.most_common(1)[0], sum(group) / len(group)
    return line + 0.0 if 2 * times > len(group) else round(middle, 3) + 0.0


def _corners(lines: Sequence[tuple[int, float]]) -> tuple[Point, ...]:
    """Return the corners of a room: the intersections of consecutive walls.

    The walls in `lines` are given as (axis, coordinate). Consecutive walls along the same axis are merged and walls of zero
    length are dropped, again and again, until neither occurs. The result is empty if fewer than 4 walls are left.
    """
    around = list(lines)
    while True:
        merged = [wall for wall, after in zip(around, around[1:] + around[:1], strict=True) if wall[0] != after[0]]
        corners = [(a[1], b[1]) if a[0] else (b[1], a[1]) for a, b in zip(merged, merged[1:] + merged[:1], strict=True)]
        # The wall between corners i-1 and i is merged[i]; it has zero length if both corners are the same point.
        left = [wall for i, wall in enumerate(merged) if corners[i - 1] != corners[i]]
        if left == around or len(left) < 4:
            return tuple(corners) if len(left) >= 4 else ()
        around = left


def _area(polygon: Sequence[Point]) -> float:
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in polygon_sides(polygon)) / 2
