"""`fit_stairs`: straight, L- and U-shaped stairs in a rectangular cell, and the rules that make them walkable.

Everything here concerns one flight, the stairs from one storey to the next. It consists of one or two straight runs of
steps, with a landing between two runs. Coordinates are those of the stairs' cell (their room) [m]: u points inwards from the
side where the climb begins, and v is perpendicular to u; both are measured from wall centre lines. z is the height above the
lower floor. In the drawings, the arrows point up the stairs.

    straight          L                     U
    +---------+       +------+--------+     +-------------+
    |    ^    |       | turn |  ====> |     |   landing   |
    |    |    |       +------+--------+     +------+------+      u
    |    |    |       |  ^   |              |  ^   |  |   |      ^
    |    |    |       |  |   |   void       |  |   |  v   |      |
    +---------+       +------+--------+     +------+------+      +--> v
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from worlds.walls import HALF_WALL_M

StairsKind = Literal["straight", "L", "U"]

MAX_RISER_M = 0.19
MIN_TREAD_M = 0.22
MIN_RUN_WIDTH_M = 0.8
"""Least width of a run of steps [m]. A landing is at least as long as its run is wide."""
MAX_RUN_RISE_M = 3.7
"""Greatest rise of straight stairs without a landing half way [m]."""
OPEN_SIDE_M = 1.0
"""Greatest drop beside a step, landing or floor without a railing on that side [m]."""
_USUAL_TREAD_M = 0.3
"""Greatest depth of a tread, however long the cell is [m]."""
_USUAL_L_WIDTHS_M = (1.0, 0.9)
"""Widths that are tried for the runs of an L-shape, in this order [m]; `MIN_RUN_WIDTH_M` is the last resort."""
_USUAL_L_TREAD_M = 0.26
"""Least depth of the treads of an L-shape with one of these widths [m]. If the treads would be less deep, the next smaller
width is tried."""
_TOLERANCE_M = 1e-6

Point = tuple[float, float, float]


def cell_needed(
    kind: StairsKind, rise_m: float, tread_m: float = MIN_TREAD_M, width_m: float = MIN_RUN_WIDTH_M
) -> tuple[float, float]:
    """Return the least length (along the first run of steps) and width of a cell (a room) for stairs [m].

    Both are measured between wall centre lines, and rounded up to the centimetre. `rise_m` is the height from floor to
    floor. The treads are to be `tread_m` deep, and the runs of steps `width_m` wide.
    """
    n = risers(kind, rise_m)
    if kind == "straight":
        landing = width_m - tread_m if rise_m > MAX_RUN_RISE_M else 0.0
        return _rounded_up(n * tread_m + landing), _rounded_up(width_m + 2 * HALF_WALL_M)
    first = (n + 1) // 2
    length = _rounded_up((first - 0.5) * tread_m + width_m + HALF_WALL_M)
    if kind == "U":
        return length, _rounded_up(2 * width_m + 2 * HALF_WALL_M)
    return length, _rounded_up((n - first - 0.5) * tread_m + width_m + HALF_WALL_M)


def risers(kind: StairsKind, rise_m: float) -> int:
    """Return the number of risers of stairs that rise by `rise_m` [m]; an even number for U-shapes, with two equal runs."""
    if kind == "U":
        return 2 * math.ceil(rise_m / 2 / MAX_RISER_M - _TOLERANCE_M)
    return math.ceil(rise_m / MAX_RISER_M - _TOLERANCE_M)


def _rounded_up(length_m: float) -> float:
    return math.ceil(100 * length_m - _TOLERANCE_M) / 100


@dataclass(frozen=True)
class Slab:
    """A level rectangle to stand on: a step, a landing or a piece of floor. `CellFrame` defines its coordinates u and v."""

    u: tuple[float, float]
    """Interval that the slab covers along u, the direction inwards from the side where the climb begins [m]."""
    v: tuple[float, float]
    """Interval that the slab covers along v, at a right angle to u [m]."""
    top: float
    """Height of the slab's upper face above the lower storey's floor [m]."""


@dataclass(frozen=True)
class Rail:
    """A straight railing on the open side of a slab (step, landing or floor), between two points at the slab's height."""

    start: Point
    end: Point


