"""`RoomPlan`: what is still free in one room while it is being furnished; all axis-aligned rectangles."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float64

from worlds.spec import OpeningSpec, RoomSpec

Rectangle = tuple[float, float, float, float]
"""x0, y0, x1, y1 [m]"""
Interval = tuple[float, float]

HALF_WALL_M = 0.05
WALL_GAP_M = 0.006
OPENING_DEPTH_M = 0.9
OPENING_MARGIN_M = 0.15
BODY_RADIUS_M = 0.3
CELL_M = 0.1
MIN_REACHABLE_SHARE = 0.35
MIN_SHARE_OF_BARE = 0.4
"""Of what a body reaches in the empty room: the bound for rooms so small that `MIN_REACHABLE_SHARE` is out of reach."""
FLAT_M = 0.03
"""What is lower may lie under furniture."""
_EPS_M = 1e-4
_EVERYWHERE = (-math.inf, math.inf)
_NOBODY = -1


@dataclass(frozen=True)
class WallRun:
    """A side of the room: a directed line with the room on its left, and the stretches of wall along it."""

    start: tuple[float, float]
    """[m]"""
    along: tuple[float, float]
    """Unit vector; a piece with its back to this wall has its x axis along it."""
    free: tuple[Interval, ...]
    """Distances from `start` between the openings [m]."""
    exterior: tuple[Interval, ...]
    """The part of `free` that no other room is behind [m]."""

    @property
    def inward(self) -> tuple[float, float]:
        """Unit normal into the room."""
        return -self.along[1], self.along[0]

    @property
    def yaw(self) -> float:
        """Of a piece with its back to this wall [rad]."""
        return math.atan2(self.along[1], self.along[0])

    def at(self, t: float, depth: float) -> tuple[float, float]:
        """Centre of a piece of `depth` [m] that stands against the wall at distance `t` [m] from its start."""
        off = HALF_WALL_M + WALL_GAP_M + depth / 2
        (x, y), (tx, ty), (nx, ny) = self.start, self.along, self.inward
        return x + t * tx + off * nx, y + t * ty + off * ny


class RoomPlan:
    """The free floor, walls and space of a room. Solid pieces must not meet in plan; others must not meet in space."""

    def __init__(self, room: RoomSpec, openings: Sequence[OpeningSpec], others: Sequence[RoomSpec], height_m: float) -> None:
        """`openings` are the room's own; `others` are the other rooms of its storey."""
        self.room = room
        self.height_m = height_m
        self.corners = np.array(room.polygon_m)
        self._spans = [s for o in openings if (s := _span_on(room, o)) is not None]
        self.runs = tuple(_runs(room, self._spans, others))
        self._outside = _outside(self.corners)
        self._plan: list[Rectangle] = [grown(r, HALF_WALL_M) for r in self._outside]
        self._zones = [(_opening_zone(room, *span), _NOBODY) for span in self._spans]
        self._boxes = [(*r, *_EVERYWHERE) for r in self._plan]
        self._flat: list[Rectangle] = []
        self._walls = len(self._plan)
        self._free_cells, self._seeds = self._bare_room()
        bare = _component(self._free_cells, self._seeds)
        self._required = min(MIN_REACHABLE_SHARE * self.area_m2 / CELL_M**2, MIN_SHARE_OF_BARE * bare)

    @property
    def area_m2(self) -> float:
        """Of the polygon [m²]."""
        x, y = self.corners.T
        return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    def fits(
        self, places: Float64[np.ndarray, "n 4"], z: Interval, solid: bool, zones: Float64[np.ndarray, "n 4"] | None = None, guest_of: int | None = None
    ) -> Bool[np.ndarray, " n"]:
        """Which of the rectangles are free over the heights `z` [m], with the `zones` in front of them clear.

        A guest of a host (a chair at a desk) may stand in the zone that is kept clear for that host.
        """
        if z[1] <= FLAT_M:
            return ~_overlaps(places, self._plan[: self._walls] + self._flat)
        level = [b[:4] for b in self._boxes if b[4] < z[1] - _EPS_M and b[5] > z[0] + _EPS_M]
        free = ~_overlaps(places, level)
        if solid:
            kept = [zone for zone, owner in self._zones if owner == _NOBODY or owner != guest_of]
            free &= ~_overlaps(places, self._plan + kept)
        if zones is not None:
            free &= ~_overlaps(zones, self._plan)
        return free

    def stays_walkable(self, place: Rectangle) -> bool:
        """Whether a body still gets from opening to opening, and about most of the room, round a solid piece at `place`."""
        trial = self._free_cells.copy()
        trial[self._cells(grown(place, BODY_RADIUS_M))] = 0
        return _component(trial, self._seeds) >= self._required

    def add(self, place: Rectangle, z: Interval, solid: bool, zone: Rectangle | None = None, owner: int = _NOBODY) -> None:
        """Take the space; `zone` stays clear for `owner`, which is any number that names the piece."""
        if z[1] <= FLAT_M:
            self._flat.append(place)
            return
        self._boxes.append((*place, *z))
        if solid:
            self._plan.append(place)
            self._free_cells[self._cells(grown(place, BODY_RADIUS_M))] = 0
        if zone is not None:
            self._zones.append((zone, owner))

    def _bare_room(self) -> tuple[np.ndarray, list[tuple[int, int]]]:
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        columns, rows = (int(n) for n in np.ceil((high - low) / CELL_M - 1e-6))
        free = np.ones((rows, columns), np.uint8)
        for rectangle in self._outside:
            free[self._cells(grown(rectangle, HALF_WALL_M + BODY_RADIUS_M))] = 0
        ys, xs = np.nonzero(free)
        seeds = []
        for (a, b), inward in ((span[0], span[1]) for span in self._spans):
            entry = (np.add(a, b) / 2 + OPENING_DEPTH_M / 2 * np.array(inward) - low) / CELL_M - 0.5
            if len(xs):
                nearest = int(np.argmin((xs - entry[0]) ** 2 + (ys - entry[1]) ** 2))
                seeds.append((int(ys[nearest]), int(xs[nearest])))
        return free, seeds

    def _cells(self, r: Rectangle) -> tuple[slice, slice]:
        """The grid cells whose centres lie in the rectangle."""
        (x, y) = self.corners.min(axis=0)
        (i0, i1), (j0, j1) = (
            (max(0, math.ceil((a - o) / CELL_M - 0.5)), max(0, math.floor((b - o) / CELL_M - 0.5) + 1)) for a, b, o in ((r[1], r[3], y), (r[0], r[2], x))
        )
        return slice(i0, i1), slice(j0, j1)


