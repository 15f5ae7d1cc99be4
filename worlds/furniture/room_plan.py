"""`RoomPlan`: what is still free in one room while it is being furnished; all axis-aligned rectangles."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from jaxtyping import Bool, Float64, UInt8

from worlds.spec import OpeningSpec, RoomSpec, StoreySpec

Rectangle = tuple[float, float, float, float]
"""x0, y0, x1, y1 [m]"""
Interval = tuple[float, float]

HALF_WALL_M = 0.05
WALL_GAP_M = 0.006
OPENING_DEPTH_M = 0.9
OPENING_MARGIN_M = 0.15
PASSAGE_M = 1.3
"""Of an opening wider than that, this much is kept clear, at the end that is nearer to another way out."""
BODY_RADIUS_M = 0.3
CELL_M = 0.1
MIN_REACHABLE_SHARE = 0.4
"""Of a room's area, what a body can still cover."""
FLAT_M = 0.03
"""What is lower may lie under furniture."""
_EPS_M = 1e-4
_BODY = np.ones((2 * round(BODY_RADIUS_M / CELL_M) + 1,) * 2, np.uint8)
_EVERYWHERE = (-math.inf, math.inf)
_Cells = UInt8[np.ndarray, "rows columns"]
_Cell = tuple[int, int]
_Point = tuple[float, float]
_Segment = tuple[_Point, _Point]
_Side = tuple[_Segment, _Point]
"""A segment on a side of the room, and the unit normal into the room."""


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

    def __init__(self, room: RoomSpec, storey: StoreySpec) -> None:
        """`room` is one of `storey`."""
        self.room = room
        self.height_m = storey.height_m
        self.corners = np.array(room.polygon_m)
        own = [opening for opening in storey.openings if room.id in opening.rooms]
        gaps = [side for o in own if (side := _on_side(room, (o.start_m, o.end_m))) is not None]
        passages = [side for o in own if (side := _on_side(room, _passage(o, storey.openings))) is not None]
        self.runs = tuple(_runs(room, [ends for ends, _ in gaps], [other for other in storey.rooms if other is not room]))
        self._outside = _outside(self.corners)
        self._plan: list[Rectangle] = [grown(r, HALF_WALL_M) for r in self._outside]
        self._zones: list[tuple[Rectangle, object]] = [(_opening_zone(*passage), None) for passage in passages]
        self._boxes = [(*r, *_EVERYWHERE) for r in self._plan]
        self._flat: list[Rectangle] = []
        self._walls = len(self._plan)
        self._free_cells, self._doors = self._bare_room(passages)
        self._required = MIN_REACHABLE_SHARE * self.area_m2 / CELL_M**2

    @property
    def area_m2(self) -> float:
        """Of the polygon [m²]."""
        x, y = self.corners.T
        return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    def fits(
        self,
        places: Float64[np.ndarray, "n 4"],
        z: Interval,
        solid: bool,
        zones: Float64[np.ndarray, "n 4"] | None = None,
        guest_of: object = None,
    ) -> Bool[np.ndarray, " n"]:
        """Which of the rectangles are free over the heights `z` [m], with the `zones` in front of them clear.

        A guest of a host (a chair at a desk) may stand in the zone that is kept clear for that host.
        """
        if z[1] <= FLAT_M:
            return ~_overlaps(places, self._plan[: self._walls] + self._flat)
        level = [b[:4] for b in self._boxes if b[4] < z[1] - _EPS_M and b[5] > z[0] + _EPS_M]
        free = ~_overlaps(places, level)
        if solid:
            kept = [zone for zone, owner in self._zones if owner is None or owner is not guest_of]
            free &= ~_overlaps(places, self._plan + kept)
        if zones is not None:
            free &= ~_overlaps(zones, self._plan)
        return free

    def stays_walkable(self, place: Rectangle) -> bool:
        """Whether a body still gets from opening to opening, and about most of the room, round a solid piece at `place`."""
        trial = self._free_cells.copy()
        trial[self._cells(grown(place, BODY_RADIUS_M))] = 0
        return _covered(trial, self._doors) >= self._required

    def add(self, place: Rectangle, z: Interval, solid: bool, zone: Rectangle | None = None, owner: object = None) -> None:
        """Take the space; `zone` stays clear for all but the guests of `owner`."""
        if z[1] <= FLAT_M:
            self._flat.append(place)
            return
        self._boxes.append((*place, *z))
        if solid:
            self._plan.append(place)
            self._free_cells[self._cells(grown(place, BODY_RADIUS_M))] = 0
        if zone is not None:
            self._zones.append((zone, owner))

    def _bare_room(self, passages: Sequence[_Side]) -> tuple[_Cells, set[_Cell]]:
        """The cells that a body's centre may be in, and the one in front of each passage."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        columns, rows = (int(n) for n in np.ceil((high - low) / CELL_M - 1e-6))
        free = np.ones((rows, columns), np.uint8)
        for rectangle in self._outside:
            free[self._cells(grown(rectangle, HALF_WALL_M + BODY_RADIUS_M))] = 0
        ys, xs = np.nonzero(free)
        doors: set[_Cell] = set()
        for (a, b), inward in passages if len(xs) else ():
            entry = (np.add(a, b) / 2 + OPENING_DEPTH_M / 2 * np.array(inward) - low) / CELL_M - 0.5
            nearest = int(np.argmin((xs - entry[0]) ** 2 + (ys - entry[1]) ** 2))
            doors.add((int(ys[nearest]), int(xs[nearest])))
        return free, doors

    def _cells(self, r: Rectangle) -> tuple[slice, slice]:
        """The grid cells whose centres lie in the rectangle."""
        (x, y) = self.corners.min(axis=0)
        (i0, i1), (j0, j1) = (
            (max(0, math.ceil((a - o) / CELL_M - 0.5)), max(0, math.floor((b - o) / CELL_M - 0.5) + 1))
            for a, b, o in ((r[1], r[3], y), (r[0], r[2], x))
        )
        return slice(i0, i1), slice(j0, j1)


def grown(r: Rectangle, by: float) -> Rectangle:
    """The rectangle, larger by `by` [m] on every side."""
    return r[0] - by, r[1] - by, r[2] + by, r[3] + by


def _covered(free: _Cells, doors: set[_Cell]) -> int:
    """Cells that a body covers when its centre goes wherever it can from the doors; 0 if these are not joined."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    if count < 2:
        return 0
    joined = {int(labels[door]) for door in doors} or {1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))}
    if 0 in joined or len(joined) > 1:
        return 0
    return int(np.count_nonzero(cv2.dilate((labels == joined.pop()).astype(np.uint8), _BODY)))


