"""Room boundaries and walls: a wall is a piece of boundary that is left when the openings are cut out.

A boundary lies on the centre line of its wall. The coordinate across a boundary is y if the boundary runs along x, and x
if the boundary runs along y.
"""

import itertools
import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from shapely.geometry import Polygon, box

from worlds.arches import arch_drop
from worlds.errors import HouseError
from worlds.rectangles import polygon_sides
from worlds.spec import OpeningSpec, RoomSpec, StoreySpec

WALL_THICKNESS_M = 0.1
HALF_WALL_M = WALL_THICKNESS_M / 2
"""Distance from the centre line of a wall to its face [m]."""
FENCE_HEIGHT_M = 1.5
"""Height of walls that have no indoor room on either side [m]."""
ARCH_STRIPS = 12
"""Number of straight pieces that approximate the curve of an arch."""
_TOLERANCE_M = 1e-6


@dataclass(frozen=True)
class Boundary:
    """A straight stretch of a storey's plan that has the same room (or none) along each of its two sides."""

    axis: int
    """0: the boundary runs along x at y = `at`; 1: it runs along y at x = `at`."""
    at: float
    """Position of the boundary: its y if it runs along x, its x if it runs along y [m]."""
    low: float
    """Lower end of the boundary along its axis [m]."""
    high: float
    """Upper end of the boundary along its axis [m]."""
    rooms: tuple[str | None, str | None]
    """Ids of the rooms on both sides (None: outside). The first room is on the side of smaller y, or of smaller x if the
    boundary runs along y."""

    @property
    def length(self) -> float:
        """Length of the boundary [m]."""
        return self.high - self.low

    def point(self, along: float) -> tuple[float, float]:
        """Return the point (x, y) of the boundary at the coordinate `along` on its axis [m]."""
        return (along, self.at) if self.axis == 0 else (self.at, along)


