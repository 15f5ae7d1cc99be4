"""Finds lines between keyframes that cross a doorway or another narrow passage, and measures distances from passages.

`lexis.sight.passages` finds these passages.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.spatial import cKDTree

from lexis.keyframes import MAX_STEP_M
from lexis.maths.ties import rounded
from lexis.sight.cells import CELL_M
from lexis.sight.passages import Passages, PlanPositions
from lexis.types import Pairs, PerKeyframe, Positions


def crossed(found: Passages, floors: PerKeyframe, positions: Positions, pairs: Pairs) -> Bool[np.ndarray, "p"]:
    """Return which straight lines between two keyframes cross a passage of the floor of the first keyframe.

    Longer lines than `MAX_STEP_M` cross none: they are gaps in the recording, in which the robot may have gone anywhere.
    """
    result = np.zeros(len(pairs), bool)
    result[_crossings(found, floors, positions, pairs)[0]] = True
    return result


def distances_from_crossed(
    found: Passages, floors: PerKeyframe, positions: Positions, pairs: Pairs
) -> Float64[np.ndarray, "p"]:
    """Return how far the first keyframe of each pair is from the passages on the straight line to the second one [m].

    It is the distance from the nearest of these passages, seen from above, and infinite if the line crosses none; see
    `crossed`.
    """
    pair, passage = _crossings(found, floors, positions, pairs)
    result = np.full(len(pairs), np.inf)
    np.minimum.at(result, pair, _distances(found, passage, positions[pairs[pair, 0], :2]))
    return result


def distances_from_nearest(found: Passages, floors: PerKeyframe, positions: Positions) -> Float64[np.ndarray, "n"]:
    """Return how far each keyframe is from the nearest passage of its floor, seen from above [m].

    The distance is infinite on floors without passages.
    """
    keyframe, passage = np.nonzero(floors[:, None] == found.floor)
    result = np.full(len(floors), np.inf)
    np.minimum.at(result, keyframe, _distances(found, passage, positions[keyframe, :2]))
    return result


def _distances(
    found: Passages, passages: Int[np.ndarray, "m"], points: Float64[np.ndarray, "m 2"]
) -> Float64[np.ndarray, "m"]:
    """Return the distance of each point from one of the passages [m]."""
    start, end = found.ends[passages].transpose(1, 0, 2)
    along = ((points - start) * (end - start)).sum(axis=1) / ((end - start) ** 2).sum(axis=1)
    nearest = start + np.clip(along, 0.0, 1.0)[:, None] * (end - start)
    return np.asarray(np.linalg.norm(points - nearest, axis=1))


def _crossings(
    found: Passages, floors: PerKeyframe, positions: Positions, pairs: Pairs
) -> tuple[Int[np.ndarray, "c"], Int[np.ndarray, "c"]]:
    """Return all crossings, as the index of a pair and the index of the passage that its line crosses."""
    first, second = positions[pairs[:, 0], :2], positions[pairs[:, 1], :2]
    short = rounded(np.linalg.norm(second - first, axis=1)) <= MAX_STEP_M
    if not short.any() or not len(found.ends):
        return np.zeros(0, int), np.zeros(0, int)
    # Two lines cross only if their middles are not farther apart than half of their lengths together.
    reach = (MAX_STEP_M + np.linalg.norm(np.diff(found.ends, axis=1), axis=2).max()) / 2
    near = cKDTree((first + second)[short] / 2).query_ball_point(found.ends.mean(axis=1), reach + CELL_M)
    pair = np.flatnonzero(short)[np.concatenate(near).astype(int)]
    passage = np.repeat(np.arange(len(near)), [len(each) for each in near])
    a, b = found.ends[passage].transpose(1, 0, 2)
    cross = _beside(first[pair], second[pair], a) * _beside(first[pair], second[pair], b) < 0
    cross &= _beside(a, b, first[pair]) * _beside(a, b, second[pair]) < 0
    cross &= found.floor[passage] == floors[pairs[pair, 0]]
    return pair[cross], passage[cross]


def _beside(start: PlanPositions, end: PlanPositions, point: PlanPositions) -> Float64[np.ndarray, "m"]:
    """Return on which side of the line from `start` to `end` each point is, as a positive or negative number, or 0."""
    ahead, there = end - start, point - start
    return np.asarray(rounded(ahead[:, 0] * there[:, 1] - ahead[:, 1] * there[:, 0]))
