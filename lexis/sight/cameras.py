"""What several cameras of a rig see, joined: means of evidence, and shares of the space that any camera sees."""

from collections.abc import Sequence
from functools import reduce
from typing import TypeVar

import numpy as np
from scipy.sparse import csr_array

_Summand = TypeVar("_Summand", np.ndarray, csr_array)


def mean(of_cameras: Sequence[_Summand]) -> _Summand:
    """Return the mean of one array or sparse matrix for each camera; with a single camera, its array unchanged."""
    first, *others = of_cameras
    total = first
    for other in others:
        total = total + other
    return total * (1.0 / len(of_cameras)) if others else first


def largest(of_cameras: Sequence[csr_array]) -> csr_array:
    """Return the largest of the entries of one sparse matrix for each camera, entry by entry."""
    return reduce(lambda one, other: csr_array(one.maximum(other)), of_cameras)
