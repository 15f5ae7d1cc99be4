"""Means over the cameras of a rig."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from scipy.sparse import csr_array

_Summand = TypeVar("_Summand", np.ndarray, csr_array)


def mean(of_cameras: Sequence[_Summand]) -> _Summand:
    """Return the mean of one array or sparse matrix for each camera; for a single camera, this is its array itself."""
    first, *others = of_cameras
    total = first
    for other in others:
        total = total + other
    return total * (1.0 / len(of_cameras)) if others else first
