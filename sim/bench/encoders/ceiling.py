"""The ceiling: the label accuracy that a single frame allows, estimated by a random forest on ground truth.

The input of the forest is the true share of the image that shows each kind of thing. A perfect score is impossible: a camera
that looks through an opening shows mostly the next room, but by the LEXIS paper's definition only the room that
contains the camera is right. So the benchmark groups frames by the share of the image that the camera's room fills. It
also reports the score of an ideal observer, which knows the room label of every pixel and names the label that fills most
of the image.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from sim.bench.encoders.retrieval import share
from sim.errors import SimError
from sim.training.frames import Frames, frames_by_house
from worlds.labels import ROOM_LABELS

Ceiling = Callable[[Frames], Int[np.ndarray, "n"]]
"""A function that predicts for every frame the label of the camera's room, as an index into `ROOM_LABELS`. It chooses only
among labels of rooms in which at least one of the frames was taken."""
OWN_ROOM = (0.25, 0.5, 0.75)
"""Limits between groups of frames (`Band`). Frames are grouped by the share of the image that shows rooms with the label of
the camera's room."""
_TREES = 100


@dataclass(frozen=True)
class Band:
    """The frames in which rooms with the label of the camera's room fill a share of the image between `low` and `high`.

    The share `low` itself counts; the share `high` counts only if it is 1.
    """

    low: float
    high: float
    share: float
    """Share of all frames that are in the band."""
    right: Mapping[str, float | None]
    """Share of right answers among the frames of this `Band`, by the name of the method; None if the band has no frames."""


def ceiling_of(work: Path) -> Ceiling:
    """Train a ceiling classifier on all frames in a work folder of `train-encoder`.

    Raises `SimError` if the folder has no frames or scikit-learn is not installed.
    """
    # The frames are of training and tuning houses, never of test houses. They are read house by house, and only what the
    # forest needs is kept, since all images together do not fit into memory.
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
    """Return for each frame the share of the image that shows rooms with the label of the camera's room.

    The objects in these rooms count as parts of the rooms.
    """
    return np.asarray(frames.views[np.arange(len(frames.rooms)), frames.rooms])


def own_room_prevails(frames: Frames) -> Bool[np.ndarray, "n"]:
    """Return for each frame whether the room label with the largest share of the image is that of the camera's room."""
    return np.asarray(own_room(frames) >= frames.views.max(axis=1))


def by_own_room(own: Float[np.ndarray, "n"], right: Mapping[str, Bool[np.ndarray, "n"]]) -> list[Band]:
    """Compute the shares of right answers for each `Band` between the limits `OWN_ROOM`, and last for all frames."""
    edges: Sequence[float] = (0.0, *OWN_ROOM, 1.0)
    inside = [(low, high, np.digitize(own, OWN_ROOM) == i) for i, (low, high) in enumerate(pairwise(edges))]
    return [
        Band(low, high, float(band.mean()), {name: share(answers[band]) for name, answers in right.items()})
        for low, high, band in (*inside, (0.0, 1.0, np.ones(len(own), bool)))
    ]
