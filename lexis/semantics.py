"""Labels, rooms and floors as a function of the current graph.

All three are recomputed from scratch each time instead of being updated, so that they always agree with the current poses.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.config import Config
from lexis.room_labels import Labels, label_keyframes, similarities
from lexis.room_segmentation import segment
from lexis.types import Keyframe, Poses, RoomInstance


@runtime_checkable
class Labeller(Protocol):
    """A function that gives the labels of keyframes, for example the true labels in a test.

    Its labels take the place of those that LEXIS finds from the images and refines.
    """

    def __call__(self, keyframes: Sequence[Keyframe], /) -> Labels:
        """Return the label of every keyframe, as an index into the room names."""
        ...


@dataclass(frozen=True, eq=False)
class Semantics:
    """Labels, rooms and floors of all keyframes. Arrays are indexed by keyframe id, as in `LexisMap`."""

    similarities: Float64[np.ndarray, "n rooms"]
    baseline_labels: Int[np.ndarray, "n"]
    labels: Int[np.ndarray, "n"]
    floors: Int[np.ndarray, "n"]
    rooms: tuple[RoomInstance, ...]


def derive(
    embeddings: Float32[np.ndarray, "n d"],
    T_W_B: Poses,
    text: Float32[np.ndarray, "rooms d"],
    room_names: tuple[str, ...],
    config: Config,
    given: Labels | None = None,
) -> Semantics:
    """Label, refine and cluster all keyframes at their current poses (paper, Sec. III-B and III-C).

    Args:
        embeddings: CLIP embedding of every keyframe (f_CLIP in the paper), unit norm.
        T_W_B: current poses.
        text: text embedding of every room name (f_TEXT in the paper), unit norm.
        room_names: the vocabulary.
        config: all settings, of which only those of labels and segmentation are used.
        given: labels to cluster in place of the refined labels; None: the refined labels.
    """
    positions = T_W_B[:, :3, 3]
    cosines = similarities(embeddings, text)
    labels = label_keyframes(cosines, positions, room_names, config.labels)
    refined = labels.refined if given is None else given
    segmentation = segment(refined, positions, room_names, config.segmentation)
    return Semantics(cosines, labels.baseline, refined, segmentation.floors, segmentation.rooms)
