"""Floors: the walk cut at the stairs, its level stretches grouped by height (paper, Sec. III-C)."""

from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.maths.stretches import Stretch, stretches_of

NO_FLOOR = -1
"""Floor of a keyframe on stairs."""
STOREY_GAP_M = 1.2
"""Smallest difference of height between two floors [m]."""
MIN_KEYFRAMES = 4
"""A shorter level stretch is no floor of its own: it may be a landing that was not seen as stairs."""


def floor_levels(stairs: Bool[np.ndarray, "n"], height: Float64[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
    """Floor of every keyframe, 0 the lowest and -1 on stairs.

    Between stairs a floor is level, so that what the height changes there is drift: only what the stairs climb is summed
    up. Stretches then share a floor when their sums lie within a storey's gap of each other.
    """
    floors = np.full(len(stairs), NO_FLOOR)
    stretches = [run for run in stretches_of(stairs) if not stairs[run.start]]
    if not stretches:
        return floors
    heights = _climbed(stretches, height)
    lengths = np.array([run.stop - run.start for run in stretches])
    certain = lengths >= min(MIN_KEYFRAMES, int(lengths.max()))
    levels = _levels(heights[certain])
    for run, h in zip(stretches, heights, strict=True):
        floors[run.slice] = int(np.abs(levels - h).argmin())
    return floors


def _climbed(stretches: list[Stretch], height: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "k"]:
    """Height of every stretch above the first one by the stairs between them alone [m]."""
    steps = [height[b.start] - height[a.stop - 1] for a, b in pairwise(stretches)]
    return np.concatenate([[0.0], np.cumsum(steps)])


def _levels(heights: Float64[np.ndarray, "k"]) -> Float64[np.ndarray, "levels"]:
    """Mean height of every group of heights without a storey's gap inside, ascending [m]."""
    ordered = np.sort(heights)
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > STOREY_GAP_M) + 1)
    return np.array([group.mean() for group in groups])