@dataclass(frozen=True)
class StairsLayout:
    """The stairs from one storey to the next, in the coordinates of their room (`CellFrame`)."""

    tread_m: float
    """Depth of every tread [m]."""
    width_m: float
    """Width of the runs of steps [m]."""
    treads: tuple[Slab, ...]
    """Steps and landings, from the lowest to the highest."""
    foot: Slab
    """Floor in the cell (the room of the stairs) before the first riser, level with the lower storey."""
    head: Slab
    """Floor in the cell (the room of the stairs) after the last riser, level with the upper storey."""
    line: tuple[Point, ...]
    """Walking line from the side of the cell where the climb begins to the side where it ends. The line is straight along
    every run of steps, and passes the middle of each tread at the tread's height."""
    rails: tuple[Rail, ...]

    @property
    def is_walkable(self) -> bool:
        """Whether treads are deep enough and runs wide enough to walk on. Risers and landings need no check."""
        return self.tread_m >= MIN_TREAD_M - _TOLERANCE_M and self.width_m >= MIN_RUN_WIDTH_M - _TOLERANCE_M


def fit_stairs(kind: StairsKind, length: float, width: float, rise: float, above_void: bool) -> StairsLayout:
    """Fit stairs into a room of `length` (along the first run of steps) by `width`, for a `rise` from floor to floor [m].

    Treads are as deep as the room allows, up to 0.3 m. If the room is too small, the result is not walkable. `above_void`
    says that there is no floor beside the stairs on the lower storey. L-shaped stairs then have railings along their whole
    open side.
    """
    match kind:
        case "straight":
            return _straight(length, width, rise)
        case "U":
            return _u_shaped(length, width, rise)
        case "L":
            return _l_shaped(length, width, rise, above_void)


@dataclass(frozen=True)
class _Run:
    """A straight run of steps. It has one tread fewer than risers, because the last riser leads to a landing or floor."""

    start: Point
    """Middle of the lower edge of the first riser [m]."""
    along: tuple[int, int]
    """Direction of the climb in (u, v)."""
    risers: int
    """Number of risers of the run."""
    riser: float
    """Height of each riser [m]."""
    tread: float
    """Depth of each tread [m]."""
    width: float

    def treads(self) -> list[Slab]:
        return [self.slab((i - 1) * self.tread, i * self.tread, i * self.riser) for i in range(1, self.risers)]

    def slab(self, begin: float, end: float, rise: float) -> Slab:
        """Return a slab as wide as the run, from `begin` to `end` behind the first riser, `rise` above the start [m]."""
        (u, v, z), (du, dv), half = self.start, self.along, self.width / 2
        us, vs = (u + du * begin, u + du * end), (v + dv * begin, v + dv * end)
        across_u, across_v = half * abs(dv), half * abs(du)
        return Slab((min(us) - across_u, max(us) + across_u), (min(vs) - across_v, max(vs) + across_v), z + rise)

    def at(self, distance: float, rise: float) -> Point:
        (u, v, z), (du, dv) = self.start, self.along
        return u + du * distance, v + dv * distance, z + rise

    def line(self) -> list[Point]:
        """Return both ends of the walking line: half a tread before the first riser, and half a tread after the last riser.

        The straight line between these ends passes the middle of each tread at the tread's height.
        """
        return [self.at(-self.tread / 2, 0.0), self.at((self.risers - 0.5) * self.tread, self.risers * self.riser)]


