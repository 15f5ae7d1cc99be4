"""Choice of how door leaves hang: at which end of the opening, and into which room they swing.

A leaf must swing freely: its swing area, the rectangle around the sector that it sweeps, overlaps no wall, obstacle or other
leaf's swing area. At the angle at which it stands, the leaf must not block another opening. `hang_leaf` tries the four
possible ways to hang a leaf.
"""

import math
from collections.abc import Mapping, Sequence

from worlds.labels import CIRCULATION_LABELS, OUTDOOR_LABELS, STAIRS
from worlds.openings.opening_draft import LEAF_THICKNESS_M, LeafDraft, OpeningDraft
from worlds.rectangles import Rectangle, grown, overlap, polygon_sides
from worlds.spec import RoomSpec

_WALL_M = 0.051
"""Distance from a wall's centre line to just outside its face: half the thickness and 1 mm [m]."""
FRONT_M = 0.6
"""Depth of the area that stays free before and behind an opening, so that a body can step there [m]."""
_PASSING_M = 0.65
"""Width that stays free past the tip of a leaf that stands open in a corridor [m]."""
_MOST_OPEN_RAD = math.radians(105.0)
_AJAR_RAD = (math.radians(62.0), math.radians(85.0))
"""Range of the angle of a leaf that does not stand fully open [rad]."""


def hang_leaf(
    door: OpeningDraft,
    gaps: Sequence[OpeningDraft],
    rooms: Mapping[str, RoomSpec],
    draws: tuple[float, float],
    obstacles: Sequence[Rectangle] = (),
) -> LeafDraft | None:
    """Choose how the leaf of a doorway hangs; return None if no leaf can swing freely there.

    There are four ways to hang a leaf. They are tried in this order, and the first in which the leaf swings freely is taken:

    1. The leaf may swing into either room, but never into stairs. `_swing_rank` decides which room is tried first. For
       example, a corridor is tried after another indoor room, so that the leaf does not stand in people's way.
    2. For either room, the hinge is tried first at the end nearer to a corner, so that the open leaf stands against a wall.

    A quarter of the leaves stand ajar; the others are open to a right angle or further, as far as the wall behind them
    allows. `gaps` are all openings of the storey, with the leaves that were hung before. `draws` are two numbers in [0, 1)
    that decide whether the leaf is ajar, and its angle. `obstacles` are further areas to keep free [m].
    """
    ajar = draws[0] < 0.25
    for into in sorted(door.rooms, key=lambda room: _swing_rank(rooms[room])):
        if rooms[into].label == STAIRS:
            continue
        for at_low in sorted((True, False), key=lambda low: _distance_to_corner(door, rooms[into], low)):
            low, high = _AJAR_RAD if ajar else (math.pi / 2, _largest_angle(door, rooms[into], at_low))
            leaf = LeafDraft(at_low, into, round(low + draws[1] * (high - low), 3))
            if _swings_freely(door, leaf, gaps, rooms, obstacles):
                return leaf
    return None


def _swing_rank(room: RoomSpec) -> tuple[int, float]:
    """Return a sort key for the two rooms of a door: the room into which the leaf should preferably swing comes first.

    Doors swing into rooms rather than corridors, indoors rather than outdoors, and otherwise into the larger room.
    """
    rank = 2 if room.label in OUTDOOR_LABELS else 1 if room.label in CIRCULATION_LABELS else 0
    return rank, -_extent(room)


def _extent(room: RoomSpec) -> float:
    """Return the area of the room's bounding rectangle [m²]."""
    xs, ys = zip(*room.polygon_m, strict=True)
    return float((max(xs) - min(xs)) * (max(ys) - min(ys)))


def _distance_to_corner(door: OpeningDraft, room: RoomSpec, at_low: bool) -> float:
    """Return the distance from the hinge of a leaf to the next wall at a right angle to the door's wall [m].

    The distance is measured along the door's wall, away from the door. The hinge is at the lower end of the door if
    `at_low`, else at the upper end. The distance is infinite if there is no wall at a right angle.
    """
    hinge, sign = (door.low, -1.0) if at_low else (door.high, 1.0)
    inside = door.at + _WALL_M * (1.0 if door.larger_side == room.id else -1.0)
    nearest = math.inf
    for along, cross0, cross1 in _edges_across(room, door.axis):
        if cross0 < inside < cross1 and (distance := sign * (along - hinge)) > 0.0:
            nearest = min(nearest, distance)
    return nearest


