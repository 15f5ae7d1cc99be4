"""Loop candidates from the room that the query's image shows (paper, Sec. III-D)."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64

from lexis.config import PlaceRecognitionConfig
from lexis.maths.ties import reaches, settled
from lexis.pose_graph import PoseGraph
from lexis.types import Keyframe, RoomInstance


def propose(
    query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig
) -> tuple[int, ...]:
    """Ids of the keyframes to verify, best first; empty when no room of the label holds an old enough keyframe.

    Args:
        query: the new keyframe, already in the graph.
        label: the room that its image shows.
        rooms: the current room instances.
        graph: the current estimate and the embeddings.
        config: how many to propose, and how old they have to be.

    The closest room is sought by the graph's current estimate, which is the odometry since the last optimisation, and among
    rooms with an old enough keyframe: the room that the robot has just entered may for now be a cluster of its own, too
    recent to close a loop with, and would hide the older one behind it.
    """
    stamps = np.array([keyframe.stamp for keyframe in graph.keyframes])
    old = old_enough(query.id, stamps, graph.path_m, config)
    members = {room.id: [i for i in room.keyframes if old[i]] for room in rooms if room.label == label}
    eligible = [room for room in rooms if members.get(room.id)]
    if not eligible:
        return ()
    position = graph.T_W_B[query.id, :3, 3]
    distances = settled(np.linalg.norm([room.mean - position for room in eligible], axis=1))
    closest = eligible[int(distances.argmin())]
    ids = np.array(members[closest.id])
    similarity = graph.embeddings[ids].astype(np.float64) @ query.embedding
    best = np.argsort(-settled(similarity), kind="stable")[: config.candidates]
    return tuple(ids[best].tolist())


def old_enough(
    query: int, stamps: Float64[np.ndarray, "n"], path_m: Float64[np.ndarray, "n"], config: PlaceRecognitionConfig
) -> Bool[np.ndarray, "n"]:
    """Mark the keyframes that lie at least `min_gap_s` and `min_gap_m` of odometry path before the query.

    Only these may be proposed.

    Args:
        query: id of a keyframe.
        stamps: of all keyframes [s].
        path_m: odometry path from the first keyframe to each [m].
        config: the two gaps.
    """
    seconds, metres = stamps[query] - stamps, path_m[query] - path_m
    # Stamps of recordings are rounded, and a gap at the limit must not depend on how.
    return np.asarray(reaches(seconds, config.min_gap_s) & reaches(metres, config.min_gap_m) & (seconds > 0))
