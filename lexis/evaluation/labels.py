"""Accuracy of the room labels of keyframes (paper, Sec. IV). A keyframe without a label has -1 and counts as wrong."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Int

Labels = Int[np.ndarray, "n"]


def accuracy(predicted: Labels, truth: Labels) -> float | None:
    """Share of keyframes labelled as the room in which the camera truly is; None without keyframes."""
    return float(np.mean(predicted == truth)) if len(truth) else None


def graded_accuracy(predicted: Labels, allowed: Bool[np.ndarray, "n rooms"]) -> float | None:
    """Share of keyframes whose label is allowed at their position; None without keyframes.

    In a strip on either side of an open boundary between two rooms, the labels of both rooms are allowed.
    """
    right = allowed[np.arange(len(predicted)), predicted] & (predicted >= 0)  # as an index, -1 is the last label
    return float(np.mean(right)) if len(predicted) else None


def accuracy_per_room(predicted: Labels, truth: Labels, room_names: Sequence[str]) -> dict[str, float]:
    """Accuracy per true room name, for the names that occur, in the order of the vocabulary."""
    return {name: float(np.mean(predicted[truth == k] == k)) for k, name in enumerate(room_names) if np.any(truth == k)}
