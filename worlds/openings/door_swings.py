"""Where door leaves hang: free to swing, never in each other's way nor in front of another opening."""

import math
from collections.abc import Mapping, Sequence

from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.openings.opening_draft import LeafDraft, OpeningDraft, Rectangle
from worlds.spec import RoomSpec

LEAF_THICKNESS_M = 0.04
_WALL_M = 0.051
"""From a wall's centre line to clear of its face [m]."""
_FRONT_M = 0.6
"""What stays free before and behind an opening, for a body to step into [m]."""
_PASSING_M = 0.65
"""What stays free past a leaf that stands in a corridor [m]."""
_MOST_OPEN_RAD = math.radians(105.0)
_AJAR_RAD = (math.radians(62.0), math.radians(85.0))
_CIRCULATION = frozenset({"corridor", "entrance hall", "lobby"})


def hang_leaf(
    door: OpeningDraft,
    gaps: Sequence[OpeningDraft],
    rooms: Mapping[str, RoomSpec],
    draws: tuple[float, float],
    obstacles: Sequence[Rectangle] = (),
) -> LeafDraft | None:
    """A leaf for a door way, or None where there is no room for one to swing.

    It swings into the room that is not the corridor, hangs at the end nearer to a corner, and stands open. `gaps` are all
    the storey's openings, with the leaves that hang already; `draws` in [0, 1) say how far it is open; it keeps clear of
    `obstacles`.
    """
    ajar = draws[0] < 0.25
    for into in sorted(door.rooms, key=lambda room: _reluctance(rooms[room])):
        if rooms[into].label == STAIRS:
            continue
        for at_low in sorted((True, False), key=lambda low: _to_corner(door, rooms[into], low)):
            low, high = _AJAR_RAD if ajar else (math.pi / 2, _widest(door, rooms[into], at_low))
            leaf = LeafDraft(at_low, into, round(low + draws[1] * (high - low), 3))
            if _swings_freely(door, leaf, gaps, rooms, obstacles):
                return leaf
    return None


def _reluctance(room: RoomSpec) -> tuple[int, float]:
    """Doors swing into rooms rather than into corridors, indoors rather than out, and where there is more room."""
    rank = 2 if room.label in OUTDOOR_LABELS else 1 if room.label in _CIRCULATION else 0
    return rank, -_extent(room)


def _extent(room: RoomSpec) -> float:
    xs, ys = zip(*room.polygon_m, strict=True)
    return float((max(xs) - min(xs)) * (max(ys) - min(ys)))


def _to_corner(door: OpeningDraft, room: RoomSpec, at_low: bool) -> float:
    """From an end of the door to the next wall across, away from the door [m]."""
    hinge, sign = (door.low, -1.0) if at_low else (door.high, 1.0)
    inside = door.at + _WALL_M * (1.0 if door.larger_side == room.id else -1.0)
    nearest = math.inf
    for along, cross0, cross1 in _edges_across(room, door.axis):
        if cross0 < inside < cross1 and (distance := sign * (along - hinge)) > 0.0:
            nearest = min(nearest, distance)
    return nearest


def _edges_across(room: RoomSpec, axis: int) -> list[tuple[float, float, float]]:
    """The room's edges that run across `axis`: where on the axis, and from where to where across."""
    corners, across = room.polygon_m, 1 - axis
    return [
        (p[axis], min(p[across], q[across]), max(p[across], q[across]))
        for p, q in zip(corners, corners[1:] + corners[:1], strict=True)
        if p[axis] == q[axis]
    ]


def _widest(door: OpeningDraft, room: RoomSpec, at_low: bool) -> float:
    """The angle at which the leaf comes near the wall behind it [rad]."""
    behind = _to_corner(door, room, at_low) - _WALL_M - LEAF_THICKNESS_M
    return min(_MOST_OPEN_RAD, math.pi / 2 + math.asin(min(1.0, max(0.0, behind / door.width))))


def swing_box(door: OpeningDraft, leaf: LeafDraft) -> Rectangle:
    """The rectangle around all that the leaf sweeps up to where it stands, and at least to square, clear of its own wall."""
    behind = max(0.0, -math.cos(leaf.angle)) * door.width + LEAF_THICKNESS_M / 2
    return _box(door, leaf, -behind, door.width, door.width)


def resting_box(door: OpeningDraft, leaf: LeafDraft) -> Rectangle:
    """The rectangle around the leaf as it stands [m]."""
    tip, half = door.width * math.cos(leaf.angle), LEAF_THICKNESS_M / 2
    return _box(door, leaf, min(0.0, tip) - half, max(0.0, tip) + half, door.width * math.sin(leaf.angle))


def _box(door: OpeningDraft, leaf: LeafDraft, start: float, stop: float, depth: float) -> Rectangle:
    """From `start` to `stop` from the hinge towards the other end, and `depth` into the room."""
    along = (door.low + start, door.low + stop) if leaf.at_low else (door.high - stop, door.high - start)
    into_larger = door.larger_side == leaf.into
    cross = (door.at + _WALL_M, door.at + depth) if into_larger else (door.at - depth, door.at - _WALL_M)
    return (along[0], cross[0], along[1], cross[1]) if door.axis == 0 else (cross[0], along[0], cross[1], along[1])


def is_in_front(door: OpeningDraft, other: OpeningDraft, depth_m: float) -> bool:
    """Whether the door's leaf stands within `depth_m` before another opening, or swings through that one's leaf."""
    if door.leaf is None or door.leaf.into not in other.rooms or other is door:
        return False
    if other.leaf is not None and other.leaf.into == door.leaf.into:
        return _overlap(swing_box(door, door.leaf), swing_box(other, other.leaf))
    return _overlap(resting_box(door, door.leaf), other.around(depth_m))


def _swings_freely(
    door: OpeningDraft,
    leaf: LeafDraft,
    gaps: Sequence[OpeningDraft],
    rooms: Mapping[str, RoomSpec],
    obstacles: Sequence[Rectangle],
) -> bool:
    room, swing, standing = rooms[leaf.into], swing_box(door, leaf), resting_box(door, leaf)
    passing = _PASSING_M if room.label in _CIRCULATION else 0.0
    needed = _box(door, leaf, -LEAF_THICKNESS_M / 2, door.width, door.width + passing) if passing else swing
    if any(_overlap(needed, wall) or _overlap(swing, wall) for wall in _walls(room)):
        return False
    if any(_overlap(swing, obstacle) for obstacle in obstacles):
        return False
    for other in gaps:
        if other is door or leaf.into not in other.rooms:
            continue
        if other.leaf is not None and other.leaf.into == leaf.into and _overlap(swing, swing_box(other, other.leaf)):
            return False
        if _overlap(standing, other.around(_FRONT_M)):
            return False
    return True


def _walls(room: RoomSpec) -> list[Rectangle]:
    """The room's walls as rectangles a little thinner than they are."""
    half, corners = _WALL_M - 0.002, room.polygon_m
    return [
        (min(x0, x1) - half, min(y0, y1) - half, max(x0, x1) + half, max(y0, y1) + half)
        for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True)
    ]


def _overlap(a: Rectangle, b: Rectangle) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
