"""The steps of the walk: pairs of consecutive keyframes that the camera moved between."""

import numpy as np
from jaxtyping import Int

from lexis.graph.components import sessions_of
from lexis.keyframes import MAX_STEP_M
from lexis.maths.stretches import consecutive_pairs
from lexis.stairs import is_vertical
from lexis.types import LexisMap


def walked_steps(map: LexisMap) -> Int[np.ndarray, "m 2"]:
    """Return the pairs of consecutive keyframes, except at gaps in the recording.

    The last keyframe of a session and the first keyframe of the next session are not consecutive. A vertical step of any
    length is a ride in a lift and no gap: the robot rode it, and can ride it again.
    """
    pairs, positions = consecutive_pairs(sessions_of(map.keyframes)), map.T_W_B[:, :3, 3]
    steps = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    return np.asarray(pairs[(np.linalg.norm(steps, axis=1) <= MAX_STEP_M) | is_vertical(steps)])
