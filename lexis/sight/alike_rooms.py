"""Merges rooms that share their space and whose labels the images cannot tell apart: an open-plan office and an office.

The images of a large room may resemble two room names about equally, so that some of its keyframes have one label and the
others another. Between two real rooms of an open plan, there is just as much sight, but the images of either room are
clearly more like its own name.

Two rooms of one floor merge under two conditions:

- The normalised cut between them, which is the sight between the rooms, relative to all sight of either room, is at least
  `merge_cut`.
- In each room, the mean log odds of its own label over the label of the other room are less than `merge_log_odds`. If one of
  the rooms is an alcove of the other one, the limit for the other one is `alcove_log_odds`.

A room is an alcove of another one if the path leaves it into the other one only, except through doorways
(`lexis.sight.passages`). The images of a whole open-plan office may be clearly of its name, and a corner of it may still
look more like an office.

The merged room has the label with the larger sum of log probabilities. Rooms merge one pair after the other, those with the
largest cut first.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.sparse import csr_array

from lexis.config import SightConfig
from lexis.floors import NO_FLOOR
from lexis.maths.ties import rounded
from lexis.room_labels import Probabilities
from lexis.sight.divided_rooms import normalised_cuts
from lexis.types import Pairs, PerKeyframe

BetweenRooms = Float64[np.ndarray, "rooms rooms"]

_LEAST_PROBABILITY = 1e-9
"""Constant that is added to probabilities before their logarithm is taken."""
_MOSTLY = 0.75
"""An alcove opens into one room only: at least this share of the steps that leave it, other than through a passage, lead
there. It is less than 1, because single keyframes may have a wrong label."""


def merge_alike(
    rooms: PerKeyframe,
    labels: PerKeyframe,
    floors: PerKeyframe,
    probabilities: Probabilities,
    tied: csr_array,
    open_steps: Pairs,
    config: SightConfig,
) -> tuple[PerKeyframe, PerKeyframe]:
    """Merge rooms that share their space and are hard to tell apart; return the new rooms and labels of the keyframes.

    Args:
        rooms: number of the room of every keyframe.
        labels: label of every keyframe; all keyframes of a room have one label and floor.
        floors: floor of every keyframe; `NO_FLOOR` on stairs, which do not merge with rooms.
        probabilities: the probability of each label for every keyframe, from the images alone.
        tied: the matrix that `lexis.sight.divided_rooms.sight_between` returns.
        open_steps: the steps of the path that go through no narrow passage, as pairs of consecutive keyframes. Gaps in the
            recording are no steps.
        config: the least cut and the largest log odds.
    """
    n = len(rooms)
    _, first, room, count = np.unique(rooms, return_index=True, return_inverse=True, return_counts=True)
    label, floor = labels[first], floors[first]
    member = csr_array((np.ones(n), (room, np.arange(n))))
    walked = csr_array((np.ones(len(open_steps)), tuple(open_steps.T)), shape=(n, n))
    sight, steps = ((member @ ties @ member.T).toarray() for ties in (tied, walked + walked.T))
    logs = member @ np.log(probabilities + _LEAST_PROBABILITY)
    possible = (floor == floor[:, None]) & (floor != NO_FLOOR) & ~np.eye(len(label), dtype=bool)
    while True:
        cut = np.where(possible, rounded(normalised_cuts(sight)), 0.0)
        cut[~_hard_to_tell_apart(_log_odds(logs / count[:, None], label), _alcoves(steps), config)] = 0.0
        kept, merged = np.unravel_index(cut.argmax(), cut.shape)
        if cut[kept, merged] < config.merge_cut:
            return room, label[room]
        room[room == merged] = kept
        count[kept] += count[merged]
        logs[kept] += logs[merged]
        label[kept] = max(label[kept], label[merged], key=rounded(logs[kept]).__getitem__)
        for between in (sight, steps):
            between[kept] += between[merged]
            between[:, kept] += between[:, merged]
            between[merged], between[:, merged] = 0.0, 0.0  # no cut of the merged room is large enough then


def _log_odds(logs: Float64[np.ndarray, "rooms labels"], label: Int[np.ndarray, "rooms"]) -> BetweenRooms:
    """Return how clearly the images of each room (row) show its own label and not that of each other room (column).

    `logs` are the mean log probabilities of all labels in each room.
    """
    return np.asarray(rounded(logs[np.arange(len(label)), label][:, None] - logs[:, label]))


def _alcoves(steps: BetweenRooms) -> Bool[np.ndarray, "rooms rooms"]:
    """Return which rooms (rows) are alcoves of which others (columns), from the number of open steps between the rooms."""
    leaving = np.where(np.eye(len(steps), dtype=bool), 0.0, steps)
    return np.asarray((leaving > 0) & (leaving >= _MOSTLY * leaving.sum(axis=1, keepdims=True)))


def _hard_to_tell_apart(
    odds: BetweenRooms, alcoves: Bool[np.ndarray, "rooms rooms"], config: SightConfig
) -> Bool[np.ndarray, "rooms rooms"]:
    """Return which pairs of rooms may be one room, by the labels that their images show."""
    unclear = odds < config.merge_log_odds
    not_too_clear = odds < config.alcove_log_odds
    alcoves = alcoves & unclear & not_too_clear.T
    return np.asarray((unclear & unclear.T) | alcoves | alcoves.T)
