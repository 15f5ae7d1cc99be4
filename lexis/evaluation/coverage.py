"""Coverage: the share of a walk that a map describes. All other metrics ignore the parts of the walk without keyframes."""

import numpy as np
from jaxtyping import Float64

GAP_M = 3.0
"""Longest path between consecutive keyframes that still counts as covered [m]."""


def path_covered(distances_m: Float64[np.ndarray, "n"], length_m: float) -> float | None:
    """Share of the walk, in [0, 1], that lies between consecutive keyframes at most 3 m of path apart.

    A single keyframe covers nothing. The result is None for a walk without length.

    Args:
        distances_m: distance of every keyframe along the true path, in any order [m].
        length_m: length of the true path [m].
    """
    if length_m <= 0:
        return None
    gaps = np.diff(np.sort(distances_m))
    return min(float(gaps[gaps <= GAP_M].sum()) / length_m, 1.0)
