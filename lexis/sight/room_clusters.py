"""Room instances as groups of keyframes that see each other's places."""

import numpy as np
from jaxtyping import Bool
from scipy.sparse import csr_array

from lexis.config import SightConfig
from lexis.floors import NO_FLOOR
from lexis.graph.walked_steps import walked_pairs
from lexis.maths.groups import groups_of
from lexis.maths.ties import near_pairs, rounded
from lexis.room_labels import Probabilities
from lexis.sight.alike_rooms import merge_alike
from lexis.sight.borders import borders_in_passages
from lexis.sight.crossings import crossed
from lexis.sight.divided_rooms import sight_between, split_divided
from lexis.sight.passages import LinesOfSight, Passages, narrow_passages
from lexis.types import Pairs, PerKeyframe, Positions

_STAIRCASE_M = 3.0
"""Largest horizontal distance between two keyframes on stairs that are joined to one staircase [m]."""


def cluster_by_sight(
    labels: PerKeyframe,
    floors: PerKeyframe,
    positions: Positions,
    sessions: PerKeyframe,
    probabilities: Probabilities,
    seen_by: csr_array,
    lines: LinesOfSight,
    config: SightConfig,
    correct: bool = True,
) -> tuple[PerKeyframe, PerKeyframe]:
    """Group keyframes into rooms; return the number of the room of every keyframe, and the labels of the keyframes.

    1. Borders between labels move to the doorways beside them; see `lexis.sight.borders`.
    2. Two keyframes of one label and floor are in one room if one sees the place of the other, or if they are consecutive in
       a session, without a gap in the recording between them (`walked_pairs`). With several cameras, one image that shows
       the place is enough. Two keyframes on stairs are also in one room if they are horizontally close, because the flights
       of a staircase lie above one another.
    3. A room between whose parts there is hardly any sight is split; see `lexis.sight.divided_rooms`. Sight through a narrow
       passage, such as a doorway, counts less; see `lexis.sight.passages`.
    4. A room of fewer than `min_keyframes` keyframes is absorbed by the larger room of its floor that it sees, or is seen
       from, most. Its keyframes take the label of that room. Stairs neither absorb a room nor are absorbed.
    5. Rooms that share their space merge if the images cannot tell their labels apart; see `lexis.sight.alike_rooms`.

    Two rooms of one label with a wall between them thus stay two rooms, and a long room stays one room.

    Args:
        labels: label of every keyframe.
        floors: floor of every keyframe; `NO_FLOOR` on stairs.
        positions: positions of the keyframes in W [m].
        sessions: session of every keyframe.
        probabilities: the probability of each label for every keyframe, from the images alone.
        seen_by: the matrix that `lexis.sight.visible_space.sight` returns; for several cameras, the largest entries of all.
        lines: the lines of sight of the keyframes, in which narrow passages are found.
        config: the least share of a visible space that counts as seeing a place, the least size of a room, and when rooms
            are split and merge.
        correct: whether labels may be corrected; if not, steps 1, 4 and 5 are left out.
    """
    n = len(labels)
    passages = narrow_passages(lines, floors, positions, sessions, config.passage_m)
    if correct:
        labels = borders_in_passages(labels, floors, positions, sessions, passages, config.border_m)
    walked = walked_pairs(positions, sessions)
    pairs = np.concatenate([walked, _seeing(seen_by, config.share)])
    first, second = pairs.T
    alike = (labels[first] == labels[second]) & (floors[first] == floors[second])
    joined = np.concatenate([pairs[alike], _on_one_staircase(floors == NO_FLOOR, positions)])
    rooms = groups_of(joined, n)
    tied = sight_between(seen_by, positions, sessions)
    past_passages = _weakened(tied, passages, floors, positions, config.passage_weight)
    rooms = split_divided(rooms, floors != NO_FLOOR, positions, tied, past_passages, config)
    if not correct:
        return rooms, labels
    open_steps = walked[~crossed(passages, floors, positions, walked)]
    rooms, labels = _absorbed(rooms, labels, floors, seen_by, config.min_keyframes)
    return merge_alike(rooms, labels, floors, probabilities, tied, open_steps, config)


def _weakened(tied: csr_array, passages: Passages, floors: PerKeyframe, positions: Positions, weight: float) -> csr_array:
    """Return the ties of sight, of which those through a passage are multiplied by `weight`."""
    entries = tied.tocoo()
    through = crossed(passages, floors, positions, np.stack(entries.coords, axis=1))
    return csr_array((entries.data * np.where(through, weight, 1.0), entries.coords), shape=tied.shape)


def _seeing(seen_by: csr_array, share: float) -> Pairs:
    """Return pairs of keyframes of which one sees the place of the other, with more than `share` of its visible space."""
    entries = seen_by.tocoo()
    return np.stack(entries.coords, axis=1)[rounded(entries.data) > share]


def _on_one_staircase(stairs: Bool[np.ndarray, "n"], positions: Positions) -> Pairs:
    """Return pairs of keyframes on stairs that are horizontally close."""
    climbing = np.flatnonzero(stairs)
    return np.asarray(climbing[near_pairs(positions[climbing, :2], _STAIRCASE_M)])


def _absorbed(
    rooms: PerKeyframe, labels: PerKeyframe, floors: PerKeyframe, seen_by: csr_array, min_keyframes: int
) -> tuple[PerKeyframe, PerKeyframe]:
    """Merge each small room into the larger room of its floor that it sees, or is seen from, most, if there is one."""
    rooms, labels, shared = rooms.copy(), labels.copy(), seen_by + seen_by.T
    size = np.bincount(rooms)
    small = (size < min_keyframes)[rooms] & (floors != NO_FLOOR)
    large = ~small & (floors != NO_FLOOR)
    for room in np.unique(rooms[small]).tolist():
        members = np.flatnonzero(rooms == room)
        weight = shared[members].sum(axis=0) * (large & (floors == floors[members[0]]))
        into = int(rounded(np.bincount(rooms, weight)).argmax())
        if weight[rooms == into].any():
            rooms[members], labels[members] = into, labels[rooms == into][0]
    return rooms, labels
