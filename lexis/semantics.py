"""Labels, rooms and floors as a function of the current graph.

All three are recomputed from scratch each time instead of being updated, so that they always agree with the current poses.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol, assert_never, runtime_checkable

import numpy as np
from jaxtyping import Float64, Int
from scipy.sparse import csr_array

from lexis.config import Config, SightConfig
from lexis.room_labels import Labels, Probabilities, Refined, Refinement, certain, label_keyframes
from lexis.room_segmentation import Clustering, segment
from lexis.sight.cameras import largest
from lexis.sight.passages import lines_of_sight
from lexis.sight.pooled_labels import pool_labels
from lexis.sight.room_clusters import cluster_by_sight
from lexis.sight.visible_space import VisibleSpace, sight_of_cameras
from lexis.types import Camera, Keyframe, Poses, RoomInstance


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
    """Labels, rooms and floors of all keyframes, in fields of the names that they have in `LexisMap`."""

    similarities: Float64[np.ndarray, "n rooms"]
    baseline_labels: Int[np.ndarray, "n"]
    labels: Int[np.ndarray, "n"]
    probabilities: Probabilities
    floors: Int[np.ndarray, "n"]
    rooms: tuple[RoomInstance, ...]


@dataclass(frozen=True, eq=False)
class Views:
    """What the cameras of all keyframes saw, and the poses from which they saw it."""

    similarities: Float64[np.ndarray, "n cameras rooms"]
    """Cosine similarity of the images of every keyframe with every room name (paper, Eq. 1)."""
    spaces: Sequence[tuple[VisibleSpace, ...]]
    """The free space that each image of each keyframe shows. Only the methods by sight need it; for other methods, it may
    be empty."""
    T_W_B: Poses
    """Current poses."""
    camera: Camera
    """The camera, with the others of its rig."""
    sessions: Int[np.ndarray, "n"]
    """Session of every keyframe. Nobody walked from the end of one session to the beginning of the next."""

    @property
    def mean_similarities(self) -> Float64[np.ndarray, "n rooms"]:
        """Mean similarity of the images of every keyframe with every room name."""
        return np.asarray(self.similarities.mean(axis=1))


def derive_by_component(
    views: Views,
    components: Int[np.ndarray, "n"],
    room_names: tuple[str, ...],
    config: Config,
    given: Labels | None = None,
) -> Semantics:
    """Derive labels, rooms and floors for each component of the map by itself, because components share no frame.

    See `derive` for the other arguments. In each component, floors are counted from its lowest floor.
    """
    groups = [np.flatnonzero(components == name) for name in np.unique(components)]
    if len(groups) == 1:
        return derive(views, room_names, config, given)
    parts = [derive(_part(views, ids), room_names, config, None if given is None else given[ids]) for ids in groups]
    order = np.argsort(np.concatenate(groups))
    rooms = [
        replace(room, keyframes=tuple(ids[list(room.keyframes)].tolist()))
        for ids, part in zip(groups, parts, strict=True)
        for room in part.rooms
    ]
    return Semantics(
        views.mean_similarities,
        np.concatenate([part.baseline_labels for part in parts])[order],
        np.concatenate([part.labels for part in parts])[order],
        np.concatenate([part.probabilities for part in parts])[order],
        np.concatenate([part.floors for part in parts])[order],
        tuple(replace(room, id=i) for i, room in enumerate(rooms)),
    )


def _part(views: Views, ids: Int[np.ndarray, "k"]) -> Views:
    """Return the views of some keyframes."""
    spaces = [views.spaces[i] for i in ids.tolist()] if views.spaces else ()
    return Views(views.similarities[ids], spaces, views.T_W_B[ids], views.camera, views.sessions[ids])


def derive(
    views: Views,
    room_names: tuple[str, ...],
    config: Config,
    given: Labels | None = None,
) -> Semantics:
    """Label, refine and cluster all keyframes at their current poses (paper, Sec. III-B and III-C).

    The segmentation method "sight" may correct labels: borders move to doorways, small rooms are absorbed, and alike rooms
    merge. It corrects neither `given` labels nor those of the label method "image".

    Args:
        views: what the keyframes saw.
        room_names: the vocabulary.
        config: all settings, of which only those of labels, segmentation and sight are used.
        given: labels to cluster in place of the refined labels; None: the refined labels.
    """
    positions = views.T_W_B[:, :3, 3]
    seen_by = sight_of_cameras(views.spaces, views.T_W_B, views.camera, config.sight.near_m) if config.by_sight else []
    refine = _refinement(views, seen_by, config)
    labels = label_keyframes(views.mean_similarities, positions, room_names, config.labels, refine, views.sessions)
    refined, probabilities = labels.refined, labels.probabilities
    if given is not None:
        refined, probabilities = given, certain(given, len(room_names))
    correct = given is None and config.labels.method != "image"
    cluster = _clustering(views, seen_by, probabilities, config, correct)
    stairs_name = config.labels.stairs_name
    rooms = segment(refined, positions, room_names, config.segmentation, cluster, views.sessions, stairs_name)
    probabilities = _exchanged(probabilities, refined, rooms.labels)
    # The copy lets a caller change the labels of a map, and not also those before refinement.
    return Semantics(views.mean_similarities, labels.baseline, rooms.labels.copy(), probabilities, rooms.floors, rooms.rooms)


def _exchanged(probabilities: Probabilities, refined: Labels, corrected: Labels) -> Probabilities:
    """Let the refined and the corrected label of each keyframe exchange their probabilities.

    The corrected label thus counts as being as certain as the label of which it takes the place.
    """
    result, keyframes = probabilities.copy(), np.arange(len(refined))
    result[keyframes, corrected] = probabilities[keyframes, refined]
    result[keyframes, refined] = probabilities[keyframes, corrected]
    return result


def _refinement(views: Views, seen_by: Sequence[csr_array], config: Config) -> Refinement | None:
    """Return how labels are refined; None for the methods of `label_keyframes` itself."""
    match config.labels.method:
        case "sight":
            return partial(_refined_by_sight, views.similarities, seen_by, config.sight)
        case "vote" | "image":
            return None
    assert_never(config.labels.method)


def _clustering(
    views: Views, seen_by: Sequence[csr_array], probabilities: Probabilities, config: Config, correct: bool
) -> Clustering | None:
    """Return how keyframes are clustered into rooms; None for the method of `segment` itself."""
    match config.segmentation.method:
        case "sight":
            return partial(
                cluster_by_sight,
                sessions=views.sessions,
                probabilities=probabilities,
                seen_by=largest(seen_by),
                lines=lines_of_sight(views.spaces, views.T_W_B, views.camera),
                config=config.sight,
                correct=correct,
            )
        case "distance":
            return None
    assert_never(config.segmentation.method)


def _refined_by_sight(
    similarities: Float64[np.ndarray, "n cameras rooms"],
    seen_by: Sequence[csr_array],
    config: SightConfig,
    scores: Float64[np.ndarray, "k rooms"],
    keyframes: Int[np.ndarray, "k"],
) -> Refined:
    """Label some keyframes by sight. Room names that `scores` rules out are not considered."""
    allowed = np.where(np.isneginf(scores)[:, None], -np.inf, similarities[keyframes])
    return pool_labels(allowed, [seen[keyframes][:, keyframes] for seen in seen_by], config)
