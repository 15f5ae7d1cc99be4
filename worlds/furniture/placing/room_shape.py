"""`RoomShape`: the outline of a room in its own coordinates, with the origin at the least x and y of its bounding box."""

from dataclasses import dataclass
from functools import cached_property

from worlds.rectangles import Rectangle, notches, polygon_sides
from worlds.spec import RoomSpec

Interval = tuple[float, float]
Point = tuple[float, float]

EPS_M = 1e-4
AXES: tuple[Point, ...] = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
"""Direction of the x axis of a piece after 0 to 3 quarter turns; its front faces a quarter turn further on."""
_DIGITS = 6
"""Decimals that coordinates are rounded to, so that rooms that differ only in position are identical to the last bit."""


@dataclass(frozen=True)
class RoomSide:
    """A side of a room: a directed line with the room on its left."""

    start: Point
    """First corner of the side [m]."""
    turn: int
    """Direction of the side, `AXES[turn]`; a piece with its back to the wall has the same rotation."""
    length: float
    """Length of the side [m]."""

    def at(self, t: float, off: float) -> Point:
        """Return the point at distance `t` along the side and `off` into the room [m]."""
        (tx, ty), (nx, ny) = AXES[self.turn], AXES[self.turn - 3]
        return self.start[0] + t * tx + off * nx, self.start[1] + t * ty + off * ny

    def along(self, point: Point) -> float:
        """Return the distance of a point from the start of the side, measured along the side [m]."""
        tx, ty = AXES[self.turn]
        return (point[0] - self.start[0]) * tx + (point[1] - self.start[1]) * ty

    def rectangle(self, low: float, high: float, depth: float) -> Rectangle:
        """Return the rectangle in front of the stretch `low` ... `high` of the side, `depth` into the room [m]."""
        (ax, ay), (bx, by) = self.at(low, 0.0), self.at(high, depth)
        return min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)

    def interval(self, a: Point, b: Point) -> Interval | None:
        """Return the part of the segment from `a` to `b` on this side, as distances from the start of the side [m].

        The result is None if no part of the segment lies on the side.
        """
        off = 1 if self.turn % 2 == 0 else 0
        if abs(a[off] - self.start[off]) > EPS_M or abs(b[off] - self.start[off]) > EPS_M:
            return None
        ta, tb = self.along(a), self.along(b)
        low, high = max(0.0, min(ta, tb)), min(self.length, max(ta, tb))
        return (low, high) if high - low > EPS_M else None


@dataclass(frozen=True)
class RoomShape:
    """Outline of a rectilinear room."""

    origin: Point
    """Corner of the bounding box with least x and y, in the storey's coordinates [m]."""
    corners: tuple[Point, ...]
    """Corners in the room's own coordinates [m]."""

    @staticmethod
    def of(room: RoomSpec) -> "RoomShape":
        """Return the shape of a room's polygon."""
        polygon = room.polygon_m
        origin = min(x for x, _ in polygon), min(y for _, y in polygon)
        return RoomShape(origin, tuple(_less(point, origin) for point in polygon))

    def local(self, point: Point) -> Point:
        """Convert a point from the storey's to the room's coordinates [m]."""
        return _less(point, self.origin)

    @cached_property
    def size(self) -> Point:
        """Width along x and depth along y of the bounding box [m]."""
        return max(x for x, _ in self.corners), max(y for _, y in self.corners)

    @cached_property
    def area_m2(self) -> float:
        """Area of the room [m²]."""
        return 0.5 * abs(sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in polygon_sides(self.corners)))

    @cached_property
    def sides(self) -> tuple[RoomSide, ...]:
        """The sides, in the order of the polygon."""
        sides = []
        for (x0, y0), (x1, y1) in polygon_sides(self.corners):
            turn = (0 if x1 > x0 else 2) if y0 == y1 else (1 if y1 > y0 else 3)
            sides.append(RoomSide((x0, y0), turn, abs(x1 - x0) + abs(y1 - y0)))
        return tuple(sides)

    @cached_property
    def notches(self) -> tuple[Rectangle, ...]:
        """Rectangles that cover the part of the bounding box outside the room [m]."""
        return tuple(notches(self.corners))


def _less(point: Point, origin: Point) -> Point:
    return round(point[0] - origin[0], _DIGITS), round(point[1] - origin[1], _DIGITS)