@dataclass(frozen=True)
class Wall:
    """A solid piece of wall: an upright box along a boundary."""

    storey: int
    boundary: Boundary
    """The stretch of boundary on which the wall stands."""
    low: float
    """Lower end of the wall along the boundary; includes the corner, if the wall fills it [m]."""
    high: float
    """Upper end of the wall along the boundary; includes the corner, if the wall fills it [m]."""
    bottom_m: float
    top_m: float
    spandrel: bool = False
    """Whether the box stands for a strip of wall above an arch; the strip's real underside slopes up from `bottom_m`."""

    @property
    def rooms(self) -> tuple[str | None, str | None]:
        """Ids of the rooms on both sides; None: outside."""
        return self.boundary.rooms

    @property
    def start(self) -> tuple[float, float]:
        """End of the wall's centre line with the smaller coordinate, as (x, y) [m]."""
        return self.boundary.point(self.low)

    @property
    def end(self) -> tuple[float, float]:
        """End of the wall's centre line with the larger coordinate, as (x, y) [m]."""
        return self.boundary.point(self.high)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The rectangle that the wall covers in the plan, as (x0, y0, x1, y1) [m]."""
        (x0, y0), (x1, y1) = self.start, self.end
        dx, dy = (0.0, HALF_WALL_M) if self.boundary.axis == 0 else (HALF_WALL_M, 0.0)
        return x0 - dx, y0 - dy, x1 + dx, y1 + dy

    @property
    def footprint(self) -> Polygon:
        """The rectangle that the wall covers in the plan [m]."""
        return box(*self.bounds)


def boundaries(storey: StoreySpec) -> list[Boundary]:
    """Return all stretches of room boundary of a storey.

    The edges of all room polygons are collected by the line on which they lie, and each line is cut wherever an edge ends.
    Raises `HouseError` where two rooms lie on the same side of a stretch, which means that the rooms overlap.
    """
    lines: dict[tuple[int, float], list[tuple[float, float, int, str]]] = defaultdict(list)
    for room in storey.rooms:
        for axis, at, low, high, side in room_edges(room):
            lines[axis, at].append((low, high, side, room.id))
    return [stretch for (axis, at), edges in sorted(lines.items()) for stretch in _stretches(axis, at, edges)]


def room_edges(room: RoomSpec) -> Iterator[tuple[int, float, float, float, int]]:
    """Yield the fields (axis, at, low, high) of `Boundary` for every edge of a room, and the side on which the room lies.

    The side is 1 if the room is on the side of larger coordinates across the axis, else 0.
    """
    for (x0, y0), (x1, y1) in polygon_sides(room.polygon_m):
        if y0 == y1:
            yield 0, round(y0, 6), min(x0, x1), max(x0, x1), int(x1 > x0)
        else:
            yield 1, round(x0, 6), min(y0, y1), max(y0, y1), int(y1 < y0)


def _stretches(axis: int, at: float, edges: Sequence[tuple[float, float, int, str]]) -> Iterator[Boundary]:
    cuts = sorted({round(cut, 6) for low, high, _, _ in edges for cut in (low, high)})
    for low, high in itertools.pairwise(cuts):
        sides: list[str | None] = [None, None]
        for start, stop, side, room in edges:
            if start < high - _TOLERANCE_M and stop > low + _TOLERANCE_M:
                if sides[side] is not None:
                    raise HouseError(f"rooms {sides[side]!r} and {room!r} overlap near {_place(axis, at, low, high)}")
                sides[side] = room
        if sides != [None, None]:
            yield Boundary(axis, at, low, high, (sides[0], sides[1]))


def _place(axis: int, at: float, low: float, high: float) -> str:
    middle = (low + high) / 2
    return f"({middle:.2f}, {at:.2f}) m" if axis == 0 else f"({at:.2f}, {middle:.2f}) m"


def segment_span(start: tuple[float, float], end: tuple[float, float]) -> tuple[int, float, float, float] | None:
    """Return the fields (axis, at, low, high) of `Boundary` for a segment along x or y; None for other segments."""
    (x0, y0), (x1, y1) = start, end
    if abs(y0 - y1) <= _TOLERANCE_M < abs(x0 - x1):
        return 0, round(y0, 6), min(x0, x1), max(x0, x1)
    if abs(x0 - x1) <= _TOLERANCE_M < abs(y0 - y1):
        return 1, round(x0, 6), min(y0, y1), max(y0, y1)
    return None


def opening_span(opening: OpeningSpec) -> tuple[int, float, float, float]:
    """Return the fields (axis, at, low, high) of `Boundary` for an opening.

    Raises `HouseError` for an opening that does not run along x or y.
    """
    span = segment_span(opening.start_m, opening.end_m)
    if span is None:
        raise HouseError(
            f"opening {opening.rooms[0]!r} - {opening.rooms[1]!r}: its ends {opening.start_m} and {opening.end_m} "
            "are not on one line along x or y; valid: two different points of a wall"
        )
    return span


def split_at_openings(boundary: Boundary, openings: Sequence[OpeningSpec]) -> Iterator[tuple[Boundary, OpeningSpec | None]]:
    """Cut a boundary at the ends of the openings. Yield the pieces in order, each with its opening, or None for wall."""
    position = boundary.low
    spans = sorted((opening_span(opening), i) for i, opening in enumerate(openings))
    for (axis, at, low, high), i in spans:
        low, high = max(low, boundary.low), min(high, boundary.high)
        if (axis, at) != (boundary.axis, boundary.at) or high <= low + _TOLERANCE_M:
            continue
        if low > position + _TOLERANCE_M:
            yield _cut(boundary, position, low), None
        yield _cut(boundary, low, high), openings[i]
        position = high
    if boundary.high > position + _TOLERANCE_M:
        yield _cut(boundary, position, boundary.high), None


def _cut(boundary: Boundary, low: float, high: float) -> Boundary:
    return Boundary(boundary.axis, boundary.at, low, high, boundary.rooms)


def corners(stretches: Sequence[Boundary]) -> set[tuple[float, float]]:
    """Return the points (x, y) where walls along x and y meet; walls that end there are lengthened to fill the corner."""
    ends: tuple[set[tuple[float, float]], set[tuple[float, float]]] = set(), set()
    for stretch in stretches:
        ends[stretch.axis].update((stretch.point(stretch.low), stretch.point(stretch.high)))
    return ends[0] & ends[1]


def wall_extent(piece: Boundary, meeting: set[tuple[float, float]]) -> tuple[float, float]:
    """Return the lower and the upper end of a wall along a piece of boundary [m].

    The wall is half a thickness longer than the piece at each end that lies in `meeting`, the result of `corners`.
    """
    low = piece.low - HALF_WALL_M if piece.point(piece.low) in meeting else piece.low
    return low, piece.high + HALF_WALL_M if piece.point(piece.high) in meeting else piece.high


def wall_spans(opening: OpeningSpec | None, height_m: float) -> list[tuple[float, float]]:
    """Return the heights above the floor of the parts of a wall below and above an opening, as (lower, upper end) [m].

    The wall is `height_m` [m] high. Without an opening, the only part is the whole wall.
    """
    if opening is None:
        return [(0.0, height_m)]
    low, high = opening.gap_m(height_m)
    return [span for span in ((0.0, min(low, height_m)), (high, height_m)) if span[1] > span[0]]


def arch_curve(boundary: Boundary, opening: OpeningSpec, top_m: float) -> list[tuple[float, float]]:
    """Return points of an arch's curve, as (coordinate along the boundary, height above the floor, at most `top_m`) [m]."""
    _, _, low, high = opening_span(opening)
    half = (high - low) / 2
    turns = [math.pi * i / ARCH_STRIPS for i in range(ARCH_STRIPS + 1)]
    places = [max(boundary.low, min(boundary.high, low + half * (1.0 - math.cos(turn)))) for turn in turns]
    return [(a, min(top_m, opening.height_m - arch_drop(2 * half, a - low - half))) for a in dict.fromkeys(places)]
