"""The keyframes at which a path into a room may end, because a robot that stands there is surely inside the room.

A path has to end in the right room, but need not lead to its middle. The labels alone are not reliable enough for a choice
among all keyframes of a room: the keyframe nearest to the start is mostly one in front of the room, whose label is wrong. A
keyframe is therefore surely inside its room if three conditions hold:

1. Keyframes with other labels are at least `INSIDE_M` away, because labels are uncertain at the boundary of a room, and
   because a robot whose estimate has drifted stops up to 0.4 m in front of the keyframe.
2. The images are sure of the label: its probability (`LexisMap.probabilities`) is at least `SURE`.
3. The evidence at the keyframe (`lexis.planning.evidence`) is at least the share `CLEAR` of the evidence at the innermost
   keyframe of any room with the label.
"""

import numpy as np
from jaxtyping import Bool, Int
from scipy.spatial import cKDTree

from lexis.maths.ties import rounded
from lexis.planning.evidence import evidence_at
from lexis.types import LexisMap, RoomInstance

INSIDE_M = 0.9
"""Least distance of a keyframe that is surely inside its room from the nearest keyframe with another label [m]."""
SURE = 0.995
"""Least probability of the room's label at a keyframe that is surely inside the room. It is high, because where a path can
end first, in front of an open boundary, some images are wrong and still quite sure. With an encoder that is never so sure,
paths end at the innermost keyframe."""
CLEAR = 0.45
"""Least evidence at a keyframe that is surely inside its room, as a share of the largest evidence of rooms of its label.
Just behind a door or an open boundary, about half of the images still show the other room, and the share is lower."""


def surely_inside(map: LexisMap, room: RoomInstance, most_evidence: float) -> Int[np.ndarray, "k"]:
    """Return the ids of the keyframes of a room at which a robot is surely inside the room, ascending; there may be none.

    Args:
        map: the map.
        room: the room.
        most_evidence: the largest evidence at the innermost keyframe of any room with the label.
    """
    own, label = np.array(room.keyframes), map.room_names.index(room.label)
    own = own[_is_deep(map, own, label) & (rounded(map.probabilities[own, label]) >= SURE)]
    return np.asarray(own[evidence_at(map, room.label, own) >= CLEAR * most_evidence]) if len(own) else own


def _is_deep(map: LexisMap, keyframes: Int[np.ndarray, "k"], label: int) -> Bool[np.ndarray, "k"]:
    positions = map.T_W_B[:, :3, 3]
    distances = cKDTree(positions[map.labels != label]).query(positions[keyframes], distance_upper_bound=2.0 * INSIDE_M)[0]
    return np.asarray(rounded(np.minimum(distances, 2.0 * INSIDE_M)) >= INSIDE_M)
