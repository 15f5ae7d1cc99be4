"""Where a path into a room may end, and the doubt that a robot which stops there is inside the room.

A path has to end in the right room, but need not lead to its middle. The keyframe of the room that is nearest to the start
is mostly a bad end: it lies at the boundary, where some labels are wrong. The planner therefore minimises the sum of the
length of a path and the doubt at its end. Doubt is measured in metres: it is the detour that an end without doubt is worth.
It has two parts:

1. Unclear evidence: the evidence at the keyframe (`lexis.planning.evidence`) is a small share of the evidence at the
   innermost keyframe of any room with the label. Just behind a door or an open boundary, about half of the images still show
   the other room.
2. Unsure labels: a keyframe at most `NEAR_M` away may have another label. What counts is the least probability of the label
   (`LexisMap.probabilities`), because a robot whose estimate has drifted stops up to 0.4 m in front of the keyframe.

The innermost keyframe of the room is always a possible end. Only the evidence counts there, because around every keyframe
of a small room there are other labels. With an encoder that is less sure, paths therefore end nearer to it.

Doubt is about the end of a path. Whether a room exists at all is another question; see `clear_ends` in
`lexis.planning.path_ends`.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int
from scipy.spatial import cKDTree
from scipy.special import logit

from lexis.maths.ties import MILLIONTH, rounded
from lexis.planning.evidence import evidence_at
from lexis.planning.path_ends import PathEnd
from lexis.types import LexisMap, RoomInstance

NEAR_M = 0.6
"""The labels of keyframes within this distance of the end of a path count [m]."""
LEAST_SHARE = 0.35
"""A path does not end at a keyframe whose share of the largest evidence is lower, except at the innermost keyframe."""
CLEAR_SHARE, UNCLEAR_M = 0.9, 1.0
"""From this share on, the evidence is clear. Below, the doubt is `UNCLEAR_M` [m] times the missing part of the share."""
SURE_LOG_ODDS, UNSURE_M = 5.0, 0.3
"""From these log odds on, a probability of 0.993, labels are sure. Below, the doubt is `UNSURE_M` [m] times the missing part
of the log odds."""
_LEAST_PROBABILITY = 1e-4
"""Lower probabilities count as this one, so that doubt is finite."""


class Arrival(NamedTuple):
    """A keyframe at which a path may end."""

    room: RoomInstance
    keyframe: int
    doubt_m: float
    """The doubt that a robot which stops there is inside the room [m]."""


def arrivals(map: LexisMap, innermost: PathEnd, clearest: float) -> list[Arrival]:
    """Return where a path into a room may end, and the doubt there; by ascending keyframe.

    The innermost keyframe is among them, even if it belongs to a neighbouring room (`path_end`). In a room without positive
    evidence it is the only one, and its doubt is 0: such a room is a goal only if no room of its label has evidence.

    Args:
        map: the map.
        innermost: the innermost keyframe of the room.
        clearest: the largest evidence at the innermost keyframe of any room with the label, at least that of this room.
    """
    room = innermost.room
    if innermost.evidence <= 0.0:
        return [Arrival(room, innermost.keyframe, 0.0)]
    keyframes = np.array(room.keyframes)
    shares = evidence_at(map, room.label, keyframes) / clearest
    keyframes, shares = keyframes[shares >= LEAST_SHARE], shares[shares >= LEAST_SHARE]
    doubts = rounded(_unclear(shares) + _unsure(map, room.label, keyframes))
    found = dict(zip(keyframes.tolist(), doubts.tolist(), strict=True))
    found[innermost.keyframe] = float(rounded(_unclear(np.array([innermost.evidence / clearest])))[0])
    return [Arrival(room, keyframe, found[keyframe]) for keyframe in sorted(found)]


def _unclear(shares: Float64[np.ndarray, "k"]) -> Float64[np.ndarray, "k"]:
    return UNCLEAR_M * np.maximum(CLEAR_SHARE - shares, 0.0)


def _unsure(map: LexisMap, label: str, keyframes: Int[np.ndarray, "k"]) -> Float64[np.ndarray, "k"]:
    positions, probabilities = map.T_W_B[:, :3, 3], map.probabilities[:, map.room_names.index(label)]
    near = cKDTree(positions).query_ball_point(positions[keyframes], NEAR_M + MILLIONTH)
    least = np.array([probabilities[ids].min() for ids in near])
    log_odds = logit(np.clip(least, _LEAST_PROBABILITY, 1.0 - _LEAST_PROBABILITY))
    return np.asarray(UNSURE_M * np.maximum(SURE_LOG_ODDS - log_odds, 0.0))
