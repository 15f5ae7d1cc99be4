"""Labels, rooms and floors as a function of the current graph.

They are recomputed from scratch each time instead of being updated, so that they always agree with the current poses.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.config import Config
from lexis.room_labels import label_keyframes, similarities
from lexis.room_segmentation import segment
from lexis.types import Poses, RoomInstance


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
) -> Semantics:
    """Label, refine and cluster all keyframes at their current poses (paper, Sec. III-B and III-C).

    Args:
        embeddings: f_CLIP of every keyframe, unit norm.
        T_W_B: current poses.
        text: f_TEXT of every room name, unit norm.
        room_names: the vocabulary.
        config: its settings of labels and segmentation are used.
    """
    positions = T_W_B[:, :3, 3]
    cosines = similarities(embeddings, text)
    labels = label_keyframes(cosines, positions, room_names, config.labels)
    segmentation = segment(labels.refined, positions, room_names, config.segmentation)
    return Semantics(cosines, labels.baseline, labels.refined, segmentation.floors, segmentation.rooms)
