"""A map of two rooms with a door between them, whose landmarks lie exactly on the walls, and the stairs beside them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from helpers.landmarks import without_key_points
from helpers.map_builder import build_map

from lexis.graph.thinning import as_retired

ROOMS = {"kitchen": (0.0, 0.0, 4.0, 4.0), "office": (4.1, 0.0, 8.0, 4.0)}
"""True rooms as lowest and highest x and y; the wall between them is 0.1 m thick."""
DOOR = (1.3, 2.3)
CAMERA_M, CEILING_M = 1.4, 2.5
_HEIGHTS = (0.02, 0.8, 1.4, 1.8, 2.48)


def walls():
    """Ends of all walls: the outer ones, and both parts of the one with the door."""
    corners = [(0, 0), (8, 0), (8, 4), (0, 4), (0, 0)]
    sides = [(4, 0, 4, DOOR[0]), (4, DOOR[1], 4, 4), (4.1, 0, 4.1, DOOR[0]), (4.1, DOOR[1], 4.1, 4)]
    jambs = [(4, y, 4.1, y) for y in DOOR]
    return [(*a, *b) for a, b in pairwise(corners)] + sides + jambs


def seen_from(x, y):
    """Positions on the walls that a camera at x, y sees, all around and at several heights."""
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    distances = np.full(len(angles), np.inf)
    for x1, y1, x2, y2 in walls():
        dx, dy, ex, ey = np.cos(angles), np.sin(angles), x2 - x1, y2 - y1
        cross = dx * ey - dy * ex
        with np.errstate(divide="ignore", invalid="ignore"):
            along = ((x1 - x) * ey - (y1 - y) * ex) / cross
            where = ((x1 - x) * dy - (y1 - y) * dx) / cross
        hit = (along > 1e-6) & (where >= 0) & (where <= 1)
        distances[hit] = np.minimum(distances[hit], along[hit])
    plan = np.stack([x + distances * np.cos(angles), y + distances * np.sin(angles)], axis=1)
    return np.concatenate([np.column_stack((plan, np.full(len(plan), z))) for z in _HEIGHTS])


def two_rooms(rng, stairs=True):
    """The map: a walk through the kitchen, the door and the office, and up some stairs beyond the wall."""
    x = np.concatenate([np.linspace(1, 3, 5), np.linspace(3, 3, 3), np.linspace(3.4, 7, 9), np.linspace(7, 5, 5)])
    y = np.concatenate([np.full(5, 1.0), np.linspace(1.3, 2, 3), np.full(9, 2.0), np.full(5, 3.0)])
    positions = np.column_stack((x, y, np.full(len(x), CAMERA_M)))
    labels = np.where(x < 4.05, 0, 1)
    if stairs:
        climb = np.column_stack((np.full(4, 9.0), np.arange(4.0), CAMERA_M + 0.5 * np.arange(1, 5)))
        positions, labels = np.concatenate([positions, climb]), np.append(labels, [2] * 4)
    names = ("kitchen", "office", "stairs")
    members = [(name, np.flatnonzero(labels == i).tolist()) for i, name in enumerate(names[: labels.max() + 1])]
    flat = build_map(positions, labels, members, names, rng)
    keyframes = []
    for keyframe, T_W_B in zip(flat.keyframes, flat.T_W_B, strict=True):
        points = seen_from(*T_W_B[:2, 3]) if T_W_B[0, 3] < 8 else np.zeros((0, 3))
        local = (points - T_W_B[:3, 3]) @ T_W_B[:3, :3]
        keyframes.append(replace(keyframe, landmarks=without_key_points(local)))
    rooms = tuple(replace(room, floor=None if room.label == "stairs" else 0) for room in flat.rooms)
    return replace(flat, keyframes=tuple(keyframes), rooms=rooms, floors=np.where(labels == 2, -1, 0))


def walked_again(lexis_map, way):
    """The map after the robot has passed the keyframes `way` once more; the new keyframes have retired at once."""
    n, shown_by = len(lexis_map.keyframes), np.append(np.arange(len(lexis_map.keyframes)), way)
    T_W_B = lexis_map.T_W_B[shown_by]
    T_W_B[n:, 0, 3] += 0.05
    again = (
        as_retired(replace(lexis_map.keyframes[i], id=n + k, stamp=1e3 + k), lexis_map.keyframes[i])
        for k, i in enumerate(way)
    )
    rooms = (
        replace(room, keyframes=tuple(np.flatnonzero(np.isin(shown_by, room.keyframes)).tolist()))
        for room in lexis_map.rooms
    )
    names = ("similarities", "baseline_labels", "labels", "probabilities", "floors")
    per_keyframe = {name: getattr(lexis_map, name)[shown_by] for name in names}
    return replace(lexis_map, keyframes=(*lexis_map.keyframes, *again), T_W_B=T_W_B, rooms=tuple(rooms), **per_keyframe)


def with_session_apart(lexis_map, shift):
    """The map with the same walk once more, as a session that is not recognised and lies at `shift` [m]."""
    n, twice = len(lexis_map.keyframes), np.tile(np.arange(len(lexis_map.keyframes)), 2)
    again = tuple(replace(keyframe, id=n + keyframe.id, session=1) for keyframe in lexis_map.keyframes)
    T_W_B = lexis_map.T_W_B[twice]
    T_W_B[n:, :3, 3] += shift
    rooms = lexis_map.rooms + tuple(
        replace(room, id=len(lexis_map.rooms) + room.id, keyframes=tuple(n + i for i in room.keyframes))
        for room in lexis_map.rooms
    )
    return replace(
        lexis_map, keyframes=lexis_map.keyframes + again, T_W_B=T_W_B, rooms=rooms, **_per_keyframe(lexis_map, twice)
    )


def _per_keyframe(lexis_map, rows):
    """The arrays of a map with a row for each keyframe, besides the poses."""
    names = ("similarities", "baseline_labels", "labels", "probabilities", "floors")
    return {name: getattr(lexis_map, name)[rows] for name in names}
