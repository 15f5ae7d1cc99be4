"""`paced`: turns a path into a motion over time. It is as fast as the walker's limits allow, and at rest at both ends.

1. Find an upper bound of the speed at each point of the path, from the path's curvature and from how fast the view turns.
2. Compute the fastest speed profile that keeps these bounds and the limit of tangential acceleration. Sample the path at
   equal steps of time; the samples are the control points of a B-spline.
3. Check the limits at the control points. Where a limit is exceeded, lower the speed bounds around these points, and go
   back to 2.
4. Slow down the whole motion as much as is still necessary for the limits to hold exactly.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from sim.tours.motion import DEGREE, Motion
from sim.tours.sway import Sway

_KNOT_S = 0.05
"""Time between control points, before the whole motion is slowed down [s]."""
_TANGENTIAL, _LATERAL = 0.7, 0.7
"""Shares of the acceleration limit for changes of speed and for curves. Both together keep the limit: 0.7² + 0.7² < 1."""
_ROUNDS = 25
_SLOWER = 0.93
"""Additional factor on speeds that are lowered because a limit is exceeded, so that few rounds are enough."""
_ROUNDING = 1e-9
"""Largest excess over a limit, as a share of the limit, that is ignored as a rounding error."""
_GAIT_S = 0.6
"""Duration over which the speed is averaged, before the sway is scaled by this speed [s]."""
_DIGITS = 9
"""Number of decimals to which the share of sway is rounded. The last bits of sums by BLAS differ between processors."""


@dataclass(frozen=True)
class Limits:
    """Limits of speed, acceleration and turning that the motion of a walk keeps at all times."""

    speed_m_s: float = 0.7
    acceleration_m_s2: float = 1.5
    turn_rate_rad_s: float = 1.2
    """Limit of the norm of yaw rate and pitch rate [rad/s]."""
    turn_acceleration_rad_s2: float = 4.0


def paced(
    points: Float64[np.ndarray, "k 3"],
    view: Float64[np.ndarray, "k 2"],
    limits: Limits,
    sway: Sway | None,
) -> Motion:
    """Return the motion along evenly spaced points in W [m], with the yaw and pitch [rad] that `view` gives at each point.

    The motion without sway keeps the limits exactly. Sway is added afterwards, and may exceed them.
    """
    # The largest step is the true one: points are closer together where the path turns back.
    step_m = float(_norm(np.diff(points, axis=0)).max())
    s = step_m * np.arange(len(points))
    squared = _squared_limits(points, view, step_m, limits)
    columns = np.column_stack([points, view])
    controls, excess = columns[:1], 1.0
    for _ in range(_ROUNDS):
        at = _arc_at_times(s, squared, _TANGENTIAL * limits.acceleration_m_s2)
        controls = np.stack([np.interp(at, s, column) for column in columns.T], axis=-1)
        ratio = _strain(controls, limits)
        excess = float(ratio.max(initial=1.0))
        if excess <= 1.0 + _ROUNDING:
            break
        squared = _slowed(squared, s, at, ratio)
    still = [(DEGREE - 1, DEGREE - 1), (0, 0)]
    gait = _gait(controls[:, :3], limits.speed_m_s)
    controls = np.pad(np.column_stack([controls, gait]), still, mode="edge")
    return Motion(controls, _KNOT_S * excess, sway)


def _squared_limits(
    points: Float64[np.ndarray, "k 3"], view: Float64[np.ndarray, "k 2"], step_m: float, limits: Limits
) -> Float64[np.ndarray, "k"]:
    """Return the square of the speed that the path's curvature and the turning view allow at each point; 0 at both ends."""
    turn = np.maximum(_norm(np.diff(view, axis=0)) / step_m, 1e-9)
    bend = np.maximum(_norm(np.diff(points, 2, axis=0)) / step_m**2, 1e-9)
    by_turn = np.minimum((limits.turn_rate_rad_s / turn) ** 2, limits.speed_m_s**2)
    squared = np.zeros(len(points))
    squared[1:-1] = np.minimum(np.minimum(by_turn[:-1], by_turn[1:]), _LATERAL * limits.acceleration_m_s2 / bend)
    return squared


