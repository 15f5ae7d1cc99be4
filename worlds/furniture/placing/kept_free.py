"""The space in a room that furniture has to leave free for openings, door leaves and windows."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from worlds.furniture.placing.room_shape import EPS_M, Interval, Point, RoomShape, RoomSide
from worlds.rectangles import Rectangle, grown
from worlds.spec import PASSABLE, LeafSpec, OpeningSpec, RoomSpec, StoreySpec, WindowSpec
from worlds.walls import HALF_WALL_M

OPENING_DEPTH_M = 0.9
"""Depth of the floor that stays free in front of a passage, an opening that can be walked through [m]."""
OPENING_MARGIN_M = 0.15
"""Width by which the free floor in front of a passage extends beyond the passage on each side [m]."""
PASSAGE_M = 1.3
"""Greatest width of an opening that is kept free of furniture [m]. If an opening is wider, only a stretch of this width is
kept free, at the end that is nearer to another passage."""
SIGHT_DEPTH_M = 0.35
"""Depth of the space in front of a window, half wall or counter that stays free above the sill [m]."""
_SWING_MARGIN_M = 0.06
_LEAF_HALF_M = 0.02
_STANDS_OPEN_RAD = 1.2
"""Opening angle above which a door leaf is an obstacle [rad]; a leaf that is only ajar can be pushed aside."""


class Space(NamedTuple):
    """A box that is occupied or has to stay free."""

    rectangle: Rectangle
    """Extent of the box in the plan [m]."""
    bottom: float
    """Height of the underside of the box above the floor [m]."""
    top: float
    """Height of the top of the box above the floor [m]."""


@dataclass(frozen=True)
class WallRun:
    """A side of the room, with the stretches of wall along it."""

    side: RoomSide
    free: tuple[Interval, ...]
    """Stretches of wall between the passages, as distances from the start of the side [m]."""


@dataclass(frozen=True)
class KeptFree:
    """The space that stays free in one room, in the room's own coordinates."""

    runs: tuple[WallRun, ...]
    zones: tuple[Rectangle, ...]
    """Floor that stays free of solid pieces: in front of passages and in the swing area of door leaves."""
    spaces: tuple[Space, ...]
    """Boxes that stay empty: swing areas of door leaves, and the space above sills of windows, half walls and counters."""
    entries: tuple[Point, ...]
    """A point in front of every passage [m]."""
    leaves: tuple[Rectangle, ...]
    """Footprints of door leaves that stand open [m]."""


def kept_free_of(shape: RoomShape, room: RoomSpec, storey: StoreySpec, windows: Sequence[WindowSpec]) -> KeptFree:
    """Return the space that the openings and windows of a room need; `room` and `windows` belong to `storey`."""
    gaps: dict[RoomSide, list[Interval]] = {side: [] for side in shape.sides}
    zones, spaces, entries, leaves = [], [], [], []
    for opening in storey.openings:
        if room.id not in opening.rooms:
            continue
        if opening.kind not in PASSABLE:
            spaces += _before(shape, opening.start_m, opening.end_m, opening.sill_m, storey.height_m)
            continue
        for side, (low, high) in _on_sides(shape, opening.start_m, opening.end_m):
            gaps[side].append((low - HALF_WALL_M, high + HALF_WALL_M))
        for side, (low, high) in _on_sides(shape, *_passage(opening, storey.openings)):
            zones.append(side.rectangle(low - OPENING_MARGIN_M, high + OPENING_MARGIN_M, OPENING_DEPTH_M))
            entries.append(side.at((low + high) / 2, OPENING_DEPTH_M / 2))
        if opening.leaf is not None and opening.leaf.into == room.id:
            for swing, leaf in _swings(shape, opening, opening.leaf):
                zones.append(swing)
                spaces.append(Space(swing, 0.0, opening.height_m))
                leaves += [leaf] if opening.leaf.angle_rad > _STANDS_OPEN_RAD else []
    for window in windows:
        if window.room == room.id:
            spaces += _before(shape, window.start_m, window.end_m, window.sill_m, window.height_m)
    runs = tuple(WallRun(side, _remaining(side.length, cuts)) for side, cuts in gaps.items())
    return KeptFree(runs, tuple(zones), tuple(spaces), tuple(entries), tuple(leaves))


def _on_sides(shape: RoomShape, start: Point, end: Point) -> Iterator[tuple[RoomSide, Interval]]:
    a, b = shape.local(start), shape.local(end)
    return ((side, span) for side in shape.sides if (span := side.interval(a, b)) is not None)


def _before(shape: RoomShape, start: Point, end: Point, bottom: float, top: float) -> list[Space]:
    return [Space(side.rectangle(*span, SIGHT_DEPTH_M), bottom, top) for side, span in _on_sides(shape, start, end)]


def _swings(shape: RoomShape, opening: OpeningSpec, leaf: LeafSpec) -> Iterator[tuple[Rectangle, Rectangle]]:
    """Yield the bounding rectangles of a door's swing area and of its open leaf, for each side of the room with the door.

    The swing area is taken as if the leaf opened at least to a right angle.
    """
    ends = opening.start_m, opening.end_m
    width, hinged = opening.width_m, ends if leaf.hinge == "start" else ends[::-1]
    back = _SWING_MARGIN_M + width * max(0.0, -math.cos(leaf.angle_rad))
    for side, _ in _on_sides(shape, *ends):
        hinge, other = (side.along(shape.local(end)) for end in hinged)
        ahead = math.copysign(1.0, other - hinge)
        low, high = sorted((hinge - back * ahead, other + _SWING_MARGIN_M * ahead))
        tip = hinge + ahead * width * math.cos(leaf.angle_rad)
        standing = side.rectangle(min(hinge, tip), max(hinge, tip), width * math.sin(leaf.angle_rad))
        yield side.rectangle(low, high, width + _SWING_MARGIN_M), grown(standing, _LEAF_HALF_M)


def _passage(opening: OpeningSpec, all_openings: Sequence[OpeningSpec]) -> tuple[Point, Point]:
    """Return the ends of the part of an opening that stays free, which is the same part for the rooms on both sides."""
    a, b, width = opening.start_m, opening.end_m, opening.width_m
    if width <= PASSAGE_M:
        return a, b
    ways_out = [
        other
        for other in all_openings
        if other.kind in PASSABLE and other.width_m <= PASSAGE_M and set(other.rooms) & set(opening.rooms)
    ]
    from_a, from_b = (min((math.dist(end, o.start_m) for o in ways_out), default=0.0) for end in (a, b))
    (x0, y0), (x1, y1) = (a, b) if from_a <= from_b else (b, a)
    return (x0, y0), (x0 + (x1 - x0) * PASSAGE_M / width, y0 + (y1 - y0) * PASSAGE_M / width)


def _remaining(length: float, cuts: Sequence[Interval]) -> tuple[Interval, ...]:
    left, position = [], 0.0
    for low, high in sorted(cuts):
        if low > position + EPS_M:
            left.append((position, min(low, length)))
        position = max(position, high)
    if length > position + EPS_M:
        left.append((position, length))
    return tuple(interval for interval in left if interval[1] - interval[0] > 0.05)
