"""Arc length of paths."""

import numpy as np
from jaxtyping import Float64


def arc_length(points: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "n"]:
    """Length of the polyline from its first point to each of its points [m]."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))[: len(points)]