def _arc_at_times(
    s: Float64[np.ndarray, "k"], squared: Float64[np.ndarray, "k"], acceleration_m_s2: float
) -> Float64[np.ndarray, "_"]:
    """Return the arc length [m] that the fastest speed profile within the bounds reaches at each time step.

    `s` are arc lengths [m], and `squared` the bounds of the squared speed there. With the acceleration a, v² changes by at
    most 2 a ds over a distance ds. One pass forwards and one pass backwards over the bounds therefore give the profile.
    """
    gain = 2 * acceleration_m_s2 * s
    forwards = gain + np.minimum.accumulate(squared - gain)
    v = np.sqrt(np.minimum(forwards, np.minimum.accumulate((squared + gain)[::-1])[::-1] - gain).clip(0.0))
    ds, mean = np.diff(s), np.maximum((v[1:] + v[:-1]) / 2, 1e-6)
    t = np.append(0.0, np.cumsum(ds / mean))
    times = np.append(np.arange(0.0, t[-1], _KNOT_S), t[-1])
    i = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(ds) - 1)
    tau, span = times - t[i], t[i + 1] - t[i]
    return np.asarray(np.clip(s[i] + v[i] * tau + (v[i + 1] - v[i]) / (2 * span) * tau**2, s[i], s[i + 1]))


def _strain(controls: Float64[np.ndarray, "n 5"], limits: Limits) -> Float64[np.ndarray, "n"]:
    """Return, for each control point, the factor by which the motion would have to take longer there to keep all limits.

    A motion that takes r times as long has rates divided by r and accelerations divided by r². For an acceleration, the
    factor is therefore the square root of its ratio to the limit.
    """
    still = np.pad(controls, [(1, 1), (0, 0)], mode="edge")
    rate = np.diff(still, axis=0) / _KNOT_S
    change = np.diff(rate, axis=0) / _KNOT_S
    first = np.maximum(_norm(rate[:, :3]) / limits.speed_m_s, _norm(rate[:, 3:]) / limits.turn_rate_rad_s)
    second = np.maximum(
        _norm(change[:, :3]) / limits.acceleration_m_s2, _norm(change[:, 3:]) / limits.turn_acceleration_rad_s2
    )
    return np.maximum(np.maximum(first[1:], first[:-1]), np.sqrt(second))


def _norm(v: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "n"]:
    return np.asarray(np.sqrt(sum(column * column for column in v.T)))  # faster than norm, which sums rows one by one


def _slowed(
    squared: Float64[np.ndarray, "k"],
    s: Float64[np.ndarray, "k"],
    at: Float64[np.ndarray, "n"],
    ratio: Float64[np.ndarray, "n"],
) -> Float64[np.ndarray, "k"]:
    """Lower the bounds `squared` of the squared speed around all control points at which a limit is exceeded."""
    slower = squared.copy()
    for k in np.flatnonzero(ratio > 1.0 + _ROUNDING).tolist():
        low, high = np.searchsorted(s, [at[max(k - 2, 0)], at[min(k + 2, len(at) - 1)]]).tolist()
        slower[low : high + 1] = np.minimum(slower[low : high + 1], squared[low : high + 1] * (_SLOWER / ratio[k]) ** 2)
    return slower


def _gait(positions: Float64[np.ndarray, "n 3"], speed_m_s: float) -> Float64[np.ndarray, "n"]:
    """Return the share of the full sway at each control point, which is 0 at both ends.

    It is the ratio of the speed, averaged over `_GAIT_S`, to the largest speed.
    """
    share = np.append(_norm(np.diff(positions, axis=0)), 0.0) / (_KNOT_S * speed_m_s)
    width = round(_GAIT_S / _KNOT_S) | 1
    gait = np.convolve(np.pad(share, width // 2), np.full(width, 1 / width), mode="valid")
    ramp = np.minimum(np.arange(len(gait)), np.arange(len(gait))[::-1]) / width
    return np.asarray((gait * np.clip(ramp, 0.0, 1.0)).round(_DIGITS))
