"""`paced`: the time that a walker takes along a path: as fast as its limits allow, at rest at both ends."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from sim.motion import DEGREE, Motion
from sim.sway import Sway
from sim.tours.smooth import arc_length

_KNOT_S = 0.05
_TANGENTIAL, _LATERAL = 0.7, 0.7
"""Shares of the acceleration's limit for changing speed and for turning: squares add up to less than one."""
_ROUNDS = 25
_SLOWER = 0.93
_GAIT_S = 0.6
"""Over which the sway follows the speed."""


@dataclass(frozen=True)
class Limits:
    """What the walker keeps at all times."""

    speed_m_s: float = 0.7
    acceleration_m_s2: float = 1.5
    turn_rate_rad_s: float = 1.2
    """Of yaw, and of pitch with it."""
    turn_acceleration_rad_s2: float = 4.0


def paced(
    points: Float64[np.ndarray, "k 3"],
    view: Float64[np.ndarray, "k 2"],
    limits: Limits,
    sway: Sway | None = None,
) -> Motion:
    """Walk along evenly spaced points, looking by yaw and pitch as `view` has it at each [rad].

    The limits hold exactly, of the walk without its sway.
    """
    s = arc_length(points)
    squared = _squared_limits(points, view, s, limits)
    columns = np.column_stack([points, view])
    controls, excess = columns[:1], 1.0
    for _ in range(_ROUNDS):
        at = _way_at_times(s, squared, _TANGENTIAL * limits.acceleration_m_s2)
        controls = np.stack([np.interp(at, s, column) for column in columns.T], axis=-1)
        ratio = _strain(controls, limits)
        excess = float(ratio.max(initial=1.0))
        if excess <= 1.0:
            break
        squared = _slowed(squared, s, at, ratio)
    still = [(DEGREE - 1, DEGREE - 1), (0, 0)]
    gait = _gait(controls[:, :3], limits.speed_m_s)
    controls = np.pad(np.column_stack([controls, gait]), still, mode="edge")
    return Motion(controls, _KNOT_S * excess, sway)


def _squared_limits(
    points: Float64[np.ndarray, "k 3"], view: Float64[np.ndarray, "k 2"], s: Float64[np.ndarray, "k"], limits: Limits
) -> Float64[np.ndarray, "k"]:
    """Square of the speed that the bend of the way and the turn of the view allow at each point; 0 at the ends."""
    ds = np.maximum(np.diff(s), 1e-9)
    turn = np.linalg.norm(np.diff(view, axis=0), axis=1) / ds
    squared = np.full(len(points), limits.speed_m_s**2)
    by_turn = (limits.turn_rate_rad_s / np.maximum(turn, 1e-9)) ** 2
    squared[1:] = np.minimum(squared[1:], by_turn)
    squared[:-1] = np.minimum(squared[:-1], by_turn)
    bend = np.linalg.norm(np.diff(np.diff(points, axis=0) / ds[:, None], axis=0), axis=1) / ds[1:]
    by_bend = _LATERAL * limits.acceleration_m_s2 / np.maximum(bend, 1e-9)
    squared[1:-1] = np.minimum(squared[1:-1], by_bend)
    squared[[0, -1]] = 0.0
    return squared


def _way_at_times(
    s: Float64[np.ndarray, "k"], squared: Float64[np.ndarray, "k"], acceleration_m_s2: float
) -> Float64[np.ndarray, "_"]:
    """Way gone at every knot of time, for the fastest pace that changes its speed no faster than allowed."""
    gain = 2 * acceleration_m_s2 * s
    forwards = gain + np.minimum.accumulate(squared - gain)
    v = np.sqrt(np.minimum(forwards, np.minimum.accumulate((squared + gain)[::-1])[::-1] - gain).clip(0.0))
    ds, mean = np.diff(s), np.maximum((v[1:] + v[:-1]) / 2, 1e-6)
    t = np.append(0.0, np.cumsum(ds / mean))
    times = np.append(np.arange(0.0, t[-1], _KNOT_S), t[-1])
    i = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(ds) - 1)
    tau, span = times - t[i], t[i + 1] - t[i]
    return np.clip(s[i] + v[i] * tau + (v[i + 1] - v[i]) / (2 * span) * tau**2, s[i], s[i + 1])


def _strain(controls: Float64[np.ndarray, "n 5"], limits: Limits) -> Float64[np.ndarray, "n"]:
    """By how much a motion would have to be slowed down at each control point to keep its limits."""
    still = np.pad(controls, [(1, 1), (0, 0)], mode="edge")
    rate = np.diff(still, axis=0) / _KNOT_S
    change = np.diff(rate, axis=0) / _KNOT_S
    first = np.maximum(_norm(rate[:, :3]) / limits.speed_m_s, _norm(rate[:, 3:]) / limits.turn_rate_rad_s)
    second = np.maximum(
        _norm(change[:, :3]) / limits.acceleration_m_s2, _norm(change[:, 3:]) / limits.turn_acceleration_rad_s2
    )
    return np.maximum(np.maximum(first[1:], first[:-1]), np.sqrt(second))


def _norm(v: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "n"]:
    return np.asarray(np.linalg.norm(v, axis=1))


def _slowed(
    squared: Float64[np.ndarray, "k"], s: Float64[np.ndarray, "k"], at: Float64[np.ndarray, "n"], ratio: Float64[np.ndarray, "n"]
) -> Float64[np.ndarray, "k"]:
    """Lower speeds around all that was too fast."""
    slower = squared.copy()
    for k in np.flatnonzero(ratio > 1.0):
        low, high = np.searchsorted(s, at[[max(k - 2, 0), min(k + 2, len(at) - 1)]])
        slower[low : high + 1] = np.minimum(slower[low : high + 1], squared[low : high + 1] * (_SLOWER / ratio[k]) ** 2)
    return slower


def _gait(positions: Float64[np.ndarray, "n 3"], speed_m_s: float) -> Float64[np.ndarray, "n"]:
    """Share of the full speed, averaged over a moment; none at the ends."""
    share = np.append(_norm(np.diff(positions, axis=0)), 0.0) / (_KNOT_S * speed_m_s)
    width = round(_GAIT_S / _KNOT_S) | 1
    gait = np.convolve(share, np.full(width, 1 / width), mode="same")
    ramp = np.minimum(np.arange(len(gait)), np.arange(len(gait))[::-1]) / width
    return np.asarray(gait * np.clip(ramp, 0.0, 1.0))
