"""The steps of the walk: pairs of consecutive keyframes that the camera moved between."""

import numpy as np
from jaxtyping import Float64, Int

from lexis.graph.components import sessions_of
from lexis.keyframes import MAX_STEP_M
from lexis.maths.se3 import between
from lexis.maths.stretches import consecutive_pairs
from lexis.stairs import is_vertical
from lexis.types import LexisMap, Poses

_CARRIED_M = 1.0
"""Largest difference between a step of the map and the same step of the odometry, if the robot was not carried [m]."""


def walked_steps(map: LexisMap) -> Int[np.ndarray, "m 2"]:
    """Return the pairs of consecutive keyframes, except at gaps in the recording.

    The last keyframe of a session and the first keyframe of the next session are not consecutive. A vertical step of any
    length is a ride in a lift and no gap: the robot rode it, and can ride it again. A step in which the robot was carried
    elsewhere is a gap of any length.
    """
    pairs, positions = consecutive_pairs(sessions_of(map.keyframes)), map.T_W_B[:, :3, 3]
    steps = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    walked = (np.linalg.norm(steps, axis=1) <= MAX_STEP_M) | is_vertical(steps)
    return np.asarray(pairs[walked & ~np.isin(pairs[:, 1], carried_before(map))])


def carried_before(map: LexisMap) -> Int[np.ndarray, "k"]:
    """Return the ids of the keyframes before which the robot was carried elsewhere; see `lexis.sessions.kidnapping`.

    The step that leads to such a keyframe differs by more than `_CARRIED_M` from the odometry's.
    """
    pairs = consecutive_pairs(sessions_of(map.keyframes))
    odometry = np.stack([keyframe.T_O_B for keyframe in map.keyframes])
    carried_m = np.linalg.norm(_steps_of(map.T_W_B, pairs) - _steps_of(odometry, pairs), axis=1)
    return np.asarray(pairs[carried_m > _CARRIED_M, 1])


def _steps_of(poses: Poses, pairs: Int[np.ndarray, "m 2"]) -> Float64[np.ndarray, "m 3"]:
    """Return the position of the second keyframe of every pair in the frame of the first [m]."""
    return between(poses[pairs[:, 0]], poses[pairs[:, 1]])[:, :3, 3]
