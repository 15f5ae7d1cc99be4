"""Place recognition: loop candidates for a new keyframe, from the room that its image shows (paper, Sec. III-D)."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64

from lexis.config import PlaceRecognitionConfig
from lexis.maths.ties import reaches, rounded
from lexis.pose_graph import PoseGraph
from lexis.types import Keyframe, RoomInstance


@runtime_checkable
class PlaceRecogniser(Protocol):
    """A function that proposes loop candidates for a new keyframe: `propose`, or another function in its place."""

    def __call__(
        self, query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig, /
    ) -> tuple[int, ...]:
        """Return the ids of the candidates; see `propose` for the arguments and the result."""
        ...


def propose(
    query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig
) -> tuple[int, ...]:
    """Propose earlier keyframes as loop candidates for a new keyframe, the query; return their ids, most similar first.

    1. Take the rooms that have the query's label and at least one keyframe old enough to close a loop with. Rooms with
       recent keyframes only are left out: when the robot re-enters a room, its new keyframes may at first form a cluster of
       their own, which would be closer than the old cluster of the room.
    2. Choose the room whose mean position is closest to the query at the current pose estimate.
    3. Rank the old enough keyframes of that room by the cosine similarity of their embeddings with the query's.

    The result is empty if no room has the label and an old enough keyframe.

    Args:
        query: the new keyframe, already in the graph.
        label: room name that the query's image resembles most.
        rooms: the current room instances.
        graph: the current poses and embeddings.
        config: how many keyframes to propose, and how old they must be.
    """
    old = old_enough(query.id, graph.stamps, graph.path_m, config)
    members = {room.id: [i for i in room.keyframes if old[i]] for room in rooms if room.label == label}
    eligible = [room for room in rooms if members.get(room.id)]
    if not eligible:
        return ()
    position = graph.T_W_B[query.id, :3, 3]
    distances = rounded(np.linalg.norm([room.mean - position for room in eligible], axis=1))
    closest = eligible[int(distances.argmin())]
    ids = np.array(members[closest.id])
    similarity = graph.embeddings[ids].astype(np.float64) @ query.embedding
    best = np.argsort(-rounded(similarity), kind="stable")[: config.candidates]
    return tuple(ids[best].tolist())


def old_enough(
    query: int, stamps: Float64[np.ndarray, "n"], path_m: Float64[np.ndarray, "n"], config: PlaceRecognitionConfig
) -> Bool[np.ndarray, "n"]:
    """Whether each keyframe is old enough to be a loop candidate for the keyframe `query`.

    It must lie at least `min_gap_s` of time and `min_gap_m` of odometry path before the query. More recent keyframes are not
    proposed, because odometry already constrains them well.

    Args:
        query: id of a keyframe.
        stamps: stamps of all keyframes [s].
        path_m: odometry path from the first keyframe to each keyframe [m].
        config: its `min_gap_s` and `min_gap_m` are used.
    """
    seconds, metres = stamps[query] - stamps, path_m[query] - path_m
    # Recorded stamps are rounded, and the decision on a gap at the limit must not depend on that.
    return np.asarray(reaches(seconds, config.min_gap_s) & reaches(metres, config.min_gap_m) & (seconds > 0))
