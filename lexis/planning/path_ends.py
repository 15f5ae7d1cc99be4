"""The keyframe from which a path leaves a room: with clear evidence of the room, and far from the room's boundary."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int
from scipy.spatial import cKDTree

from lexis.floors import NO_FLOOR
from lexis.graph.thinning import are_active
from lexis.maths.ties import rounded
from lexis.planning.evidence import EVIDENCE_REACH_M, evidence_at, shown_places
from lexis.types import LexisMap, RoomInstance

DOUBTFUL = 0.55
"""A room is doubtful if its evidence (see `path_end`) is not positive. It is also doubtful if its evidence is less than this
share of the largest evidence of any room with the same label, unless its label is certain."""
CERTAIN = 0.9
"""The label of a room is certain if its probability (`LexisMap.probability_of`) is at least this, but less than 1.
Whatever the images show, the methods of the paper state 1 for all labels, and LEXIS states it for stairs."""
WEAK = 0.4
"""A place counts as outside a room if its evidence is less than this share of the largest evidence in the room."""
MARGIN_M = 1.5
"""Sufficient distance between the end of a path and the boundary of the room [m]. A larger distance counts as no better."""


class PathEnd(NamedTuple):
    """The innermost keyframe of a room."""

    room: RoomInstance
    keyframe: int
    evidence: float
    """The evidence of the room at the keyframe; see `lexis.planning.evidence`."""


def path_end(map: LexisMap, room: RoomInstance) -> PathEnd:
    """Choose the innermost keyframe of a room: with clear evidence of the room, and far from the room's boundary.

    1. Take as candidates the room's own keyframes and the keyframes near the places that the room's images show. The latter
       are needed because a small room may only be recognised by keyframes in front of it.
    2. Compute the evidence at each candidate: how much more the images of its place resemble this room than any other.
    3. Choose the candidate with the largest product of evidence and distance from the room's boundary; of equal products,
       the first. If no candidate has positive evidence, choose the candidate with the most evidence.
    """
    candidates = _candidates(map, room)
    evidence = evidence_at(map, room.label, candidates)
    margins = _margins(map, room, candidates, WEAK * float(evidence.max()))
    best = int(np.argmax(rounded(np.where(evidence > 0.0, evidence * margins, evidence))))
    return PathEnd(room, int(candidates[best]), float(evidence[best]))


def clear_ends(map: LexisMap, ends: Sequence[PathEnd]) -> list[PathEnd]:
    """Return the path ends of rooms that are not doubtful (`DOUBTFUL`); all of them if every room is.

    The rooms have one label. Most doubtful rooms are a few mislabelled keyframes in a room of another label. If the label of
    a room is certain (`CERTAIN`), little evidence is no doubt: a corridor may look less like its name than that of another
    storey.
    """
    clear = DOUBTFUL * max(end.evidence for end in ends)
    certain = [CERTAIN <= map.probability_of(end.room) < 1.0 for end in ends]
    return [
        end for end, sure in zip(ends, certain, strict=True) if end.evidence > 0.0 and (end.evidence >= clear or sure)
    ] or list(ends)


def _candidates(map: LexisMap, room: RoomInstance) -> Int[np.ndarray, "k"]:
    """Return the ids of a room's keyframes, and of the keyframes near the places that the room's images show; ascending.

    Keyframes of other rooms with the same label are left out, because evidence cannot tell rooms of one label apart. So are
    retired keyframes (`not_retired`).
    """
    own, active = not_retired(map, room), np.flatnonzero(are_active(map.keyframes))
    near = cKDTree(map.T_W_B[active, :3, 3]).query_ball_point(shown_places(map)[own], EVIDENCE_REACH_M)
    twins = [k for other in map.rooms if other.label == room.label and other.id != room.id for k in other.keyframes]
    return np.setdiff1d(np.concatenate([own, active[np.concatenate(near).astype(int)]]), twins)


def not_retired(map: LexisMap, room: RoomInstance) -> Int[np.ndarray, "k"]:
    """Return the ids of the keyframes of a room that have not retired; of all its keyframes if all of them have retired.

    Retired keyframes lie where others lie. Their number grows with the time that the robot walks, and a path need not end at
    them.
    """
    own = np.array(room.keyframes)
    active = are_active([map.keyframes[id] for id in room.keyframes])
    return own[active] if active.any() else own


def _margins(map: LexisMap, room: RoomInstance, keyframes: Int[np.ndarray, "k"], weak: float) -> Float64[np.ndarray, "k"]:
    """Return the distances of keyframes from the boundary of the room, at most `MARGIN_M` [m].

    The boundary is the nearest keyframe with evidence below `weak` or, for a room that is not stairs, the nearest keyframe
    on stairs. Keyframes on stairs count whatever their evidence, because their images show the rooms at either end.
    """
    positions = map.T_W_B[:, :3, 3]
    near = cKDTree(positions).query_ball_point(positions[keyframes], MARGIN_M)
    around = np.unique(np.concatenate(near).astype(int))
    outside = evidence_at(map, room.label, around) < weak
    if room.floor is not None:
        outside |= map.floors[around] == NO_FLOOR
    distances = cKDTree(positions[around[outside]]).query(positions[keyframes], distance_upper_bound=MARGIN_M)[0]
    return rounded(np.minimum(distances, MARGIN_M))
