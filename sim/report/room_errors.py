"""Finds errors of room segmentation: the splits and merges that result.json counts, and partial losses.

A partial loss is a true room of which a substantial part was assigned to an estimated room that lies mostly elsewhere.
result.json counts partial losses as neither splits nor merges. A true room that is merged with another room is no partial
loss.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress
from typing import TypeAlias

import numpy as np
from jaxtyping import Bool, Int

from lexis.evaluation.partitions import overlap
from lexis.evaluation.rooms import SHARE

SUBSTANTIAL = 0.2
"""A true room counts as a partial loss if at least this share of its keyframes is in an estimated room that lies mostly in
other true rooms."""

Groups: TypeAlias = dict[str, tuple[str, ...]]
"""Maps the name of a true room to names of estimated rooms, or the name of an estimated room to names of true rooms."""


@dataclass(frozen=True)
class RoomErrors:
    """Errors in the assignment of keyframes to rooms."""

    splits: Groups
    """Maps each split true room to the estimated rooms, two or more, that have more than half of their keyframes in it."""
    merges: Groups
    """Maps each estimated room that merges true rooms to the two or more true rooms with most of their keyframes in it."""
    partial_losses: Groups
    """Maps each true room that is a partial loss to the estimated rooms that hold at least the share `SUBSTANTIAL` of its
    keyframes, but lie mostly in other true rooms. True rooms in `merges` are left out."""


def room_errors(true: Sequence[str], predicted: Sequence[str]) -> RoomErrors:
    """Find the errors of room segmentation.

    `true` and `predicted` name the true and the estimated room of each keyframe; "" stands for no estimated room.
    """
    true_names, true_ids = numbered_rooms(true)
    predicted_names, predicted_ids = numbered_rooms(predicted)
    whole = overlap(predicted_ids, true_ids)
    of_predicted, of_true = whole / whole.sum(axis=1, keepdims=True), whole / whole.sum(axis=0, keepdims=True)
    rooms = [k for k, name in enumerate(predicted_names) if name]
    predicted_names, of_predicted, of_true = [predicted_names[k] for k in rooms], of_predicted[rooms], of_true[rooms]
    merges = _groups(of_true > SHARE, predicted_names, true_names, least=2)
    merged = {name for names in merges.values() for name in names}
    partial_losses = _groups(((of_true >= SUBSTANTIAL) & (of_predicted <= SHARE)).T, true_names, predicted_names, least=1)
    return RoomErrors(
        splits=_groups((of_predicted > SHARE).T, true_names, predicted_names, least=2),
        merges=merges,
        partial_losses={room: others for room, others in partial_losses.items() if room not in merged},
    )


def surplus(groups: Groups) -> int:
    """Return the number of rooms that the groups list, not counting the first room of each group.

    result.json counts splits and merges in this way.
    """
    return sum(len(names) - 1 for names in groups.values())


def numbered_rooms(rooms: Sequence[str]) -> tuple[list[str], Int[np.ndarray, "n"]]:
    """Return the different names of rooms, and for each of `rooms` the index of its name."""
    names, ids = np.unique(np.array(rooms), return_inverse=True)
    return names.tolist(), ids


def _groups(belongs: Bool[np.ndarray, "a b"], names: Sequence[str], others: Sequence[str], least: int) -> Groups:
    """Map the name of each row to the names of the columns in which the row is true.

    Rows with fewer than `least` true columns are left out.
    """
    rows = zip(names, belongs, strict=True)
    return {name: tuple(compress(others, row)) for name, row in rows if row.sum() >= least}
