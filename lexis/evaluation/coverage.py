"""How much of a walk a map is about: every other figure is silent on what the keyframes missed."""

import numpy as np
from jaxtyping import Float64

GAP_M = 3.0
"""Between two consecutive keyframes farther apart than this along the walk, the map knows nothing of the way [m]."""


def path_covered(distances_m: Float64[np.ndarray, "n"], length_m: float) -> float | None:
    """Share of a walk that lies between its first and its last keyframe and in no gap longer than 3 m, in [0, 1].

    A single keyframe covers nothing. None for a walk without length.

    Args:
        distances_m: how far along the true path every keyframe was taken, in any order [m].
        length_m: length of the true path [m].
    """
    if length_m <= 0:
        return None
    gaps = np.diff(np.sort(distances_m))
    return min(float(gaps[gaps <= GAP_M].sum()) / length_m, 1.0)
