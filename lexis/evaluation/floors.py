"""Accuracy of the floor numbers of keyframes."""

import numpy as np
from jaxtyping import Bool, Int

Floors = Int[np.ndarray, "n"]


def floor_accuracy(predicted: Floors, truth: Floors, on_stairs: Bool[np.ndarray, "n"]) -> float | None:
    """Return the share of keyframes with the right floor, among the keyframes that are truly not on stairs.

    The result is None if there are no such keyframes. Predicted and true floors are numbered from 0 for the lowest that
    the walk visits. A keyframe wrongly predicted on stairs (-1) is an error.
    """
    return float(np.mean(predicted[~on_stairs] == truth[~on_stairs])) if np.any(~on_stairs) else None


def floor_count_error(predicted: Floors, truth: Floors, on_stairs: Bool[np.ndarray, "n"]) -> int | None:
    """Predicted minus true number of floors with keyframes; None without keyframes."""
    if not len(truth):
        return None
    return len(np.unique(predicted[predicted >= 0])) - len(np.unique(truth[~on_stairs]))
