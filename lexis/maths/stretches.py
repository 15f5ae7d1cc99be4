"""Stretches (runs) of equal consecutive values in a sequence, each as long as possible, and the pairs inside them."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int, Shaped


class Stretch(NamedTuple):
    """A stretch of a sequence: the indices ``start`` to ``stop - 1``."""

    start: int
    stop: int

    @property
    def slice(self) -> slice:
        """The stretch as a slice, for indexing arrays."""
        return slice(self.start, self.stop)


def stretches_of(values: Shaped[np.ndarray, "n"]) -> list[Stretch]:
    """The stretches of equal consecutive values, in order; together they cover the sequence."""
    if not len(values):
        return []
    changes = np.flatnonzero(values[1:] != values[:-1]) + 1
    return [Stretch(a, b) for a, b in pairwise([0, *(int(i) for i in changes), len(values)])]


def true_stretches(mask: Bool[np.ndarray, "n"]) -> list[slice]:
    """Return the stretches in which a mask is true, in order, as slices for indexing arrays."""
    return [stretch.slice for stretch in stretches_of(mask) if mask[stretch.start]]


def consecutive_pairs(sessions: Shaped[np.ndarray, "n"]) -> Int[np.ndarray, "m 2"]:
    """Return the pairs of consecutive indices with equal values.

    For the sessions of keyframes, these are the steps of the walk: nobody walked from one session to the next.
    """
    first = np.flatnonzero(sessions[:-1] == sessions[1:])
    return np.stack([first, first + 1], axis=1)
