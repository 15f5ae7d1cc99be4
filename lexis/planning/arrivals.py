"""The keyframes at which a path into a room may end, because a robot that stands there is surely inside the room.

A path has to end in the right room, but need not lead to its middle. The labels alone are not reliable enough for a choice
among all keyframes of a room: the keyframe nearest to the start is mostly one in front of the room, whose label is wrong. A
keyframe is therefore surely inside its room if four conditions hold:

1. Keyframes with other labels are at least `INSIDE_M` away, because labels are uncertain at the boundary of a room, and
   because a robot whose estimate has drifted stops up to 0.4 m in front of the keyframe.
2. The images are sure of the label: its probability (`LexisMap.probabilities`) is at least `SURE`.
3. The evidence at the keyframe (`lexis.planning.evidence`) is at least the share `CLEAR` of the evidence at the innermost
   keyframe of any room with the label.
4. No doorway or other narrow passage (`lexis.sight.passages`) is within `IN_DOORWAY_M`. A robot that stands in a doorway is
   in neither room, and labels may be wrong on both sides of it.

At a doorway, the boundary is known exactly. A robot is therefore also surely inside behind a doorway: all keyframes with
other labels within `INSIDE_M` are on the other side of narrow passages, from which the keyframe is at least
`BEHIND_DOORWAY_M` away. The probability of the label then has to be `SURE_BEHIND_DOORWAY` only, and the evidence does not
count, because half of the images still show the other room.
"""

import numpy as np
from jaxtyping import Bool, Int
from scipy.spatial import cKDTree

from lexis.maths.ties import rounded
from lexis.planning.evidence import evidence_at
from lexis.sight.crossings import distances_from_crossed, distances_from_nearest
from lexis.sight.passages import Passages
from lexis.types import LexisMap, RoomInstance

INSIDE_M = 0.9
"""Least distance of a keyframe that is surely inside its room from the nearest keyframe with another label [m]."""
SURE = 0.995
"""Least probability of the room's label at a keyframe that is surely inside the room. It is high, because where a path can
end first, in front of an open boundary, some images are wrong and still quite sure. With an encoder that is never so sure,
paths end at the innermost keyframe."""
CLEAR = 0.45
"""Least evidence at a keyframe that is surely inside its room, as a share of the largest evidence of rooms of its label.
Just behind an open boundary, about half of the images still show the other room, and the share is lower."""
IN_DOORWAY_M = 0.2
"""A keyframe within this distance of a narrow passage stands in it [m]: half the thickness of a wall, and the uncertainty of
where the passage is."""
BEHIND_DOORWAY_M = 0.5
"""Least distance from a doorway of a keyframe that is surely inside its room behind this doorway [m]."""
SURE_BEHIND_DOORWAY = 0.95
"""The probability in place of `SURE` behind a doorway. It also has to be less than 1, which the methods of the paper state
for all labels."""


def surely_inside(map: LexisMap, room: RoomInstance, most_evidence: float, doorways: Passages) -> Int[np.ndarray, "k"]:
    """Return the ids of the keyframes of a room at which a robot is surely inside the room, ascending; there may be none.

    Args:
        map: the map.
        room: the room.
        most_evidence: the largest evidence at the innermost keyframe of any room with the label.
        doorways: the narrow passages of the map.
    """
    own, label = _outside_doorways(map, np.array(room.keyframes), doorways), map.room_names.index(room.label)
    deep, behind = _depth(map, own, label, doorways)
    probability = rounded(map.probabilities[own, label])
    behind &= probability < 1.0
    likely = (deep & (probability >= SURE)) | (behind & (probability >= SURE_BEHIND_DOORWAY))
    own, behind = own[likely], behind[likely]
    return np.asarray(own[behind | (evidence_at(map, room.label, own) >= CLEAR * most_evidence)]) if len(own) else own


def _outside_doorways(map: LexisMap, keyframes: Int[np.ndarray, "k"], doorways: Passages) -> Int[np.ndarray, "outside"]:
    """Return the keyframes that do not stand in a doorway."""
    distances = rounded(distances_from_nearest(doorways, map.floors[keyframes], map.T_W_B[keyframes, :3, 3]))
    return keyframes[distances >= IN_DOORWAY_M]


def _depth(
    map: LexisMap, keyframes: Int[np.ndarray, "k"], label: int, doorways: Passages
) -> tuple[Bool[np.ndarray, "k"], Bool[np.ndarray, "k"]]:
    """Return which keyframes are far from all keyframes with other labels, and which others are well behind a doorway."""
    positions, others = map.T_W_B[:, :3, 3], np.flatnonzero(map.labels != label)
    own, other = (cKDTree(positions[ids]) for ids in (keyframes, others))
    near = own.sparse_distance_matrix(other, INSIDE_M, output_type="ndarray")
    near = near[rounded(near["v"]) < INSIDE_M]
    pairs = np.stack([keyframes[near["i"]], others[near["j"]]], axis=1)
    beyond = rounded(distances_from_crossed(doorways, map.floors, positions, pairs))
    divided = np.isfinite(beyond) & (beyond >= BEHIND_DOORWAY_M)
    shallow, undivided = (np.isin(np.arange(len(keyframes)), ids) for ids in (near["i"], near["i"][~divided]))
    return ~shallow, shallow & ~undivided
