"""The training targets of the text tower: the teacher's embeddings after a linear map that separates room labels better.

The map is fitted in two steps:

1. Whiten the variation among captions of one room (sentence frames, style, choice of things), as in linear discriminant
   analysis. This emphasises the differences between rooms. The covariance is shrunk, so that other meaning is preserved.
2. Keep only the directions in which all texts vary most, to reduce the dimension to the text tower's dimension.

Step 1 uses trained captions only.
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
"""Shrinkage of the covariance within rooms: a multiple of the identity is added, in units of the mean variance."""
_TABLES = ((ROOM_NAMES, TEMPLATES, 0.6), (ROOM_ACTIVITIES, PLACE_FRAMES, 0.2), (ROOM_THINGS, THING_FRAMES, 0.2))
"""Tables of phrases about rooms, each with its sentence frames and its share in the weights of the captions."""


@dataclass(frozen=True, eq=False)
class LabelledCaptions:
    """Captions with the room that each describes. Their weights sum to 1, and every room has the same total weight."""

    texts: tuple[str, ...]
    rooms: Int[np.ndarray, "n"]
    weights: Float64[np.ndarray, "n"]


@dataclass(frozen=True, eq=False)
class TargetMap:
    """The map x -> unit((x - mean) @ matrix) of embeddings, where unit(...) scales to unit norm."""

    mean: Float32[np.ndarray, "d"]
    matrix: Float32[np.ndarray, "d e"]

    def __call__(self, embeddings: Float32[np.ndarray, "n d"]) -> Float32[np.ndarray, "n e"]:
        """Convert the teacher's embeddings to targets of the text tower, of unit norm."""
        return _units((embeddings - self.mean) @ self.matrix)


def labelled_captions() -> LabelledCaptions:
    """Return each trained name, activity and thing of each room in each trained sentence frame (template).

    Rooms are numbered in the order of `ROOM_NAMES`.
    """
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
    """Fit the linear map from the teacher's embeddings to the targets of the text tower.

    It whitens the variation among captions of one room, then keeps the directions in which all texts vary most.

    Args:
        embeddings: the teacher's embeddings of `captions`.
        captions: captions with their rooms and weights.
        everything: the teacher's embeddings of all training texts.
        dimensions: number of directions to keep, which is the size of a target.
    """
    weighted = embeddings * captions.weights[:, None]
    centres = np.zeros((int(captions.rooms.max()) + 1, embeddings.shape[1]))
    np.add.at(centres, captions.rooms, weighted)
    centres *= len(centres)  # the weights of a room sum to 1 / rooms, so this turns sums into means
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