def grown(r: Rectangle, by: float) -> Rectangle:
    """The rectangle, larger by `by` [m] on every side."""
    return r[0] - by, r[1] - by, r[2] + by, r[3] + by


def _component(free: np.ndarray, seeds: Sequence[tuple[int, int]]) -> int:
    """Cells that are reached from all the seeds, 0 if they are not joined; without seeds, those of the largest part."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    if count < 2:
        return 0
    if not seeds:
        return int(stats[1:, cv2.CC_STAT_AREA].max())
    reached = {int(labels[seed]) for seed in seeds}
    return int(stats[reached.pop(), cv2.CC_STAT_AREA]) if len(reached) == 1 and 0 not in reached else 0


def _overlaps(places: Float64[np.ndarray, "n 4"], obstacles: Iterable[Rectangle]) -> Bool[np.ndarray, " n"]:
    taken = np.array(list(obstacles))
    if not len(taken):
        return np.zeros(len(places), bool)
    low, high = places[:, None, :2], places[:, None, 2:]
    return np.any(np.all((low < taken[:, 2:] - _EPS_M) & (high > taken[:, :2] + _EPS_M), axis=2), axis=1)


def _outside(corners: Float64[np.ndarray, "n 2"]) -> list[Rectangle]:
    """Rectangles that cover the bounding box of a rectilinear polygon, less the polygon, and a rim round the box."""
    xs, ys = np.unique(corners[:, 0]), np.unique(corners[:, 1])
    x0, y0, x1, y1, far = float(xs[0]), float(ys[0]), float(xs[-1]), float(ys[-1]), 10.0
    rim = [(x0 - far, y0 - far, x0, y1 + far), (x1, y0 - far, x1 + far, y1 + far), (x0, y0 - far, x1, y0), (x0, y1, x1, y1 + far)]
    cells = [(float(a), float(c), float(b), float(d)) for a, b in zip(xs, xs[1:], strict=False) for c, d in zip(ys, ys[1:], strict=False)]
    return rim + [c for c in cells if not _contains(corners, (c[0] + c[2]) / 2, (c[1] + c[3]) / 2)]


def _contains(corners: Float64[np.ndarray, "n 2"], x: float, y: float) -> bool:
    a, b = corners, np.roll(corners, -1, axis=0)
    crosses = (a[:, 0] == b[:, 0]) & (a[:, 0] > x) & (np.minimum(a[:, 1], b[:, 1]) < y) & (np.maximum(a[:, 1], b[:, 1]) > y)
    return bool(crosses.sum() % 2)


_Span = tuple[tuple[tuple[float, float], tuple[float, float]], tuple[float, float]]
"""An opening's ends on a side of the room, and the unit normal into the room."""


