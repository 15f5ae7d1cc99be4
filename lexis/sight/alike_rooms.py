"""Merges rooms that share their space and whose labels the images cannot tell apart: an open-plan office and an office.

The images of a large room may resemble two room names about equally, so that some of its keyframes have one label and the
others another. Between two real rooms of an open plan, there is just as much sight, but the images of either room are
clearly more like its own name.

Two rooms of one floor merge under two conditions:

- The normalised cut between them, which is the sight between the rooms, relative to all sight of either room, is at least
  `merge_cut`.
- In each room, the mean log odds of its own label over the label of the other room are less than `merge_log_odds`.

The merged room has the label with the larger sum of log probabilities. Rooms merge one pair after the other, those with the
largest cut first.
"""

import numpy as np
from jaxtyping import Float64, Int
from scipy.sparse import csr_array

from lexis.config import SightConfig
from lexis.floors import NO_FLOOR
from lexis.maths.ties import rounded
from lexis.room_labels import Probabilities
from lexis.sight.divided_rooms import normalised_cuts
from lexis.types import PerKeyframe

_LEAST_PROBABILITY = 1e-9
"""Constant that is added to probabilities before their logarithm is taken."""


def merge_alike(
    rooms: PerKeyframe,
    labels: PerKeyframe,
    floors: PerKeyframe,
    probabilities: Probabilities,
    tied: csr_array,
    config: SightConfig,
) -> tuple[PerKeyframe, PerKeyframe]:
    """Merge rooms that share their space and are hard to tell apart; return the new rooms and labels of the keyframes.

    Args:
        rooms: number of the room of every keyframe.
        labels: label of every keyframe; all keyframes of a room have one label and floor.
        floors: floor of every keyframe; `NO_FLOOR` on stairs, which do not merge with rooms.
        probabilities: the probability of each label for every keyframe, from the images alone.
        tied: the matrix that `lexis.sight.divided_rooms.sight_between` returns.
        config: the least cut and the largest log odds.
    """
    _, first, room, count = np.unique(rooms, return_index=True, return_inverse=True, return_counts=True)
    label, floor = labels[first], floors[first]
    member = csr_array((np.ones(len(rooms)), (room, np.arange(len(rooms)))))
    sight, logs = (member @ tied @ member.T).toarray(), member @ np.log(probabilities + _LEAST_PROBABILITY)
    possible = (floor == floor[:, None]) & (floor != NO_FLOOR) & ~np.eye(len(label), dtype=bool)
    while True:
        cut = np.where(possible, rounded(normalised_cuts(sight)), 0.0)
        cut[rounded(_log_odds(logs / count[:, None], label)) >= config.merge_log_odds] = 0.0
        kept, merged = np.unravel_index(cut.argmax(), cut.shape)
        if cut[kept, merged] < config.merge_cut:
            return room, label[room]
        room[room == merged] = kept
        count[kept] += count[merged]
        logs[kept] += logs[merged]
        label[kept] = max(label[kept], label[merged], key=rounded(logs[kept]).__getitem__)
        sight[kept] += sight[merged]
        sight[:, kept] += sight[:, merged]
        sight[merged], sight[:, merged] = 0.0, 0.0  # no cut of the merged room is large enough then


def _log_odds(
    logs: Float64[np.ndarray, "rooms labels"], label: Int[np.ndarray, "rooms"]
) -> Float64[np.ndarray, "rooms rooms"]:
    """Return for each two rooms how clearly the images of either room show its own label and not that of the other room.

    The result is the larger one of the two log odds. `logs` are the mean log probabilities of all labels in each room.
    """
    odds = logs[np.arange(len(label)), label][:, None] - logs[:, label]
    return np.asarray(np.maximum(odds, odds.T))
