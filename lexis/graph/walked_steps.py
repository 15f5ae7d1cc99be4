"""The steps of the walk: pairs of consecutive keyframes that the camera moved between."""

import numpy as np
from jaxtyping import Int

from lexis.graph.components import sessions_of
from lexis.inputs import MAX_VARIANCE
from lexis.keyframes import MAX_STEP_M
from lexis.maths.se3 import between, rotation_angle
from lexis.maths.stretches import consecutive_pairs
from lexis.maths.ties import rounded
from lexis.stairs import is_vertical
from lexis.types import LexisMap, Pairs, PerKeyframe, Positions

_CARRIED_M, _CARRIED_RAD = 0.5, 0.35
"""Largest difference between a step of the map and the same step of the odometry, if the robot was not carried [m, rad]."""
_SHORT_M = 1.0
"""Largest length of a step that a robot can walk even if it was carried in it [m]. Its surroundings are free space."""


def walked_pairs(positions: Positions, sessions: PerKeyframe) -> Pairs:
    """Return the pairs of consecutive keyframes of one session between which there is no gap in the recording.

    At a gap, the keyframes are more than `MAX_STEP_M` apart in the plan, and the camera may have moved anywhere. Rooms and
    passages use these pairs. Plans use `walked_steps`, which also knows lifts, and steps in which the robot was carried.
    """
    pairs = consecutive_pairs(sessions)
    steps = positions[pairs[:, 1], :2] - positions[pairs[:, 0], :2]
    return np.asarray(pairs[rounded(np.linalg.norm(steps, axis=1)) <= MAX_STEP_M])


def walked_steps(map: LexisMap) -> Int[np.ndarray, "m 2"]:
    """Return the pairs of consecutive keyframes between which a robot can move, because the camera did.

    There is none at a gap in the recording. The last keyframe of a session and the first keyframe of the next session are
    not consecutive. A vertical step of any length is a ride in a lift and no gap: the robot rode it, and can ride it again.
    If the robot was carried elsewhere in a step, a length of `_SHORT_M` already is a gap.
    """
    pairs, positions = consecutive_pairs(sessions_of(map.keyframes)), map.T_W_B[:, :3, 3]
    steps = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    lengths = np.linalg.norm(steps, axis=1)
    carried = np.isin(pairs[:, 1], carried_before(map)) & (lengths > _SHORT_M)
    return np.asarray(pairs[((lengths <= MAX_STEP_M) | is_vertical(steps)) & ~carried])


def carried_before(map: LexisMap) -> Int[np.ndarray, "k"]:
    """Return the ids of the keyframes before which the robot was carried elsewhere; see `lexis.sessions.kidnapping`.

    The odometry of the step that leads to such a keyframe is unknown, and its step in the map is another one.
    """
    unknown = [keyframe.step_covariance[0, 0] >= MAX_VARIANCE for keyframe in map.keyframes]
    pairs = consecutive_pairs(sessions_of(map.keyframes))
    pairs = pairs[np.array(unknown)[pairs[:, 1]]]
    odometry = np.stack([keyframe.T_O_B for keyframe in map.keyframes])
    stepped, estimated = (between(poses[pairs[:, 0]], poses[pairs[:, 1]]) for poses in (map.T_W_B, odometry))
    off_m = np.linalg.norm(stepped[:, :3, 3] - estimated[:, :3, 3], axis=1)
    off_rad = rotation_angle(between(stepped, estimated))
    return np.asarray(pairs[(off_m > _CARRIED_M) | (off_rad > _CARRIED_RAD), 1])
