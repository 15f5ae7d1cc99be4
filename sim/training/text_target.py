"""What the text tower is to say: the teacher's embedding, seen through a fixed linear map that gives rooms more room.

The map whitens what varies among captions of one room (frames, style, which of its things) and keeps what tells rooms apart,
as in linear discriminant analysis, shrunk far enough to keep all other meaning; then the leading directions are kept.
It is fitted on trained captions only.
"""

from dataclasses import dataclass
from itertools import chain

import numpy as np
from jaxtyping import Float32, Float64, Int

from sim.training.phrases import (
    PLACE_FRAMES,
    ROOM_ACTIVITIES,
    ROOM_NAMES,
    ROOM_THINGS,
    TEMPLATES,
    THING_FRAMES,
    framed,
)

_SHRINKAGE = 0.3
"""Of the variance within rooms towards a sphere, in units of its mean."""
_TABLES = ((ROOM_NAMES, TEMPLATES, 0.6), (ROOM_ACTIVITIES, PLACE_FRAMES, 0.2), (ROOM_THINGS, THING_FRAMES, 0.2))
"""What is said of rooms, how, and its share."""


@dataclass(frozen=True, eq=False)
class LabelledCaptions:
    """Captions that tell a room; weights sum to one and are equal for all rooms."""

    texts: tuple[str, ...]
    rooms: Int[np.ndarray, "n"]
    weights: Float64[np.ndarray, "n"]


@dataclass(frozen=True, eq=False)
class TargetMap:
    """x -> unit((x - mean) @ matrix)."""

    mean: Float32[np.ndarray, "d"]
    matrix: Float32[np.ndarray, "d e"]

    def __call__(self, embeddings: Float32[np.ndarray, "n d"]) -> Float32[np.ndarray, "n e"]:
        """Targets of the teacher's embeddings, unit norm."""
        return _units((embeddings - self.mean) @ self.matrix)


def labelled_captions() -> LabelledCaptions:
    """Every trained name, activity and thing of every room label in every trained frame; rooms number as in `ROOM_NAMES`."""
    texts, rooms, weights = [], [], []
    for table, frames, share in _TABLES:
        for room, label in enumerate(ROOM_NAMES):
            found = tuple(framed(frames, table[label]))
            texts.append(found)
            rooms.append(np.full(len(found), room))
            weights.append(np.full(len(found), share / len(ROOM_NAMES) / len(found)))
    return LabelledCaptions(tuple(chain.from_iterable(texts)), np.concatenate(rooms), np.concatenate(weights))


def fit_target_map(
    embeddings: Float32[np.ndarray, "n d"],
    captions: LabelledCaptions,
    everything: Float32[np.ndarray, "m d"],
    dimensions: int,
) -> TargetMap:
    """Whiten within rooms on the captions' `embeddings`; keep the directions in which `everything` varies most."""
    weighted = embeddings * captions.weights[:, None]
    centres = np.zeros((int(captions.rooms.max()) + 1, embeddings.shape[1]))
    np.add.at(centres, captions.rooms, weighted)
    centres *= len(centres)  # every room weighs the same
    inner = embeddings - centres[captions.rooms]
    scatter = (inner * captions.weights[:, None]).T @ inner
    scatter += _SHRINKAGE * np.trace(scatter) / len(scatter) * np.eye(len(scatter))
    values, vectors = np.linalg.eigh(scatter)
    whiten = (vectors * np.sqrt(values[0] / values)) @ vectors.T
    mean = centres.mean(axis=0)
    seen = _units((everything - mean) @ whiten)
    _, directions = np.linalg.eigh(seen.T @ seen / len(seen))
    kept = directions[:, ::-1][:, :dimensions]
    return TargetMap(mean.astype(np.float32), (whiten @ kept).astype(np.float32))


def _units(rows: np.ndarray) -> Float32[np.ndarray, "n d"]:
    return np.asarray(rows / np.linalg.norm(rows, axis=-1, keepdims=True), np.float32)
