"""The keyframes at which a path into a room may end, because a robot that stands there is surely inside the room.

A path has to end in the right room, but need not lead to its middle. The labels alone are not reliable enough for a choice
among all keyframes of a room: the keyframe nearest to the start is mostly one in front of the room, whose label is wrong. A
robot is therefore surely inside the room at a keyframe to which one of three cases applies:

1. At a distance of at least `INSIDE_M` from keyframes with other labels, the images have to be very sure of the label: its
   probability (`LexisMap.probabilities`) is at least `VERY_SURE`. The evidence (`lexis.planning.evidence`) also has to be at
   least the share `CLEAR` of the evidence at the innermost keyframe of any room with the label.
2. At a distance of at least `NEAR_M` from keyframes with other labels, a probability of `SURE` is enough. The evidence has
   to be as large as in case 1.
3. Behind a doorway or another narrow passage (`lexis.sight.passages`), the boundary of the room is known exactly: at least
   one keyframe with another label within `NEAR_M`, and all of those within `DIVIDED_M`, are beyond passages that are at
   least `BEHIND_DOORWAY_M` away. A probability of `SURE` is enough, and the evidence does not count, because half of the
   images still show the other room.

Nowhere within `IN_DOORWAY_M` of a passage is a robot surely inside, because in a doorway, it is in neither room. The methods
of the paper state a probability of 1 for all labels, and LEXIS for those of stairs; then only the first case applies.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int
from scipy.spatial import cKDTree

from lexis.maths.ties import rounded
from lexis.planning.evidence import evidence_at
from lexis.planning.path_ends import not_retired
from lexis.sight.crossings import distances_from_crossed, distances_from_nearest
from lexis.sight.passages import Passages
from lexis.types import LexisMap, RoomInstance

INSIDE_M, NEAR_M = 0.9, 1.5
"""Distances from the nearest keyframe with another label [m]. Without a doorway between them, a robot is inside its room
only from `INSIDE_M` on: labels are uncertain at the boundary, and a robot whose estimate has drifted stops up to 0.4 m in
front of the keyframe. Between `INSIDE_M` and `NEAR_M`, its images have to be very sure."""
VERY_SURE, SURE = 0.995, 0.96
"""Least probabilities of the room's label. Where a path can end first, in front of an open boundary, some images are wrong
and still quite sure. With an encoder that is never so sure, paths end at the innermost keyframe."""
CLEAR = 0.45
"""Least evidence at a keyframe, as a share of the largest evidence of rooms of its label. Just behind an open boundary,
about half of the images still show the other room, and the share is lower."""
DIVIDED_M, BEHIND_DOORWAY_M = 1.1, 0.5
"""Behind a doorway, all keyframes with other labels within `DIVIDED_M` are beyond doorways, and the robot is at least
`BEHIND_DOORWAY_M` away from these doorways [m]."""
IN_DOORWAY_M = 0.2
"""A keyframe within this distance of a narrow passage stands in it [m]: half the thickness of a wall, and the uncertainty of
where the passage is."""


def surely_inside(map: LexisMap, room: RoomInstance, most_evidence: float, doorways: Passages) -> Int[np.ndarray, "k"]:
    """Return the ids of the keyframes of a room at which a robot is surely inside the room, ascending; there may be none.

    Keyframes that have retired are left out (`lexis.planning.path_ends.not_retired`).

    Args:
        map: the map.
        room: the room.
        most_evidence: the largest evidence at the innermost keyframe of any room with the label.
        doorways: the narrow passages of the map.
    """
    own, label = _outside_doorways(map, not_retired(map, room), doorways), map.room_names.index(room.label)
    other, probability = _distances_from_others(map, own, label, doorways), map.probabilities[own, label]
    sure, very_sure = rounded(probability) >= SURE, rounded(probability) >= VERY_SURE
    # A probability of exactly 1 says nothing about the images. It is compared without rounding, because the images of one
    # keyframe in five justify a probability above 1 - 1e-6.
    sure &= probability < 1.0
    behind = sure & (other.divided < NEAR_M) & (other.undivided >= DIVIDED_M)
    far = (other.nearest >= INSIDE_M) & very_sure | (other.nearest >= NEAR_M) & sure
    own, behind = own[far | behind], behind[far | behind]
    return np.asarray(own[behind | (evidence_at(map, room.label, own) >= CLEAR * most_evidence)]) if len(own) else own


def _outside_doorways(map: LexisMap, keyframes: Int[np.ndarray, "k"], doorways: Passages) -> Int[np.ndarray, "outside"]:
    """Return the keyframes that do not stand in a doorway."""
    distances = rounded(distances_from_nearest(doorways, map.floors[keyframes], map.T_W_B[keyframes, :3, 3]))
    return keyframes[distances >= IN_DOORWAY_M]


class _OtherLabels(NamedTuple):
    """Distances of keyframes from the nearest keyframe with another label [m]; infinite if none is within `NEAR_M`."""

    divided: Float64[np.ndarray, "k"]
    """Distance from the nearest one beyond a doorway, if the keyframe is at least `BEHIND_DOORWAY_M` from the doorway."""
    undivided: Float64[np.ndarray, "k"]
    """Distance from the nearest one that no such doorway divides from the keyframe."""

    @property
    def nearest(self) -> Float64[np.ndarray, "k"]:
        """Distance from the nearest keyframe with another label, on this or the other side of a doorway."""
        return np.asarray(np.minimum(self.divided, self.undivided))


def _distances_from_others(map: LexisMap, keyframes: Int[np.ndarray, "k"], label: int, doorways: Passages) -> _OtherLabels:
    """Return the distances of the keyframes from those with another label than `label`."""
    positions, others = map.T_W_B[:, :3, 3], np.flatnonzero(map.labels != label)
    own, other = (cKDTree(positions[ids]) for ids in (keyframes, others))
    near = own.sparse_distance_matrix(other, NEAR_M, output_type="ndarray")
    metres = rounded(near["v"])
    near, metres = near[metres < NEAR_M], metres[metres < NEAR_M]
    pairs = np.stack([keyframes[near["i"]], others[near["j"]]], axis=1)
    beyond = rounded(distances_from_crossed(doorways, map.floors, positions, pairs))
    divided = np.isfinite(beyond) & (beyond >= BEHIND_DOORWAY_M)
    least = np.full((2, len(keyframes)), np.inf)
    for distances, counted in zip(least, (divided, ~divided), strict=True):
        np.minimum.at(distances, near["i"][counted], metres[counted])
    return _OtherLabels(*least)
