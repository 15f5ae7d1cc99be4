"""Narrow passages, such as doorways, on the path of the robot.

A doorway lies between two rooms, even if they have the same name, such as two corridors. The robot goes through it, and
images from both sides show both of its sides.

1. Divide each floor into cells. A cell is occupied if many of the views that reach it see a landmark in it, at about the
   height of the camera (`lexis.sight.cells`). Lower furniture narrows a path, but is no wall.
2. At places on the steps from one keyframe to the next, measure how wide the free space is, in several directions across the
   step: from the occupied cell on one side to the one on the other side.
3. Where the path goes through space that is at most `passage_m` wide, the middle of the narrowest places is a passage. The
   passage is a line on the plan: what is on one side of it sees the other side only through the passage. Two doorways count
   as one passage if all of the path between them is as narrow.

The result does not depend on the frame W: the cells are aligned with the path.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.ndimage import distance_transform_edt

from lexis.config import SightConfig
from lexis.floors import NO_FLOOR
from lexis.graph.components import sessions_of
from lexis.graph.walked_steps import walked_pairs
from lexis.maths.se3 import transform
from lexis.maths.ties import rounded
from lexis.sight.cells import CELL_M, WALKED_M, cells_at, count_view, grid_around, occupied, on_lines_of_sight
from lexis.sight.visible_space import OBSTACLE_RANGE_M, VisibleSpace, spaces_in_view
from lexis.types import Camera, LexisMap, Pairs, PerKeyframe, Poses, Positions

_DIRECTIONS = 12
"""Number of directions in which the width of the free space is measured. With 12, they are 15 degrees apart."""
_ACROSS = 0.6
"""A passage lies across the step: the cosine of the angle between them is at most this, which is an angle of 53 degrees."""
_STRIDE_M = CELL_M / 2
"""Distance between the positions at which one looks for an occupied cell [m]."""
_GAP_M = 0.3
"""Places on the path that are farther apart than this belong to two passages [m]."""
_OCCUPIED_SHARE = 0.5
"""A cell is occupied if h / (h + p) is at least this share, where h views see a landmark in the cell and p views look
through the cell."""
_LEAST_HITS = 2
"""Least number of views that see a landmark in an occupied cell, because single landmarks may be wrong."""

PlanPositions = Float64[np.ndarray, "m 2"]
"""Positions x and y on a floor [m]."""


@dataclass(frozen=True, eq=False)
class LinesOfSight:
    """The lines of sight from the cameras to the landmarks at about their height, seen from above."""

    view: Int[np.ndarray, "m"]
    """Number of the image to which each line belongs, ascending."""
    keyframe: Int[np.ndarray, "m"]
    """The keyframe to which each image belongs."""
    start: PlanPositions
    """Position of the camera in W."""
    end: PlanPositions
    """Position of the landmark in W."""


@dataclass(frozen=True, eq=False)
class Passages:
    """Narrow passages: for each of them, its floor and its ends."""

    floor: Int[np.ndarray, "k"]
    ends: Float64[np.ndarray, "k 2 2"]
    """Positions x and y in W of the two ends of each passage [m]."""


def lines_of_sight(spaces: Sequence[tuple[VisibleSpace, ...]], T_W_B: Poses, camera: Camera) -> LinesOfSight:
    """Return the lines of sight of all cameras of all keyframes.

    Args:
        spaces: what `lexis.sight.visible_space.spaces_in_view` returns for each keyframe.
        T_W_B: poses of the keyframes.
        camera: the camera, with the others of its rig.
    """
    view, keyframe, start, end = [], [], [np.zeros((0, 2))], [np.zeros((0, 2))]
    for number, each in enumerate(camera.rig):
        for i, T_W_C in enumerate(T_W_B @ each.T_B_C):
            seen = spaces[i][number].obstacles
            view.append(np.full(len(seen), number * len(T_W_B) + i))
            keyframe.append(np.full(len(seen), i))
            start.append(np.broadcast_to(T_W_C[:2, 3], (len(seen), 2)))
            end.append(transform(T_W_C, seen)[:, :2])
    none = np.zeros(0, int)
    return LinesOfSight(
        np.concatenate([none, *view]), np.concatenate([none, *keyframe]), np.concatenate(start), np.concatenate(end)
    )


def passages_in(map: LexisMap, config: SightConfig) -> Passages:
    """Find the narrow passages of a saved map."""
    spaces = [spaces_in_view(keyframe, map.camera, config) for keyframe in map.keyframes]
    lines, sessions = lines_of_sight(spaces, map.T_W_B, map.camera), sessions_of(map.keyframes)
    return narrow_passages(lines, map.floors, map.T_W_B[:, :3, 3], sessions, config.passage_m)


def narrow_passages(
    lines: LinesOfSight, floors: PerKeyframe, positions: Positions, sessions: PerKeyframe, widest_m: float
) -> Passages:
    """Find the narrow passages on the steps between consecutive keyframes of one floor.

    Args:
        lines: the lines of sight of the keyframes.
        floors: floor of every keyframe; `NO_FLOOR` on stairs, where no passages are sought.
        positions: positions of the keyframes in W [m].
        sessions: session of every keyframe.
        widest_m: largest width of a passage [m]; no passage is narrower than 0.4 m.
    """
    steps = walked_pairs(positions, sessions)
    steps = steps[(floors[steps[:, 0]] == floors[steps[:, 1]]) & (floors[steps[:, 0]] != NO_FLOOR)]
    steps = steps[rounded(np.linalg.norm(positions[steps[:, 1], :2] - positions[steps[:, 0], :2], axis=1)) > 0.0]
    if not len(lines.view) or widest_m < 2 * WALKED_M:
        steps = steps[:0]
    floor, ends = [np.zeros(0, int)], [np.zeros((0, 2, 2))]
    for each in np.unique(floors[steps[:, 0]]).tolist():
        here = floors[lines.keyframe] == each
        of_floor = LinesOfSight(lines.view[here], lines.keyframe[here], lines.start[here], lines.end[here])
        found = _on_floor(of_floor, positions[:, :2], steps[floors[steps[:, 0]] == each], widest_m)
        floor.append(np.full(len(found), each))
        ends.append(found)
    return Passages(np.concatenate(floor), np.concatenate(ends))


def _on_floor(
    lines: LinesOfSight, positions: Float64[np.ndarray, "n 2"], steps: Pairs, widest_m: float
) -> Float64[np.ndarray, "k 2 2"]:
    """Return the ends of the passages on some steps, all of one floor."""
    origin, axes = _own_frame(positions[np.unique(steps)])
    own = LinesOfSight(lines.view, lines.keyframe, (lines.start - origin) @ axes.T, (lines.end - origin) @ axes.T)
    path = (positions - origin) @ axes.T
    step, places = _places(path, steps)
    angles = np.arange(_DIRECTIONS) * np.pi / _DIRECTIONS
    left = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    free = _free_distances(own, places, np.concatenate([left, -left]), widest_m)
    widths = free[:, :_DIRECTIONS] + free[:, _DIRECTIONS:]
    ahead = path[steps[:, 1]] - path[steps[:, 0]]
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    widths[np.abs(ahead @ left.T)[step] > _ACROSS] = np.inf
    direction, width = rounded(widths).argmin(axis=1), rounded(widths.min(axis=1))
    narrow = np.flatnonzero(width <= widest_m)
    if not len(narrow):
        return np.zeros((0, 2, 2))
    middle = narrow[_middles(places[narrow], steps[step[narrow], 0], width[narrow])]
    direction = direction[middle]
    ends = [
        places[middle] + left[direction] * free[middle, direction, None],
        places[middle] - left[direction] * free[middle, direction + _DIRECTIONS, None],
    ]
    return np.asarray(np.stack(ends, axis=1) @ axes + origin)


def _middles(
    places: PlanPositions, step: Int[np.ndarray, "m"], widths: Float64[np.ndarray, "m"]
) -> Int[np.ndarray, "passages"]:
    """Return the index of one place for each passage: the one closest to the middle of the narrowest places.

    Args:
        places: the narrow places, in the order of the path.
        step: the first keyframe of the step that each place is on.
        widths: width of the free space at each place [m].
    """
    apart = (rounded(np.linalg.norm(np.diff(places, axis=0), axis=1)) > _GAP_M) | (np.diff(step) > 1)
    passage = np.append(0, np.cumsum(apart))
    starts = np.flatnonzero(np.diff(passage, prepend=-1))
    narrowest = np.flatnonzero(widths == np.minimum.reduceat(widths, starts)[passage])
    passage = passage[narrowest]
    sums = np.stack([np.bincount(passage, places[narrowest, axis]) for axis in (0, 1)], axis=1)
    middles = sums / np.bincount(passage)[:, None]
    distances = rounded(np.linalg.norm(places[narrowest] - middles[passage], axis=1))
    return np.asarray(narrowest[np.lexsort((distances, passage))[np.searchsorted(passage, np.arange(len(starts)))]])


def _own_frame(path: PlanPositions) -> tuple[Float64[np.ndarray, "2"], Float64[np.ndarray, "2 2"]]:
    """Return the origin and the axes (as rows) of a frame that moves with the path: from its first to its farthest place."""
    farthest = path[rounded(np.linalg.norm(path - path[0], axis=1)).argmax()] - path[0]
    x, y = (farthest / np.linalg.norm(farthest)).tolist()
    return path[0], np.array([[x, y], [-y, x]])


def _places(
    path: Float64[np.ndarray, "n 2"], steps: Pairs
) -> tuple[Int[np.ndarray, "places"], Float64[np.ndarray, "places 2"]]:
    """Return places on the steps, at most the width of a cell apart, and to which step each place belongs, ascending."""
    ahead = path[steps[:, 1]] - path[steps[:, 0]]
    count = np.ceil(np.linalg.norm(ahead, axis=1) / CELL_M).astype(int)
    step = np.repeat(np.arange(len(steps)), count)
    share = (np.arange(len(step)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[step]
    return step, path[steps[step, 0]] + share[:, None] * ahead[step]


def _free_distances(
    lines: LinesOfSight, places: PlanPositions, directions: Float64[np.ndarray, "directions 2"], widest_m: float
) -> Float64[np.ndarray, "m directions"]:
    """Return how far it is from each place to the next occupied cell in each direction; infinite beyond `widest_m`."""
    result = np.full((len(places), len(directions)), np.inf)
    around = np.concatenate([places - widest_m, places + widest_m, lines.start, lines.end])
    origin, size = grid_around(around.min(axis=0) - CELL_M, around.max(axis=0) + CELL_M)
    if size is None:
        return result
    filled = _occupied(lines, origin, size)
    # In a passage, an occupied cell is at most half of the width away. Two cells are added, because distances are taken from
    # the middles of cells.
    near = distance_transform_edt(~filled) * CELL_M <= widest_m / 2 + 2 * CELL_M
    narrow = np.flatnonzero(near[tuple(cells_at(origin, places).T)])
    distances = np.arange(WALKED_M, widest_m + _STRIDE_M, _STRIDE_M)
    for direction, way in enumerate(directions):
        rows, columns = cells_at(origin, (places[narrow, None] + way * distances[:, None]).reshape(-1, 2)).T
        blocked = filled[rows, columns].reshape(len(narrow), len(distances))
        met = blocked.any(axis=1)
        result[narrow[met], direction] = distances[blocked[met].argmax(axis=1)]
    return result


def _occupied(
    lines: LinesOfSight, origin: Float64[np.ndarray, "2"], size: tuple[int, int]
) -> Bool[np.ndarray, "rows columns"]:
    """Return which cells of a grid are occupied."""
    passed, hit = np.zeros(size, np.int32), np.zeros(size, np.int32)
    views = np.flatnonzero(np.diff(lines.view, prepend=-1))[1:]  # where the lines of the next view start
    for start, end in zip(np.split(lines.start, views), np.split(lines.end, views), strict=True):
        if len(start):
            count_view(passed, cells_at(origin, on_lines_of_sight(start[0], end, OBSTACLE_RANGE_M)))
            count_view(hit, cells_at(origin, end))
    return occupied(hit, passed, _OCCUPIED_SHARE) & (hit >= _LEAST_HITS)
