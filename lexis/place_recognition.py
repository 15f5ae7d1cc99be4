"""Place recognition: the choice of loop candidates, which are earlier keyframes that may show the place of a new keyframe.

The paper (Sec. III-D) searches the room that the image shows, by its label (`in_labelled_room`). With this method, one wrong
label hides the right room, and keyframes are proposed even where the robot has never been before. By default, keyframes are
therefore proposed by a calibrated probability of a revisit, from the similarity of the images and the estimated poses
(`by_probability`).

With a rig of several cameras, two keyframes are as similar as their two most similar images, and a revisit is as probable as
its most probable pair of cameras. A rear camera thus recognises what a front camera saw when the robot walked the other way.
"""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Float64, Int
from scipy.special import logit

from lexis.config import PlaceRecognitionConfig
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.rig import camera_angles
from lexis.maths.se3 import between
from lexis.maths.ties import reaches, rounded
from lexis.types import Keyframe, Poses, RoomInstance

_MUCH_LESS = -4.6
"""A keyframe is not considered at all if its log odds of a revisit are certainly below those of `least_probability` plus
this value. The value stands for a hundredth of the odds."""
_SINGLE_PRECISION = 1e-4
"""Upper bound for the rounding error of a cosine similarity in single precision."""

Ids = Int[np.ndarray, "k"]
Figures = Float64[np.ndarray, "..."]
"""One figure, such as a similarity or a distance [m], for each of some keyframes or pairs of images."""


@runtime_checkable
class PlaceRecogniser(Protocol):
    """A function that proposes loop candidates for a new keyframe: `propose`, or a function that takes its place."""

    def __call__(
        self, query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig, /
    ) -> tuple[int, ...]:
        """Return the ids of the candidates; see `propose` for the arguments and the result."""
        ...


def propose(
    query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig
) -> tuple[int, ...]:
    """Propose earlier keyframes as loop candidates for a new keyframe, the query; return their ids, best first.

    Keyframes that have retired from the graph are not proposed, because others show their places.

    Args:
        query: the new keyframe, already in the graph.
        label: room name that the query's image resembles most.
        rooms: the current room instances.
        graph: the current poses and embeddings.
        config: the method, how many keyframes to propose, and how old they must be.
    """
    old = old_keyframes(graph, query, config)
    match config.method:
        case "probability":
            return by_probability(query, old, graph, config)
        case "room":
            return in_labelled_room(query, label, rooms, old, graph, config)
        case "similarity":
            return most_similar_keyframes(query, old, graph, config.candidates)


def old_keyframes(graph: PoseGraph, query: Keyframe, config: PlaceRecognitionConfig) -> Ids:
    """Return the ids of the active keyframes that are old enough and in the query's component, ascending.

    They are the keyframes that may be proposed for a query of the graph's last session; see `old_enough`. All keyframes of
    earlier sessions are old enough.
    """
    earlier = int(np.searchsorted(graph.active, graph.session_start))
    own = graph.active[earlier:]
    old = old_enough(int(np.searchsorted(own, query.id)), graph.stamps[own], graph.path_m[own], config)
    ids = graph.active[: earlier + int(old.sum())]  # the first keyframes are the old enough ones
    if not graph.is_split:
        return ids
    components = graph.components
    return np.asarray(ids[components[ids] == components[query.id]])


def by_probability(query: Keyframe, old: Ids, graph: PoseGraph, config: PlaceRecognitionConfig) -> tuple[int, ...]:
    """Propose those of the keyframes `old` that the query revisits most probably.

    If no keyframe has at least the probability `least_probability`, as at a place that is seen for the first time, the
    result is empty. Otherwise, less probable keyframes are proposed, too, up to the number of `candidates`, because two
    views from different places in a room may overlap enough for a loop. See `revisit_log_odds` for the probability.

    If far loops imply that the robot has been carried, the query may have several poses (`lexis.graph.far_loops`). The most
    probable one counts.
    """
    least = logit(config.least_probability)
    T_W_query = graph.far_loops.poses_of(query.id, graph.T_W_B)
    ids = old[_bound(query, old, T_W_query, graph, config) >= least + _MUCH_LESS]
    T_old_query = between(graph.T_W_B[ids, None], T_W_query)
    distances, angles = np.linalg.norm(T_old_query[..., :3, 3], axis=-1), camera_angles(T_old_query, graph.rotations)
    similarities = _cosines(query, graph.embeddings_of(ids).astype(np.float64))
    of_pairs = rounded(revisit_log_odds(similarities[:, None], distances[..., None, None], angles, config))
    odds = of_pairs.max(axis=(1, 2, 3))
    if not (odds >= least).any():
        return ()
    best = np.argsort(-odds, kind="stable")[: config.candidates]
    return tuple(ids[best].tolist())


def _bound(query: Keyframe, old: Ids, T_W_query: Poses, graph: PoseGraph, config: PlaceRecognitionConfig) -> Figures:
    """Return upper bounds for the log odds of a revisit of the keyframes `old`, which are cheap to compute.

    Most keyframes are too far away and too different. By the bounds, they are ruled out without computing their log odds in
    full. `T_W_query` are the poses that the query may have.
    """
    distances = np.linalg.norm(graph.T_W_B[old, None, :3, 3] - T_W_query[:, :3, 3], axis=2).min(axis=1)
    similarities = _cosines(query, graph.embeddings_of(old)).max(axis=(1, 2)) + np.float32(_SINGLE_PRECISION)
    return revisit_log_odds(similarities.astype(np.float64), distances, np.zeros(len(old)), config)


