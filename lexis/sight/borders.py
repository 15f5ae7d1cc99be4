"""Moves the border between two labels on the path to the doorway beside it.

An image that is taken in a doorway shows the next room, and one that is taken in front of a door may show the room behind.
A keyframe next to a doorway may thus have the label of the room on the other side.

Where the label changes from one keyframe to the next, and the path goes through a narrow passage (`lexis.sight.passages`) a
little before or after, the label changes in the passage instead. The keyframes in between take the label of their own side.
"""

import numpy as np

from lexis.floors import NO_FLOOR
from lexis.maths.ties import rounded
from lexis.sight.crossings import crossed
from lexis.sight.passages import Passages
from lexis.types import PerKeyframe, Positions


def borders_in_passages(
    labels: PerKeyframe,
    floors: PerKeyframe,
    positions: Positions,
    sessions: PerKeyframe,
    found: Passages,
    border_m: float,
) -> PerKeyframe:
    """Move each border between two labels that is near a passage on the path, and return the labels of the keyframes.

    A border stays if the label changes again between the border and the passage.

    Args:
        labels: label of every keyframe.
        floors: floor of every keyframe; borders neither move on stairs nor to another floor.
        positions: positions of the keyframes in W [m].
        sessions: session of every keyframe; borders do not move to another session.
        found: the narrow passages on the path.
        border_m: largest distance on the path between a border and a passage [m].
    """
    # Entry k of the next arrays belongs to the step from keyframe k to keyframe k + 1.
    steps = np.stack([np.arange(len(labels) - 1), np.arange(1, len(labels))], axis=1)
    level = (sessions[1:] == sessions[:-1]) & (floors[1:] == floors[:-1]) & (floors[1:] != NO_FLOOR)
    ends = np.flatnonzero((labels[1:] != labels[:-1]) | ~level)
    passages = np.flatnonzero(crossed(found, floors, positions, steps) & level)
    if not len(passages):
        return labels
    lengths = np.linalg.norm(positions[1:, :2] - positions[:-1, :2], axis=1)
    middles = np.cumsum(lengths) - lengths / 2  # of the steps, as distances on the path
    moved = labels.copy()
    for border in ends[level[ends]].tolist():
        distances = rounded(np.abs(middles[passages] - middles[border]))
        passage = int(passages[distances.argmin()])
        low, high = min(border, passage), max(border, passage)
        if distances.min() <= border_m and np.count_nonzero((ends >= low) & (ends <= high)) == 1:
            moved[low + 1 : high + 1] = labels[border] if border < passage else labels[border + 1]
    return moved