def _overlaps(places: Float64[np.ndarray, "n 4"], obstacles: Iterable[Rectangle]) -> Bool[np.ndarray, " n"]:
    taken = np.array(list(obstacles))
    if not len(taken):
        return np.zeros(len(places), bool)
    low, high = places[:, None, :2], places[:, None, 2:]
    apart = (low >= taken[:, 2:] - _EPS_M) | (high <= taken[:, :2] + _EPS_M)
    clear: Bool[np.ndarray, " n"] = np.all(np.any(apart, axis=2), axis=1)
    return ~clear


def _outside(corners: Float64[np.ndarray, "n 2"]) -> list[Rectangle]:
    """Rectangles that cover the bounding box of a rectilinear polygon, less the polygon, and a rim round the box."""
    xs, ys = np.unique(corners[:, 0]), np.unique(corners[:, 1])
    x0, y0, x1, y1, far = float(xs[0]), float(ys[0]), float(xs[-1]), float(ys[-1]), 10.0
    rim = [
        (x0 - far, y0 - far, x0, y1 + far),
        (x1, y0 - far, x1 + far, y1 + far),
        (x0, y0 - far, x1, y0),
        (x0, y1, x1, y1 + far),
    ]
    cells = [(float(a), float(c), float(b), float(d)) for a, b in pairwise(xs) for c, d in pairwise(ys)]
    return rim + [c for c in cells if not _contains(corners, (c[0] + c[2]) / 2, (c[1] + c[3]) / 2)]


