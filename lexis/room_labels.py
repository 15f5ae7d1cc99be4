"""Room labels of keyframes (paper, Sec. III-B).

1. Give every keyframe the room name whose text embedding its image resembles most.
2. Label keyframes on stairs by their height change, because the camera may not see the stairs. Keyframes in a moving lift
   get the same label, because they are on no floor either.
3. Replace the label of every other keyframe by the most common label among its nearest neighbours, because single images are
   ambiguous near doors and in front of bare walls.

All keyframes are labelled when a map is made. If loops are sought by room, they are also labelled, as in the paper, after a
fixed number of new keyframes, K, and in addition after every optimisation. Unlike in the paper, each pass of label
propagation (step 3) starts from the labels of the images and not from the labels of the previous pass. Labels are thus a
function of the current graph, and a wrong label disappears as soon as its cause does.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float64, Int

from lexis.config import LabelConfig
from lexis.maths.ties import nearest_others, rounded
from lexis.room_names import same_name
from lexis.stairs import on_stairs
from lexis.types import Positions

Labels = Int[np.ndarray, "n"]
Similarities = Float64[np.ndarray, "n rooms"]
Probabilities = Float64[np.ndarray, "n rooms"]


class Refined(NamedTuple):
    """Refined labels of some keyframes."""

    labels: Labels
    probabilities: Probabilities
    """How probable every label is for each keyframe; see `LexisMap.probabilities`."""


Refinement = Callable[[Similarities, Int[np.ndarray, "n"]], Refined]
"""A function that refines the labels of some keyframes, given the similarities of their images and their ids."""


@dataclass(frozen=True, eq=False)
class RoomLabels:
    """Room labels of all keyframes, as indices into the room names."""

    baseline: Labels
    """Labels before refinement: for each keyframe, the room name whose prompt is most similar to its images."""
    refined: Labels
    """Labels after refinement and detection of stairs by height; with the method "image", equal to `baseline`."""
    probabilities: Probabilities
    """How probable every label is for each keyframe; see `LexisMap.probabilities`."""


def similarities(
    embeddings: Float[np.ndarray, "*n d"], text: Float[np.ndarray, "rooms d"]
) -> Float64[np.ndarray, "*n rooms"]:
    """Return the cosine similarity S_c of each image embedding with every text embedding (Eq. 1), in double precision."""
    images, prompts = embeddings.astype(np.float64), text.astype(np.float64)
    norms = np.linalg.norm(images, axis=-1)[..., None] * np.linalg.norm(prompts, axis=1)
    return np.asarray(images @ prompts.T / norms)


def most_similar(similarities: Float64[np.ndarray, "rooms"]) -> int:
    """Return the index of the room name most similar to an image, which is the keyframe's label before refinement."""
    return int(rounded(similarities).argmax())


def label_keyframes(
    similarities: Similarities,
    positions: Positions,
    room_names: tuple[str, ...],
    config: LabelConfig,
    refine: Refinement | None = None,
    sessions: Int[np.ndarray, "n"] | None = None,
) -> RoomLabels:
    """Label all keyframes from their images and their current positions.

    If the stairs are among the room names, height change alone decides which keyframes get that label. As in the paper, a
    keyframe on a climb is labelled as stairs whatever its image shows. Beyond the paper, a keyframe that is not on a climb
    gets its best other label, even if its image shows stairs. Keyframes on stairs take no part in label propagation.

    Args:
        similarities: cosine similarities, rows in the order of the keyframes.
        positions: positions of the keyframes in W, in the order of the path [m].
        room_names: the vocabulary.
        config: the method, the number of neighbours C, and the thresholds of a climb.
        refine: how the labels of keyframes that are not on stairs are refined; None: by the vote of the paper.
        sessions: the sessions of the keyframes; None: they are all of one.
    """
    similarities = rounded(similarities)
    baseline = similarities.argmax(axis=1)
    if config.method == "image":
        return RoomLabels(baseline, baseline, certain(baseline, len(room_names)))

    def vote(scores: Similarities, keyframes: Int[np.ndarray, "n"]) -> Refined:
        labels = propagate(scores.argmax(axis=1), scores, positions[keyframes], config.neighbours)
        return Refined(labels, certain(labels, len(room_names)))

    refine = refine or vote
    is_stairs = np.array([same_name(name, config.stairs_name) for name in room_names])
    if not is_stairs.any() or len(room_names) == 1:
        return RoomLabels(baseline, *refine(similarities, np.arange(len(positions))))
    stairs = int(is_stairs.argmax())
    level = np.flatnonzero(~on_stairs(positions, config, sessions))
    rooms_only = similarities.copy()
    rooms_only[:, stairs] = -np.inf
    refined = np.full(len(positions), stairs)
    probabilities = certain(refined, len(room_names))
    refined[level], probabilities[level] = refine(rooms_only[level], level)
    return RoomLabels(baseline, refined, probabilities)


def certain(labels: Labels, rooms: int) -> Probabilities:
    """Return probabilities of 1 for the given labels, where a method does not say how sure it is."""
    return np.asarray(np.eye(rooms)[labels])


def propagate(labels: Labels, similarities: Similarities, positions: Positions, neighbours: int) -> Labels:
    """Run one pass of label propagation: every node (keyframe) takes the most common label of its C nearest neighbours.

    All nodes vote with their labels from before the pass, so that their order does not matter. The paper does not say how
    to break ties. Here, a node keeps its own label if that is among the most common ones; otherwise it takes the tied label
    with the largest sum of similarities over its neighbours' images.

    Args:
        labels: labels before the pass.
        similarities: cosine similarities of the nodes with the room prompts.
        positions: positions of the nodes in W [m].
        neighbours: C; if there are fewer other nodes, all of them vote.
    """
    if len(labels) < 2:
        return labels.copy()
    nearest = nearest_others(positions, neighbours)
    n, rooms = similarities.shape
    ballots = np.arange(n)[:, None] * rooms + labels[nearest]
    votes = np.bincount(ballots.ravel(), minlength=n * rooms).reshape(n, rooms)
    most_common = votes == votes.max(axis=1, keepdims=True)
    resemblance = np.where(most_common, rounded(similarities[nearest].sum(axis=1)), -np.inf)
    return np.where(most_common[np.arange(n), labels], labels, resemblance.argmax(axis=1))