def _edges_across(room: RoomSpec, axis: int) -> list[tuple[float, float, float]]:
    """Return the room's edges at a right angle to `axis`, each as (coordinate on the axis, lower end, upper end) [m]."""
    across = 1 - axis
    return [
        (p[axis], min(p[across], q[across]), max(p[across], q[across]))
        for p, q in polygon_sides(room.polygon_m)
        if p[axis] == q[axis]
    ]


def _largest_angle(door: OpeningDraft, room: RoomSpec, at_low: bool) -> float:
    """Return the largest angle at which the leaf does not touch the wall behind it, at most `_MOST_OPEN_RAD` [rad]."""
    behind = _distance_to_corner(door, room, at_low) - _WALL_M - LEAF_THICKNESS_M
    return min(_MOST_OPEN_RAD, math.pi / 2 + math.asin(min(1.0, max(0.0, behind / door.width))))


def swing_box(door: OpeningDraft, leaf: LeafDraft) -> Rectangle:
    """Return the swing area: the rectangle around the sector that the leaf sweeps from closed to its angle [m].

    A leaf that stands less than a right angle open is treated as open to a right angle, because people open it further. The
    rectangle begins outside the face of the door's own wall.
    """
    behind = max(0.0, -math.cos(leaf.angle)) * door.width + LEAF_THICKNESS_M / 2
    return _box(door, leaf, -behind, door.width, door.width)


def resting_box(door: OpeningDraft, leaf: LeafDraft) -> Rectangle:
    """Return the bounding rectangle of the leaf, standing open at `leaf.angle` [m]."""
    tip, half = door.width * math.cos(leaf.angle), LEAF_THICKNESS_M / 2
    return _box(door, leaf, min(0.0, tip) - half, max(0.0, tip) + half, door.width * math.sin(leaf.angle))


def _box(door: OpeningDraft, leaf: LeafDraft, start: float, stop: float, depth: float) -> Rectangle:
    """Return the rectangle from `start` to `stop` along the wall, counted from the hinge, and `depth` into the room [m]."""
    along = (door.low + start, door.low + stop) if leaf.at_low else (door.high - stop, door.high - start)
    into_larger = door.larger_side == leaf.into
    cross = (door.at + _WALL_M, door.at + depth) if into_larger else (door.at - depth, door.at - _WALL_M)
    return (along[0], cross[0], along[1], cross[1]) if door.axis == 0 else (cross[0], along[0], cross[1], along[1])


def is_in_front(door: OpeningDraft, other: OpeningDraft, depth_m: float) -> bool:
    """Return whether the door's leaf is in the way of another opening.

    If the other opening has a leaf that swings into the same room, the door's leaf is in the way if the two swing areas
    overlap. Otherwise it is in the way if it stands within `depth_m` [m] in front of the other opening.
    """
    if door.leaf is None or door.leaf.into not in other.rooms or other is door:
        return False
    if other.leaf is not None and other.leaf.into == door.leaf.into:
        return overlap(swing_box(door, door.leaf), swing_box(other, other.leaf))
    return overlap(resting_box(door, door.leaf), other.around(depth_m))


def _swings_freely(
    door: OpeningDraft,
    leaf: LeafDraft,
    gaps: Sequence[OpeningDraft],
    rooms: Mapping[str, RoomSpec],
    obstacles: Sequence[Rectangle],
) -> bool:
    """Return whether the leaf's swing area is free, and the leaf at its angle blocks no other opening of the room.

    In a corridor, people must also be able to pass the tip of the leaf when it stands at a right angle.
    """
    room, swing, standing = rooms[leaf.into], swing_box(door, leaf), resting_box(door, leaf)
    passing = _PASSING_M if room.label in CIRCULATION_LABELS else 0.0
    needed = _box(door, leaf, -LEAF_THICKNESS_M / 2, door.width, door.width + passing) if passing else swing
    if any(overlap(needed, wall) or overlap(swing, wall) for wall in _walls(room)):
        return False
    if any(overlap(swing, obstacle) for obstacle in obstacles):
        return False
    for other in gaps:
        if other is door or leaf.into not in other.rooms:
            continue
        if other.leaf is not None and other.leaf.into == leaf.into and overlap(swing, swing_box(other, other.leaf)):
            return False
        if overlap(standing, other.around(FRONT_M)):
            return False
    return True


def _walls(room: RoomSpec) -> list[Rectangle]:
    """Return the room's walls as rectangles [m], 2 mm less than `_WALL_M` on each side, so that touching is no overlap."""
    edges = polygon_sides(room.polygon_m)
    return [grown((min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)), _WALL_M - 0.002) for (x0, y0), (x1, y1) in edges]
