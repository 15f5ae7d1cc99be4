"""Whether stated probabilities are calibrated: of predictions with a probability of 0.8, four in five should be right."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Float64

_BINS = 15
"""Number of intervals of equal width for the calibration error, as in Guo et al. (2017)."""


@dataclass(frozen=True)
class Reliability:
    """The predictions whose stated probabilities lie in one interval."""

    low: float
    high: float
    """The interval, which includes `low`, and `high` only if that is 1."""
    predictions: int
    stated: float | None
    """Mean of the stated probabilities; None without predictions."""
    right: float | None
    """Share of the predictions that are right; None without predictions."""


def reliability(
    stated: Float64[np.ndarray, "n"], right: Bool[np.ndarray, "n"], edges: Sequence[float]
) -> tuple[Reliability, ...]:
    """Compare stated probabilities with the shares of right predictions, in each interval between consecutive `edges`."""
    interval_of = np.digitize(stated, edges[1:-1])
    rows = []
    for i, (low, high) in enumerate(pairwise(edges)):
        inside = interval_of == i
        means = (float(stated[inside].mean()), float(right[inside].mean())) if inside.any() else (None, None)
        rows.append(Reliability(low, high, int(inside.sum()), *means))
    return tuple(rows)


def calibration_error(stated: Float[np.ndarray, "n"], right: Bool[np.ndarray, "n"]) -> float:
    """Return the expected calibration error of one or more predictions.

    It is the mean gap between stated probabilities and shares of right predictions in intervals of equal width, weighted by
    the predictions of each interval (Guo et al., "On calibration of modern neural networks", ICML 2017).
    """
    index = np.minimum((stated * _BINS).astype(int), _BINS - 1)
    gaps = [abs(float((stated - right)[index == b].sum())) for b in range(_BINS)]
    return sum(gaps) / len(stated)
