"""Floors: the stairs divide the walk into level stretches, which are grouped by height (paper, Sec. III-C)."""

from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.maths.stretches import Stretch, stretches_of

NO_FLOOR = -1
"""Floor number of a keyframe on stairs, which is on no floor."""
STOREY_GAP_M = 1.2
"""Smallest height difference between two floors [m]."""
MIN_KEYFRAMES = 4
"""Fewest keyframes in a level stretch that forms a floor; a shorter one may be a landing that was not labelled as stairs."""


def floor_levels(stairs: Bool[np.ndarray, "n"], height: Float64[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
    """Return the number of the floor of every keyframe, 0 for the lowest floor and -1 on stairs.

    1. Divide the walk into level stretches between stairs.
    2. Give every stretch a height by summing the height differences over the stairs before it. Height changes within a
       stretch are left out, because floors are level and such changes are drift.
    3. Divide these heights into groups, the floors, wherever a gap exceeds `STOREY_GAP_M`. A stretch of fewer than
       `MIN_KEYFRAMES` keyframes is not grouped and gets the nearest floor. If all stretches are that short, the longest are
       grouped.
    """
    floors = np.full(len(stairs), NO_FLOOR)
    stretches = [run for run in stretches_of(stairs) if not stairs[run.start]]
    if not stretches:
        return floors
    heights = _heights_over_stairs(stretches, height)
    lengths = np.array([run.stop - run.start for run in stretches])
    certain = lengths >= min(MIN_KEYFRAMES, int(lengths.max()))
    levels = _levels(heights[certain])
    for run, h in zip(stretches, heights, strict=True):
        floors[run.slice] = int(np.abs(levels - h).argmin())
    return floors


def _heights_over_stairs(stretches: list[Stretch], height: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "k"]:
    """Return the height of every level stretch relative to the first stretch [m].

    It is the sum of the height differences over the stairs between the two; height changes within stretches are left out.
    """
    steps = [height[b.start] - height[a.stop - 1] for a, b in pairwise(stretches)]
    return np.concatenate([[0.0], np.cumsum(steps)])


def _levels(heights: Float64[np.ndarray, "k"]) -> Float64[np.ndarray, "levels"]:
    """Mean height of every floor, ascending; a gap larger than `STOREY_GAP_M` separates two floors [m]."""
    ordered = np.sort(heights)
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > STOREY_GAP_M) + 1)
    return np.array([group.mean() for group in groups])
