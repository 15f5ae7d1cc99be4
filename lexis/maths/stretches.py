"""Division of a sequence into stretches (runs) of equal consecutive values, each as long as possible."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Shaped


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
