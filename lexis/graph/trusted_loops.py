"""`is_trusted`: which loop closures count as true, by their weights after the optimisation."""

import numpy as np
from jaxtyping import Bool, Float64

TRUSTED_WEIGHT = 0.5
"""Least weight of a trusted loop closure. A loop closure with a smaller weight counts as rejected."""


def is_trusted(weights: Float64[np.ndarray, "loops"]) -> Bool[np.ndarray, "loops"]:
    """Return which loop closures are trusted, from their weights in [0, 1] by the robust kernel (see `loop_weights`)."""
    return np.asarray(weights >= TRUSTED_WEIGHT)
