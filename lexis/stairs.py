"""Detection of stairs and of rides in a lift by height change, whether or not the camera sees them (paper, Sec. III-B)."""

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.config import LabelConfig
from lexis.maths.paths import arc_length
from lexis.maths.stretches import Stretch, stretches_of, true_stretches

LANDING_M = 2.5
"""Longest path between the first and the last keyframe of a half landing between two flights [m]."""
FLOOR_PATH_M = 4.0
"""Least length of a level stretch of the walk that certainly lies on a floor and not on a landing [m]."""
FLOOR_TOLERANCE_M = 0.4
"""Smallest height difference between a half landing and the nearest floor [m]."""
LEVEL_M = 0.065
"""A keyframe at an end of the stairs is on the floor if its height differs from that of the next keyframe off the stairs by
less than this [m]. Odometry drifts by less than this from one keyframe to the next, and a stair riser is more than twice as
high."""
LEVEL_SLOPE = 0.4
"""Smallest ratio of climb to path between two keyframes of which one is certainly on stairs. Keyframes that are much closer
than usual climb less than `LEVEL_M` on stairs."""
RIDE_M = 1.2
"""Smallest change of height of a ride in a lift [m]."""
RIDE_SLOPE = 1.3
"""Smallest ratio of climb to horizontal path in a lift. Stairs that people walk on reach 1.0."""
RIDE_END_SLOPE = 0.3
"""Smallest ratio of climb to horizontal path in a step that is partly walked and partly ridden, at either end of a ride."""

Metres = Float64[np.ndarray, "n"]
"""A length or a height of each keyframe [m]."""
Sessions = Int[np.ndarray, "n"]


def on_stairs(
    positions: Float64[np.ndarray, "n 3"], config: LabelConfig, sessions: Sessions | None = None
) -> Bool[np.ndarray, "n"]:
    """Whether each keyframe stands on stairs, including half landings between two flights, or inside a moving lift.

    A keyframe climbs if the height changes by at least `stairs_min_height_m` over `stairs_window_m` of path centred on it.
    Odometry drift over that path is an order of magnitude smaller. At the foot and the top of a flight, half of the window
    covers the flight. With the defaults (2 m, stairs of 30-37 degrees), the climb therefore begins close to the first step
    and ends close to the last; on steep flights, it reaches up to 0.25 m beyond the steps. A keyframe there counts as on
    the floor if the next keyframe is on a floor and has the same height. A ride in a lift divides the path into walks, so
    that no window reaches across the ride.

    `sessions` are the sessions of the keyframes; None: they are all of one. A step in height between two sessions is no
    climb, because nobody walked from one to the other.
    """
    stairs = np.ones(len(positions), bool)
    for session in stretches_of(np.zeros(len(positions)) if sessions is None else sessions):
        for walk in _walks(positions[session.slice]):
            stairs[session.slice][walk.slice] = _on_flights(positions[session.slice][walk.slice], config)
    return stairs


def lift_rides(positions: Float64[np.ndarray, "n 3"], sessions: Sessions | None = None) -> list[Stretch]:
    """Return the rides in a lift, each from the last keyframe before the climb to the first keyframe after it.

    In a ride the height changes by at least `RIDE_M` with almost no horizontal path: in a single step if no images arrive
    during the ride, otherwise in several steps in the same direction. No ride leads from one session to the next; without
    `sessions`, all keyframes are of one.
    """
    steps = np.diff(positions, axis=0)
    if sessions is not None:
        steps[np.diff(sessions) != 0] = 0.0
    direction = np.where(is_vertical(steps), np.sign(steps[:, 2]), 0.0)
    rises = [run for run in stretches_of(direction) if direction[run.start] != 0]
    return [_with_ends(run, steps) for run in rises if abs(steps[run.slice, 2].sum()) >= RIDE_M]


def _with_ends(run: Stretch, steps: Float64[np.ndarray, "n 3"]) -> Stretch:
    """Return the stretch of keyframes of a ride, whose vertical steps are the stretch `run` of all `steps` [m].

    The step before and the step after the vertical ones belong to the ride, too, if they climb in the same direction.
    """
    rising = np.sign(steps[run.start, 2]) * steps[:, 2] > RIDE_END_SLOPE * np.linalg.norm(steps[:, :2], axis=1)
    rising = np.pad(rising, 1)
    return Stretch(run.start - int(rising[run.start]), run.stop + 1 + int(rising[run.stop + 1]))