def revisit_log_odds(
    similarities: Figures, distances_m: Figures, angles_rad: Figures, config: PlaceRecognitionConfig
) -> Figures:
    """Return the log odds that two images show one place, which means that they were taken within 1 m and 0.5 rad.

    The log odds rise with the similarity of the images and fall with the squares of the estimated distance and angle. This
    fall is limited: a robot that is lost can be anywhere, so a very similar image far from the estimate counts too.
    `lexis-sim bench place-recognition --fit` fits the settings to runs of which the truth is known.

    Args:
        similarities: cosine similarities of the images.
        distances_m: estimated distances between the keyframes [m].
        angles_rad: estimated angles between the cameras that took the images [rad].
        config: the settings of the model.
    """
    misplaced = (distances_m / config.place_m) ** 2 + (angles_rad / config.place_rad) ** 2
    return config.log_odds + config.similarity_weight * similarities - np.minimum(misplaced, config.lost_log_odds)


def in_labelled_room(
    query: Keyframe,
    label: str,
    rooms: Sequence[RoomInstance],
    old: Ids,
    graph: PoseGraph,
    config: PlaceRecognitionConfig,
) -> tuple[int, ...]:
    """Propose the keyframes most similar to the query in the closest room that has the query's label, as in the paper.

    1. Take the rooms that have the query's label and at least one old enough keyframe. Rooms with recent keyframes only are
       left out: when the robot re-enters a room, its new keyframes may at first form a cluster of their own, which would be
       closer than the old cluster of the room.
    2. Choose the room whose mean position is closest to the query at the current pose estimate.
    3. Rank the old enough keyframes of that room by the cosine similarity of their embeddings with the query's.

    The keyframes `old` are those that are old enough. The result is empty if no room has the label and an old enough
    keyframe.
    """
    members = {room.id: np.intersect1d(room.keyframes, old).astype(int) for room in rooms if room.label == label}
    eligible = [room for room in rooms if len(members.get(room.id, ()))]
    if not eligible:
        return ()
    position = graph.T_W_B[query.id, :3, 3]
    distances = rounded(np.linalg.norm([room.mean - position for room in eligible], axis=1))
    closest = eligible[int(distances.argmin())]
    return most_similar_keyframes(query, members[closest.id], graph, config.candidates)


def most_similar_keyframes(query: Keyframe, ids: Ids, graph: PoseGraph, count: int) -> tuple[int, ...]:
    """Return up to `count` of the keyframes `ids`, those whose images are most similar to the query's, best first."""
    best = np.argsort(-rounded(_similarities(query, ids, graph)), kind="stable")[:count]
    return tuple(ids[best].tolist())


def _similarities(query: Keyframe, ids: Ids, graph: PoseGraph) -> Figures:
    """Return the cosine similarities of the query with other keyframes: those of the two most similar images."""
    return np.asarray(_cosines(query, graph.embeddings_of(ids).astype(np.float64)).max(axis=(1, 2)))


def _cosines(query: Keyframe, embeddings: Float[np.ndarray, "k cameras d"]) -> Float[np.ndarray, "k cameras cameras"]:
    """Return the cosine similarities of the images of k keyframes (rows) with the images of the query (columns)."""
    count, cameras, size = embeddings.shape
    flat = embeddings.reshape(count * cameras, size)
    return np.stack([flat @ own for own in query.embeddings], axis=1).reshape(count, cameras, cameras)


def old_enough(
    query: int, stamps: Float64[np.ndarray, "n"], path_m: Float64[np.ndarray, "n"], config: PlaceRecognitionConfig
) -> Bool[np.ndarray, "n"]:
    """Whether each keyframe is old enough to be a loop candidate for one of them; see `is_old_enough`.

    The result is True for the first keyframes up to some keyframe, and False for all later ones.

    Args:
        query: row, in `stamps` and `path_m`, of the keyframe for which candidates are searched.
        stamps: stamps of keyframes, in the order of the walk [s].
        path_m: odometry path from the first of these keyframes to each of them [m].
        config: its `min_gap_s` and `min_gap_m` are used.
    """
    return is_old_enough(stamps[query] - stamps, path_m[query] - path_m, config)


def is_old_enough(
    seconds: Float64[np.ndarray, "m"], metres: Float64[np.ndarray, "m"], config: PlaceRecognitionConfig
) -> Bool[np.ndarray, "m"]:
    """Whether keyframes that lie so much time [s] and odometry path [m] before a query are old enough to be candidates.

    A keyframe that is old enough lies at least `min_gap_s` of time and `min_gap_m` of odometry path before the query. More
    recent keyframes are not proposed, because odometry already constrains them well.
    """
    # Recorded stamps are rounded, and the decision on a gap at the limit must not depend on that.
    return np.asarray(reaches(seconds, config.min_gap_s) & reaches(metres, config.min_gap_m) & (seconds > 0))
