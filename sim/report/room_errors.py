"""Rooms that were cut, joined, or lost a part: the splits and merges of result.json by name, and what is neither."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress
from typing import TypeAlias

import numpy as np
from jaxtyping import Bool, Int

from lexis.evaluation.partitions import overlap
from lexis.evaluation.rooms import SHARE

SUBSTANTIAL = 0.2
"""The share of a true room that must lie in a predicted one of another place before that is worth a line."""

Groups: TypeAlias = dict[str, tuple[str, ...]]
"""By the name of a room, names of rooms of the other side."""


@dataclass(frozen=True)
class RoomErrors:
    """What is wrong with a partition of keyframes into rooms."""

    splits: Groups
    """True rooms, each with the several predicted ones that lie mostly (> half) in it."""
    merges: Groups
    """Predicted rooms, each with the several true ones that lie mostly (> half) in it."""
    losses: Groups
    """True rooms that are in no merge, each with the predicted ones that hold a substantial share of it and lie mostly
    elsewhere."""


def room_errors(true: Sequence[str], predicted: Sequence[str]) -> RoomErrors:
    """Compare the true and the predicted room of every keyframe, both by name."""
    true_names, true_ids = _numbered(true)
    predicted_names, predicted_ids = _numbered(predicted)
    table = overlap(predicted_ids, true_ids)
    of_predicted = table / table.sum(axis=1, keepdims=True)
    of_true = table / table.sum(axis=0, keepdims=True)
    merges = _groups(of_true > SHARE, predicted_names, true_names, least=2)
    merged = {name for names in merges.values() for name in names}
    losses = _groups(((of_true >= SUBSTANTIAL) & (of_predicted <= SHARE)).T, true_names, predicted_names, least=1)
    return RoomErrors(
        splits=_groups((of_predicted > SHARE).T, true_names, predicted_names, least=2),
        merges=merges,
        losses={room: others for room, others in losses.items() if room not in merged},
    )


def surplus(groups: Groups) -> int:
    """Rooms beyond the first of every group: how result.json counts splits and merges."""
    return sum(len(names) - 1 for names in groups.values())


def _numbered(rooms: Sequence[str]) -> tuple[list[str], Int[np.ndarray, "n"]]:
    names, ids = np.unique(np.array(rooms), return_inverse=True)
    return names.tolist(), ids


def _groups(belongs: Bool[np.ndarray, "a b"], names: Sequence[str], others: Sequence[str], least: int) -> Groups:
    """By the name of a row, the columns that belong to it, where there are at least so many."""
    rows = zip(names, belongs, strict=True)
    return {name: tuple(compress(others, row)) for name, row in rows if row.sum() >= least}