def is_vertical(steps: Float64[np.ndarray, "n 3"]) -> Bool[np.ndarray, "n"]:
    """Whether each step [m] is too steep for stairs, so that only a lift can have carried the camera."""
    return np.asarray(np.abs(steps[:, 2]) > RIDE_SLOPE * np.linalg.norm(steps[:, :2], axis=1))


def _walks(positions: Float64[np.ndarray, "n 3"]) -> list[Stretch]:
    """Return the stretches of keyframes before, between and after the rides in a lift."""
    rides = lift_rides(positions)
    starts = [0, *(ride.stop - 1 for ride in rides)]
    return [Stretch(a, b) for a, b in zip(starts, [*(ride.start + 1 for ride in rides), len(positions)], strict=True)]


def _on_flights(positions: Float64[np.ndarray, "n 3"], config: LabelConfig) -> Bool[np.ndarray, "n"]:
    """Whether each keyframe of a walk without rides in a lift stands on stairs."""
    if len(positions) < 2:
        return np.zeros(len(positions), bool)
    path = arc_length(positions) + 1e-9 * np.arange(len(positions))  # interpolation needs values that increase
    half = config.stairs_window_m / 2
    height = positions[:, 2]
    change = np.interp(path + half, path, height) - np.interp(path - half, path, height)
    climbs = np.where(np.abs(change) >= config.stairs_min_height_m, np.sign(change), 0.0)
    stairs = np.asarray(climbs != 0)
    for landing in _landings(climbs, path, height):
        stairs[landing] = True
    return np.asarray(stairs & ~_level_ends(stairs, path, height))


def _level_ends(stairs: Bool[np.ndarray, "n"], path: Metres, height: Metres) -> Bool[np.ndarray, "n"]:
    """Whether each keyframe is at an end of the stairs, but as high as the next keyframe, which is on a floor.

    If no keyframe would be left on the stairs, their images were lost, and all of their keyframes stay: they are all that
    tells that two floors are apart.
    """
    level = np.zeros(len(stairs), bool)
    for run in true_stretches(stairs):
        ends = np.zeros(run.stop - run.start, bool)
        if run.start > 0:
            before = slice(run.start - 1, run.stop)
            ends |= _as_high_as_first(path[before], height[before])
        if run.stop < len(stairs):
            after = slice(run.start, run.stop + 1)
            ends |= _as_high_as_first(path[after][::-1], height[after][::-1])[::-1]
        if not ends.all():
            level[run] = ends
    return level


def _as_high_as_first(path: Float64[np.ndarray, "k"], height: Float64[np.ndarray, "k"]) -> Bool[np.ndarray, "m"]:
    """Whether each keyframe after the first one, and all keyframes in between, are as high as the first one."""
    same = np.abs(height[1:] - height[0]) < LEVEL_M
    return np.asarray(np.logical_and.accumulate(same & (np.abs(np.diff(height)) < LEVEL_SLOPE * np.abs(np.diff(path)))))


def _landings(climbs: Metres, path: Metres, height: Metres) -> list[slice]:
    """Return slices of the keyframes on half landings.

    A half landing is a short level stretch between two flights that both go up or both go down. Its height is not the height
    of a floor.
    """
    level = [run for run in stretches_of(climbs) if climbs[run.start] == 0]
    floors = [float(np.median(height[run.slice])) for run in level if path[run.stop - 1] - path[run.start] >= FLOOR_PATH_M]
    joining = [run.slice for run in level if _joins_flights(run, climbs, path)]
    return [s for s in joining if all(abs(np.median(height[s]) - floor) > FLOOR_TOLERANCE_M for floor in floors)]


def _joins_flights(run: Stretch, climbs: Metres, path: Metres) -> bool:
    inside = run.start > 0 and run.stop < len(climbs)
    return bool(inside and climbs[run.start - 1] == climbs[run.stop] and path[run.stop - 1] - path[run.start] <= LANDING_M)
