"""Runs: maximal stretches of equal values in a sequence."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Shaped


class Stretch(NamedTuple):
    """Indices ``start`` to ``stop - 1``."""

    start: int
    stop: int

    @property
    def slice(self) -> slice:
        """For indexing arrays."""
        return slice(self.start, self.stop)


def stretches_of(values: Shaped[np.ndarray, "n"]) -> list[Stretch]:
    """The runs of equal consecutive values, in order; together they cover the sequence."""
    if not len(values):
        return []
    changes = np.flatnonzero(values[1:] != values[:-1]) + 1
    return [Stretch(a, b) for a, b in pairwise([0, *(int(i) for i in changes), len(values)])]
