"""Room labels of keyframes: image against prompts, votes of neighbours, stairs by height (paper, Sec. III-B).

As in the paper, one pass of votes is run every K new keyframes (and when the graph has been optimised). Unlike the paper's
it starts from the images' labels each time, not from those of the pass before: labels are a function of the graph as it
now stands, and no mistake outlives its cause.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float64, Int

from lexis.config import LabelConfig
from lexis.maths.ties import nearest_others, settled
from lexis.stairs import on_stairs

Positions = Float64[np.ndarray, "n 3"]
Labels = Int[np.ndarray, "n"]
Similarities = Float64[np.ndarray, "n rooms"]


@dataclass(frozen=True, eq=False)
class RoomLabels:
    """One index into the room names for every keyframe."""

    baseline: Labels
    """The most similar prompt."""
    refined: Labels
    """After the votes of neighbours, and stairs by height."""


def similarities(embeddings: Float[np.ndarray, "n d"], text: Float[np.ndarray, "rooms d"]) -> Similarities:
    """Cosine similarity S_c of every image encoding with every text encoding (Eq. 1), in double precision."""
    images, prompts = embeddings.astype(np.float64), text.astype(np.float64)
    norms = np.linalg.norm(images, axis=1)[:, None] * np.linalg.norm(prompts, axis=1)
    return np.asarray(images @ prompts.T / norms)


def image_label(embedding: Float[np.ndarray, "d"], text: Float[np.ndarray, "rooms d"]) -> int:
    """Index of the prompt that one image resembles most: its label before refinement."""
    return int(settled(similarities(embedding[None], text)).argmax())


def label_keyframes(
    similarities: Similarities, positions: Positions, room_names: tuple[str, ...], config: LabelConfig
) -> RoomLabels:
    """Label all keyframes, as a function of their images and where they are now.

    Where the vocabulary names the stairs, climbing decides on them alone: a keyframe on a climb is on stairs whatever it
    sees, as in the paper; and, beyond the paper, one that only looks at stairs takes its next best prompt. Keyframes on
    stairs neither vote nor are voted on.

    Args:
        similarities: of every keyframe with every room prompt, in the order of the keyframes.
        positions: of the keyframes in W, consecutive ones neighbours on the path [m].
        room_names: the vocabulary.
        config: whether to refine, C, and what counts as a climb.
    """
    similarities = settled(similarities)
    baseline = similarities.argmax(axis=1)
    if not config.refine:
        return RoomLabels(baseline, baseline)
    if config.stairs_name not in room_names or len(room_names) == 1:
        return RoomLabels(baseline, propagate(baseline, similarities, positions, config.neighbours))
    stairs = room_names.index(config.stairs_name)
    level = ~on_stairs(positions, config)
    rooms_only = similarities.copy()
    rooms_only[:, stairs] = -np.inf
    refined = np.full(len(positions), stairs)
    images_say = rooms_only[level].argmax(axis=1)
    refined[level] = propagate(images_say, rooms_only[level], positions[level], config.neighbours)
    return RoomLabels(baseline, refined)


def propagate(labels: Labels, similarities: Similarities, positions: Positions, neighbours: int) -> Labels:
    """One forward pass of label propagation: every node takes the most common label of its C nearest neighbours.

    All nodes vote with the labels they had before the pass, so their order does not matter. Of equally common labels, of
    which the paper says nothing, a node keeps its own; otherwise it takes the one that its neighbours' images resemble most
    in sum.

    Args:
        labels: before the pass.
        similarities: of every node with every room prompt.
        positions: in W [m].
        neighbours: C; fewer vote where there are no more nodes.
    """
    if len(labels) < 2:
        return labels.copy()
    nearest = nearest_others(positions, neighbours)
    n, rooms = similarities.shape
    ballots = np.arange(n)[:, None] * rooms + labels[nearest]
    votes = np.bincount(ballots.ravel(), minlength=n * rooms).reshape(n, rooms)
    most_common = votes == votes.max(axis=1, keepdims=True)
    resemblance = np.where(most_common, settled(similarities[nearest].sum(axis=1)), -np.inf)
    return np.where(most_common[np.arange(n), labels], labels, resemblance.argmax(axis=1))
