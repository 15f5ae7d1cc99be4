"""How much of the room one frame can tell: a random forest on the true visible share of every thing.

A camera that looks through an opening shows the next room, and by the paper's definition only the room that holds the camera
is right. So the report tells frames that their own room fills from those that it does not, and has beside the ceiling what
an eye would get that knew the label of every pixel's room, and named the one that fills most of the image.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from sim.errors import SimError
from sim.training.frames import Frames, frames_by_house
from worlds.labels import ROOM_LABELS

Ceiling = Callable[[Frames], Int[np.ndarray, "n"]]
"""Index into `ROOM_LABELS` of every frame's room, out of those that occur among the frames."""
OWN_ROOM = (0.25, 0.5, 0.75)
"""Bounds of the share of the image that shows rooms of the camera's own label."""
_TREES = 100


@dataclass(frozen=True)
class Band:
    """Frames whose own room fills so much of the image."""

    low: float
    high: float
    share: float
    """Of all frames."""
    right: Mapping[str, float | None]
    """Share of right answers, by who answers; None without frames."""


def ceiling_of(work: Path) -> Ceiling:
    """A classifier trained on all frames in a work folder of `train-encoder`. Raises `SimError` without any."""
    # Of training and tuning houses, never of test houses; their images would fill the memory.
    shares, rooms = zip(*((frames.shares, frames.rooms) for frames in frames_by_house(work / "frames")), strict=True)
    try:
        from sklearn.ensemble import RandomForestClassifier
    except ImportError:
        raise SimError(
            "the ceiling needs scikit-learn; valid: an environment with the group 'tests', or no --work"
        ) from None
    forest: Any = RandomForestClassifier(_TREES, min_samples_leaf=2, random_state=0)
    forest.fit(np.concatenate(shares), np.concatenate(rooms))

    def best(seen: Frames) -> Int[np.ndarray, "n"]:
        scores = np.zeros((len(seen.rooms), len(ROOM_LABELS)))
        scores[:, forest.classes_] = forest.predict_proba(seen.shares)
        present = np.unique(seen.rooms)
        return np.asarray(present[scores[:, present].argmax(axis=1)])

    return best


def own_room(frames: Frames) -> Float[np.ndarray, "n"]:
    """The share of the image that shows rooms of the camera's own label, and what stands in them."""
    return np.asarray(frames.views[np.arange(len(frames.rooms)), frames.rooms])


def own_room_prevails(frames: Frames) -> Bool[np.ndarray, "n"]:
    """Whether no other label's rooms fill more of the image than those of the camera's own label."""
    return np.asarray(own_room(frames) >= frames.views.max(axis=1))


def by_own_room(own: Float[np.ndarray, "n"], right: Mapping[str, Bool[np.ndarray, "n"]]) -> list[Band]:
    """Right answers by how much of the image the camera's own room fills; at the end, of all frames."""
    edges: Sequence[float] = (0.0, *OWN_ROOM, 1.0)
    inside = [(low, high, np.digitize(own, OWN_ROOM) == i) for i, (low, high) in enumerate(pairwise(edges))]
    return [
        Band(low, high, float(band.mean()), {name: _mean(answers[band]) for name, answers in right.items()})
        for low, high, band in (*inside, (0.0, 1.0, np.ones(len(own), bool)))
    ]


def _mean(right: Bool[np.ndarray, "n"]) -> float | None:
    return float(right.mean()) if len(right) else None
