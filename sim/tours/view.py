"""Chooses the direction of view along a path: ahead, with glances to the sides in rooms; on stairs, along the slope."""

from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64
from scipy.ndimage import uniform_filter1d

from lexis.maths.paths import arc_length
from sim.tours.smooth import STEP_M
from worlds.house import House
from worlds.labels import STAIRS
from worlds.truth import room_at

_SMOOTHING_M = 0.24
_PITCH_SMOOTHING_M = 0.5
_GLANCE_EVERY_M = 4.0
"""Length of path for one cycle of glances, which is one glance to the left and one to the right [m]."""
_DIGITS = 7
"""Number of decimals to which angles are rounded. The last bits of trigonometric functions differ between processors, and
the pace must not depend on these bits."""
_LIFT_SLOPE = 2.0
"""Least ratio of climb to horizontal path in a lift. It is above the slope of single steps of stairs. LEXIS uses a lower
limit (`lexis.stairs`), because its poses are noisy."""
_AMBIGUOUS_RAD = 1e-3
"""A turn to the right counts as a turn to the left if it differs from 180 degrees by less than this angle [rad]. Otherwise,
rounding errors would decide the direction of a half turn."""


def view_along(
    house: House, points: Float64[np.ndarray, "k 3"], glance_rad: float, pitch_on_stairs: bool
) -> Float64[np.ndarray, "k 2"]:
    """Return the camera's yaw and pitch [rad] at each of the path's points, which are in W [m] and 1 cm apart.

    Yaw is unwrapped (without jumps by a full turn), and pitch is positive downwards. `glance_rad` is the largest angle of
    glances to the sides. Without `pitch_on_stairs`, pitch is 0.
    """
    step = np.diff(points, axis=0)
    level = np.linalg.norm(step[:, :2], axis=1)
    riding = np.abs(step[:, 2]) > _LIFT_SLOPE * level
    yaw = _smoothed(_yaw_ahead(step, riding) + _glances(house, points, glance_rad), _SMOOTHING_M)
    slope = -np.arctan2(step[:, 2], level).round(_DIGITS)
    slope = np.where(riding, 0.0, slope) if pitch_on_stairs else np.zeros(len(step))
    return np.column_stack([yaw, _smoothed(np.append(slope, slope[-1]), _PITCH_SMOOTHING_M)])


def _yaw_ahead(step: Float64[np.ndarray, "k 3"], riding: Bool[np.ndarray, "k"]) -> Float64[np.ndarray, "points"]:
    """Return the unwrapped direction of a path at each of its points [rad], given its steps and which of them are in a lift.

    During a ride in a lift, the direction turns evenly from that of the way in to that of the way out.
    """
    walked = np.flatnonzero(~riding)
    heading = np.arctan2(step[walked, 1], step[walked, 0]).round(_DIGITS)
    turn = np.diff(heading)
    turn = (turn + np.pi - _AMBIGUOUS_RAD) % (2 * np.pi) - np.pi + _AMBIGUOUS_RAD
    yaw = heading[0] + np.concatenate([[0.0], np.cumsum(turn), [turn.sum()]])
    return np.asarray(np.interp(np.arange(len(step) + 1), np.append(walked, len(step)), yaw))


def _smoothed(angle: Float64[np.ndarray, "k"], width_m: float) -> Float64[np.ndarray, "k"]:
    width = round(width_m / STEP_M)
    return np.asarray(uniform_filter1d(uniform_filter1d(angle, width, mode="nearest"), width, mode="nearest"))


def _glances(house: House, points: Float64[np.ndarray, "k 3"], amplitude_rad: float) -> Float64[np.ndarray, "k"]:
    """Return the yaw offset of glances to both sides in each room. It is zero where the path enters or leaves a room."""
    room, s = room_at(house, points), arc_length(points)
    bounds = [0, *(np.flatnonzero(np.diff(room)) + 1), len(room) - 1]
    offset = np.zeros(len(points))
    for i, j in pairwise(bounds):
        times = round((s[j] - s[i]) / _GLANCE_EVERY_M)
        if times > 0 and room[i] >= 0 and house.rooms[room[i]].label != STAIRS:
            offset[i:j] = amplitude_rad * np.sin(2 * np.pi * times * (s[i:j] - s[i]) / (s[j] - s[i]))
    return offset.round(_DIGITS)