def _straight(length: float, width: float, rise: float) -> StairsLayout:
    n, clear = risers("straight", rise), width - 2 * HALF_WALL_M  # the run fills the width between the walls' faces
    landing = clear if rise > MAX_RUN_RISE_M else 0.0
    steps = (n, 0) if not landing else ((n + 1) // 2, n // 2)
    riser, going = rise / n, n - (landing > 0.0)
    # Half a tread of floor is kept before the first riser and after the last, for the walking line to begin and end in.
    tread = min(_USUAL_TREAD_M, (length - landing) / going)
    begin = (length - landing - (going - 1) * tread) / 2
    middle = width / 2
    runs = [_Run((begin, middle, 0.0), (1, 0), steps[0], riser, tread, clear)]
    treads, end = runs[0].treads(), begin + (steps[0] - 1) * tread
    if landing:
        treads.append(runs[0].slab(end - begin, end - begin + landing, steps[0] * riser))
        runs.append(_Run((end + landing, middle, steps[0] * riser), (1, 0), steps[1], riser, tread, clear))
        treads += runs[1].treads()
    side = (HALF_WALL_M, width - HALF_WALL_M)
    foot, head = Slab((0.0, begin), side, 0.0), Slab((length - begin, length), side, rise)
    line = _line((0.0, middle, 0.0), runs, (), (length, middle, rise))
    return StairsLayout(tread, clear, tuple(treads), foot, head, line, ())


def _u_shaped(length: float, width: float, rise: float) -> StairsLayout:
    n, clear = risers("U", rise) // 2, (width - 2 * HALF_WALL_M) / 2
    riser = rise / (2 * n)
    tread = min(_USUAL_TREAD_M, (length - HALF_WALL_M - clear) / (n - 0.5))
    begin, edge = tread / 2, (n - 0.5) * tread
    near, far = HALF_WALL_M + clear / 2, HALF_WALL_M + 1.5 * clear
    up = _Run((begin, near, 0.0), (1, 0), n, riser, tread, clear)
    back = _Run((edge, far, rise / 2), (-1, 0), n, riser, tread, clear)
    landing = Slab((edge, length - HALF_WALL_M), (HALF_WALL_M, width - HALF_WALL_M), rise / 2)
    foot = Slab((0.0, begin), (HALF_WALL_M, width / 2), 0.0)
    head = Slab((0.0, begin), (width / 2, width - HALF_WALL_M), rise)
    turn = (edge + length - HALF_WALL_M) / 2
    line = _line((0.0, near, 0.0), [up, back], [(turn, near, rise / 2), (turn, far, rise / 2)], (0.0, far, rise))
    # The first run falls as the second rises: beside its k-th step the drop is 2 k risers.
    open_sided = [slab for slab in (*back.treads(), head) if 2 * (slab.top - rise / 2) > OPEN_SIDE_M]
    rails = [_rail(slab.u, (slab.v[0],) * 2, slab.top) for slab in open_sided]
    return StairsLayout(tread, clear, (*up.treads(), landing, *back.treads()), foot, head, line, tuple(rails))


def _l_shaped(length: float, width: float, rise: float, above_void: bool) -> StairsLayout:
    n = risers("L", rise)
    for clear in (*_USUAL_L_WIDTHS_M, MIN_RUN_WIDTH_M):
        first, tread = _split(length - HALF_WALL_M - clear, width - HALF_WALL_M - clear, n)
        if tread >= _USUAL_L_TREAD_M:
            break
    riser, tread, low = rise / n, min(_USUAL_TREAD_M, tread), first * rise / n
    corner, middle = length - HALF_WALL_M - clear, HALF_WALL_M + clear / 2
    begin, end = corner - (first - 1) * tread, HALF_WALL_M + clear + (n - first - 1) * tread
    up = _Run((begin, middle, 0.0), (1, 0), first, riser, tread, clear)
    across = _Run((corner + clear / 2, HALF_WALL_M + clear, low), (0, 1), n - first, riser, tread, clear)
    landing = Slab((corner, corner + clear), (HALF_WALL_M, HALF_WALL_M + clear), low)
    foot, head = Slab((0.0, begin), landing.v, 0.0), Slab(landing.u, (end, width), rise)
    line = _line((0.0, middle, 0.0), [up, across], [(corner + clear / 2, middle, low)], (corner + clear / 2, width, rise))
    lowest = -math.inf if above_void else OPEN_SIDE_M
    rails = [_rail(slab.u, (slab.v[1],) * 2, slab.top) for slab in (foot, *up.treads()) if slab.top > lowest]
    rails += [_rail((slab.u[0],) * 2, slab.v, slab.top) for slab in (*across.treads(), head) if slab.top > lowest]
    return StairsLayout(tread, clear, (*up.treads(), landing, *across.treads()), foot, head, line, tuple(rails))


def _split(first_m: float, second_m: float, n: int) -> tuple[int, float]:
    """Divide the `n` risers of an L-shape between its two runs so that treads are as deep as possible.

    Return the number of risers in the first run, and the depth of the treads [m]. `first_m` and `second_m` are the
    lengths available to the two runs [m].
    """
    depth = {k: min(first_m / (k - 0.5), second_m / (n - k - 0.5)) for k in range(2, n - 1)}
    first = max(depth, key=lambda k: depth[k])
    return first, depth[first]


def _line(start: Point, runs: Sequence[_Run], turns: Sequence[Point], end: Point) -> tuple[Point, ...]:
    first, *others = [run.line() for run in runs]
    points = [start, *first, *turns, *(point for line in others for point in line), end]
    return tuple([*(a for a, b in pairwise(points) if math.dist(a, b) > _TOLERANCE_M), end])


def _rail(u: tuple[float, float], v: tuple[float, float], top: float) -> Rail:
    return Rail((u[0], v[0], top), (u[1], v[1], top))