def _sides(room: RoomSpec) -> Iterable[tuple[tuple[float, float], tuple[float, float], float]]:
    """Start, unit direction and length of each side."""
    corners = room.polygon_m
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        length = abs(x1 - x0) + abs(y1 - y0)
        yield (x0, y0), ((x1 - x0) / length, (y1 - y0) / length), length


def _interval_on(
    start: tuple[float, float], along: tuple[float, float], length: float, a: tuple[float, float], b: tuple[float, float]
) -> Interval | None:
    """Where the segment a - b lies on a side, as distances from its start; None if it does not."""
    t, off = [], []
    for x, y in (a, b):
        dx, dy = x - start[0], y - start[1]
        t.append(dx * along[0] + dy * along[1])
        off.append(abs(dy * along[0] - dx * along[1]))
    low, high = max(0.0, min(t)), min(length, max(t))
    return (low, high) if max(off) < _EPS_M and high - low > _EPS_M else None


def _span_on(room: RoomSpec, opening: OpeningSpec) -> _Span | None:
    for start, along, length in _sides(room):
        span = _interval_on(start, along, length, opening.start_m, opening.end_m)
        if span is not None:
            a, b = ((start[0] + t * along[0], start[1] + t * along[1]) for t in span)
            return (a, b), (-along[1], along[0])
    return None


def _opening_zone(room: RoomSpec, ends: tuple[tuple[float, float], tuple[float, float]], inward: tuple[float, float]) -> Rectangle:
    (ax, ay), (bx, by) = ends
    margin_x, margin_y = OPENING_MARGIN_M * abs(inward[1]), OPENING_MARGIN_M * abs(inward[0])
    deep_x, deep_y = OPENING_DEPTH_M * inward[0], OPENING_DEPTH_M * inward[1]
    x, y = (ax, bx, ax + deep_x), (ay, by, ay + deep_y)
    return min(x) - margin_x, min(y) - margin_y, max(x) + margin_x, max(y) + margin_y


def _runs(room: RoomSpec, spans: Sequence[_Span], others: Sequence[RoomSpec]) -> Iterable[WallRun]:
    for start, along, length in _sides(room):
        gaps = [i for (a, b), _ in spans if (i := _interval_on(start, along, length, a, b)) is not None]
        behind = []
        for other in others:
            for p, q in zip(other.polygon_m, other.polygon_m[1:] + other.polygon_m[:1], strict=True):
                if (shared := _interval_on(start, along, length, p, q)) is not None:
                    behind.append(shared)
        free = _less((0.0, length), [(low - HALF_WALL_M, high + HALF_WALL_M) for low, high in gaps])
        yield WallRun(start, along, free, tuple(e for f in free for e in _less(f, behind)))


def _less(whole: Interval, cuts: Sequence[Interval]) -> tuple[Interval, ...]:
    left, position = [], whole[0]
    for low, high in sorted(cuts):
        if low > position + _EPS_M:
            left.append((position, min(low, whole[1])))
        position = max(position, high)
    if whole[1] > position + _EPS_M:
        left.append((position, whole[1]))
    return tuple(i for i in left if i[1] - i[0] > 0.05)