def _contains(corners: Float64[np.ndarray, "n 2"], x: float, y: float) -> bool:
    a, b = corners, np.roll(corners, -1, axis=0)
    crosses = (a[:, 0] == b[:, 0]) & (a[:, 0] > x) & (np.minimum(a[:, 1], b[:, 1]) < y) & (np.maximum(a[:, 1], b[:, 1]) > y)
    return bool(crosses.sum() % 2)


def _sides(room: RoomSpec) -> Iterable[tuple[_Point, _Point, float]]:
    """Start, unit direction and length of each side."""
    corners = room.polygon_m
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        length = abs(x1 - x0) + abs(y1 - y0)
        yield (x0, y0), ((x1 - x0) / length, (y1 - y0) / length), length


def _interval_on(start: _Point, along: _Point, length: float, a: _Point, b: _Point) -> Interval | None:
    """Where the segment a - b lies on a side, as distances from its start; None if it does not."""
    (ax, ay), (bx, by) = (a[0] - start[0], a[1] - start[1]), (b[0] - start[0], b[1] - start[1])
    if abs(ay * along[0] - ax * along[1]) > _EPS_M or abs(by * along[0] - bx * along[1]) > _EPS_M:
        return None
    ta, tb = ax * along[0] + ay * along[1], bx * along[0] + by * along[1]
    low, high = max(0.0, min(ta, tb)), min(length, max(ta, tb))
    return (low, high) if high - low > _EPS_M else None


def _on_side(room: RoomSpec, ends: _Segment) -> _Side | None:
    """The part of a segment that lies on a side of the room."""
    for start, along, length in _sides(room):
        span = _interval_on(start, along, length, *ends)
        if span is not None:
            a, b = ((start[0] + t * along[0], start[1] + t * along[1]) for t in span)
            return (a, b), (-along[1], along[0])
    return None


def _passage(opening: OpeningSpec, all_openings: Sequence[OpeningSpec]) -> _Segment:
    """The part of an opening that is kept clear on both sides: both rooms come to the same answer."""
    a, b, width = opening.start_m, opening.end_m, opening.width_m
    if width <= PASSAGE_M:
        return a, b
    ways_out = [other for other in all_openings if other.width_m <= PASSAGE_M and set(other.rooms) & set(opening.rooms)]
    from_a, from_b = (min((math.dist(end, o.start_m) for o in ways_out), default=0.0) for end in (a, b))
    (x0, y0), (x1, y1) = (a, b) if from_a <= from_b else (b, a)
    return (x0, y0), (x0 + (x1 - x0) * PASSAGE_M / width, y0 + (y1 - y0) * PASSAGE_M / width)


def _opening_zone(ends: _Segment, inward: _Point) -> Rectangle:
    (ax, ay), (bx, by) = ends
    margin_x, margin_y = OPENING_MARGIN_M * abs(inward[1]), OPENING_MARGIN_M * abs(inward[0])
    x, y = (ax, bx, ax + OPENING_DEPTH_M * inward[0]), (ay, by, ay + OPENING_DEPTH_M * inward[1])
    return min(x) - margin_x, min(y) - margin_y, max(x) + margin_x, max(y) + margin_y


def _runs(room: RoomSpec, openings: Sequence[_Segment], others: Sequence[RoomSpec]) -> Iterable[WallRun]:
    for start, along, length in _sides(room):
        gaps = [gap for ends in openings if (gap := _interval_on(start, along, length, *ends)) is not None]
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
