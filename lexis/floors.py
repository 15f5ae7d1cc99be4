"""Floors: stairs divide the walk into level stretches, which are grouped by height (paper, Sec. III-C).

Beyond the paper, rides in a lift and ramps divide the walk, too.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.maths.paths import arc_length
from lexis.maths.stretches import Stretch, stretches_of
from lexis.maths.ties import rounded
from lexis.stairs import RIDE_M, Metres, lift_rides

NO_FLOOR = -1
"""Floor number of a keyframe on stairs, which is on no floor."""
STOREY_GAP_M = 1.0
"""Smallest height difference between two floors [m]."""
MIN_KEYFRAMES = 4
"""Fewest keyframes in a level stretch that forms a floor; a shorter one may be a landing that was not labelled as stairs."""
RAMP_SLOPE = 0.04
"""Slope above which a change of height is a ramp and not drift. Ramps have slopes of 0.06 to 0.125, drift is less."""
RAMP_RISE_M = 0.5
"""Least rise of a ramp above `RAMP_SLOPE` times its length [m]."""


def floor_numbers(floors: Int[np.ndarray, "n"]) -> list[int]:
    """Return the numbers of the floors on which there are keyframes, ascending; stairs are on none."""
    return sorted({int(floor) for floor in floors} - {NO_FLOOR})


def assign_floors(
    stairs: Bool[np.ndarray, "n"], positions: Float64[np.ndarray, "n 3"], sessions: Int[np.ndarray, "n"] | None = None
) -> Int[np.ndarray, "n"]:
    """Return the number of the floor of every keyframe, 0 for the lowest floor and -1 on stairs.

    `sessions` are the sessions of the keyframes; None: they are all of one. Neither a ride nor a ramp leads from one session
    to the next.

    1. Divide the walk into level stretches. Between them are stairs, rides in a lift, and ramps.
    2. Give every stretch a height by summing the height differences between the stretches before it. Height changes within
       a stretch are left out, because floors are level and such changes are drift.
    3. Divide these heights into groups, the floors, wherever a gap exceeds `STOREY_GAP_M`. A stretch of fewer than
       `MIN_KEYFRAMES` keyframes is not grouped and gets the nearest floor. If all stretches are that short, the longest are
       grouped.
    4. A keyframe on a ramp gets the nearest floor, too. So does a keyframe in a moving lift that is not labelled as stairs,
       because the user's room names lack stairs.
    """
    if stairs.all():
        return np.full(len(stairs), NO_FLOOR)
    stretches = _level_stretches(stairs, positions, np.zeros(len(stairs), int) if sessions is None else sessions)
    heights = _without_drift(stretches, positions[:, 2])
    least = min(MIN_KEYFRAMES, max(run.stop - run.start for run in stretches))
    levels = _floor_heights(np.array([heights[run.start] for run in stretches if run.stop - run.start >= least]))
    nearest = np.abs(levels - heights[:, None]).argmin(axis=1)
    return np.where(stairs, NO_FLOOR, nearest)


def _level_stretches(
    stairs: Bool[np.ndarray, "n"], positions: Float64[np.ndarray, "n 3"], sessions: Int[np.ndarray, "n"]
) -> list[Stretch]:
    """Return the stretches of keyframes off the stairs without a ride in a lift and without a ramp.

    Single steps of at least `RIDE_M` in height divide the walk, too, such as a gap in the recording. Ramps count as level if
    nothing else is left, and so do rides whose keyframes are not labelled as stairs.
    """
    rising = stairs.copy()
    for ride in lift_rides(positions, sessions):
        rising[ride.start + 1 : ride.stop - 1] = True
    jumps = np.append(0, np.cumsum(np.abs(np.diff(positions[:, 2])) >= RIDE_M))[: len(stairs)]
    runs = _off(rising, jumps)
    for run in runs:
        for session in stretches_of(sessions[run.slice]):
            rising[run.slice][session.slice] = _on_ramps(positions[run.slice][session.slice])
    return _off(rising, jumps) or runs or _off(stairs, jumps)


def _off(rising: Bool[np.ndarray, "n"], jumps: Int[np.ndarray, "n"]) -> list[Stretch]:
    """Return the stretches of keyframes that are not rising and have no jump of height between them."""
    return [run for run in stretches_of(2 * jumps + rising) if not rising[run.start]]


def _on_ramps(positions: Float64[np.ndarray, "n 3"]) -> Bool[np.ndarray, "n"]:
    """Whether each keyframe of a walk off the stairs is on a ramp.

    The steepest ramp is the part of the walk that rises or falls most above `RAMP_SLOPE` times its length. Further ramps are
    found in the same way before and after it.
    """
    ramps, waiting = np.zeros(len(positions), bool), [(0, len(positions))]
    while waiting:
        first, last = waiting.pop()
        path, height = arc_length(positions[first:last]), positions[first:last, 2]
        excess, start, stop = max(_largest_rise(sign * height - RAMP_SLOPE * path) for sign in (1.0, -1.0))
        if excess >= RAMP_RISE_M:
            ramps[first + start + 1 : first + stop] = True
            waiting += [(first, first + start + 1), (first + stop, last)]
    return ramps


def _largest_rise(values: Metres) -> tuple[float, int, int]:
    """Return the largest rise from a value to a later one, and the indices of both."""
    values = rounded(values)
    rises = values - np.minimum.accumulate(values)
    stop = int(rises.argmax())
    return float(rises[stop]), int(values[: stop + 1].argmin()), stop


def _without_drift(level: list[Stretch], height: Metres) -> Metres:
    """Return the height of every keyframe relative to the first, without the height changes within level stretches [m]."""
    steps = np.diff(height, prepend=height[:1])
    for run in level:
        steps[run.start + 1 : run.stop] = 0.0
    return np.cumsum(steps)


def _floor_heights(heights: Float64[np.ndarray, "k"]) -> Float64[np.ndarray, "levels"]:
    """Mean height of every floor, ascending; a gap larger than `STOREY_GAP_M` separates two floors [m]."""
    ordered = np.sort(heights)
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > STOREY_GAP_M) + 1)
    return np.array([group.mean() for group in groups])
