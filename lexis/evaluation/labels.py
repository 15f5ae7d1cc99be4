"""How many keyframes carry the right room name (paper, Sec. IV)."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Int

Labels = Int[np.ndarray, "n"]


def accuracy(predicted: Labels, truth: Labels) -> float | None:
    """Share of keyframes whose label is that of the true room that holds the camera; None without keyframes."""
    return float(np.mean(predicted == truth)) if len(truth) else None


def graded_accuracy(predicted: Labels, allowed: Bool[np.ndarray, "n rooms"]) -> float | None:
    """Share of keyframes whose label is one of those allowed there: either side's in the band of an open boundary."""
    return float(np.mean(allowed[np.arange(len(predicted)), predicted])) if len(predicted) else None


def accuracy_per_room(predicted: Labels, truth: Labels, room_names: Sequence[str]) -> dict[str, float]:
    """Accuracy over the keyframes of every true room name that occurs, in the vocabulary's order."""
    return {name: float(np.mean(predicted[truth == k] == k)) for k, name in enumerate(room_names) if np.any(truth == k)}
