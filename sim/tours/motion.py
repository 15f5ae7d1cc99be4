"""`Motion`: the trajectory of a body as a B-spline over time, plus sway, with exact derivatives at any time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64
from scipy.interpolate import BSpline

from sim.tours.sway import Sway

DEGREE = 5
"""Degree of the spline. The spline has four continuous derivatives, one more than are needed for a continuous jerk."""
_X, _YAW, _PITCH, _GAIT = slice(0, 3), 3, 4, 5


@dataclass(frozen=True, eq=False)
class Motion:
    """A body's trajectory. The body rests in the first pose before the start, and in the last pose after the end.

    Without sway, the trajectory is a uniform B-spline. Each derivative of the spline is a weighted mean of the divided
    differences of the control points. If these differences are within a limit, the derivative is within it at all times.
    """

    controls: Float64[np.ndarray, "k 6"]
    """Control points: x, y, z on the walked surface in W [m], yaw and pitch [rad], share of the full sway in [0, 1]."""
    knot_s: float
    """Time between the knots of the spline [s]."""
    sway: Sway | None = None

    @property
    def duration_s(self) -> float:
        """Duration of the trajectory [s]."""
        return float((len(self.controls) - DEGREE) * self.knot_s)

    @cached_property
    def _splines(self) -> tuple[BSpline, BSpline, BSpline]:
        knots = self.knot_s * np.arange(-DEGREE, len(self.controls) + 1)
        spline = BSpline(knots, self.controls, DEGREE)
        return spline, spline.derivative(1), spline.derivative(2)

    def _walk(self, t: Float64[np.ndarray, "n"], derivative: int) -> Float64[np.ndarray, "n 6"]:
        return np.asarray(self._splines[derivative](np.clip(t, 0.0, self.duration_s)))

    def _swing(self, t: Float64[np.ndarray, "n"], derivative: int) -> Float64[np.ndarray, "n 6"]:
        """Return the sway at times `t` [s], or its first or second `derivative`, times the share of sway at these times.

        The columns are x, y, z in the level body frame [m] and roll, pitch, yaw [rad]. The derivatives of the product follow
        Leibniz's rule, which has binomial coefficients.
        """
        if self.sway is None:
            return np.zeros((len(t), 6))
        gait = [self._walk(t, k)[:, _GAIT, None] for k in range(derivative + 1)]
        swing = [self.sway.at(t, k) for k in range(derivative + 1)]
        binomial = ((1,), (1, 1), (1, 2, 1))[derivative]
        return np.asarray(sum(b * gait[k] * swing[derivative - k] for k, b in enumerate(binomial)))

    def position(self, t: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 3"]:
        """Return the positions in W [m] at times `t` [s], without the height of the body above the walked surface.

        They are points of the walked surface, displaced by the sway. `poses_at` adds the height `height_m`.
        """
        return _position(self._walk(t, 0), self._swing(t, 0))

    def velocity(self, t: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 3"]:
        """Return the velocity of the body in W [m/s] at times `t` [s]."""
        walk, (d, d1) = self._walk(t, 1), (self._swing(t, k)[:, _X] for k in (0, 1))
        swing = d1 + walk[:, _YAW, None] * _across(d)
        return np.asarray(walk[:, _X] + _turned(swing, self._walk(t, 0)[:, _YAW]))

    def acceleration(self, t: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 3"]:
        """Return the acceleration of the body in W [m/s²] at times `t` [s]."""
        d, d1, d2 = (self._swing(t, k)[:, _X] for k in range(3))
        rate, change = self._walk(t, 1)[:, _YAW, None], self._walk(t, 2)[:, _YAW, None]
        swing = d2 + 2 * rate * _across(d1) + change * _across(d) + rate**2 * _across(_across(d))
        return np.asarray(self._walk(t, 2)[:, _X] + _turned(swing, self._walk(t, 0)[:, _YAW]))

    def yaw(self, t: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n"]:
        """Return the yaw [rad] at times `t` [s], unwrapped: it has no jumps by a full turn."""
        return self.attitude(t)[:, 2]

    def yaw_rate(self, t: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n"]:
        """Return the yaw rate [rad/s] at times `t` [s]."""
        return self.attitude(t, 1)[:, 2]

    def attitude(self, t: Float64[np.ndarray, "n"], derivative: int = 0) -> Float64[np.ndarray, "n 3"]:
        """Return roll, pitch and yaw [rad] at times `t` [s], or their first or second `derivative` [rad/s, rad/s²].

        `R_W_B = Rz(yaw) Ry(pitch) Rx(roll)`.
        """
        return _angles(self._walk(t, derivative), self._swing(t, derivative))

    def angular_velocity(self, t: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 3"]:
        """Return the angular velocity of B relative to W, expressed in B [rad/s], at times `t` [s]."""
        (roll, pitch, _), (roll1, pitch1, yaw1) = self.attitude(t).T, self.attitude(t, 1).T
        about_y = pitch1 * np.cos(roll) + yaw1 * np.sin(roll) * np.cos(pitch)
        about_z = yaw1 * np.cos(roll) * np.cos(pitch) - pitch1 * np.sin(roll)
        return np.stack([roll1 - yaw1 * np.sin(pitch), about_y, about_z], axis=-1)

    def rotation(self, t: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 3 3"]:
        """Return the rotations `R_W_B` at times `t` [s]."""
        return _rotation(self.attitude(t))

    def poses_at(self, stamps: Float64[np.ndarray, "n"], height_m: float) -> Float64[np.ndarray, "n 4 4"]:
        """Return the body's poses `T_W_B` (x forward, y left, z up) at times [s], `height_m` above the walked surface."""
        T_W_B = np.tile(np.eye(4), (len(stamps), 1, 1))
        walk, swing = self._walk(stamps, 0), self._swing(stamps, 0)
        T_W_B[:, :3, :3] = _rotation(_angles(walk, swing))
        T_W_B[:, :3, 3] = _position(walk, swing) + [0.0, 0.0, height_m]
        return T_W_B


def _position(walk: Float64[np.ndarray, "n 6"], swing: Float64[np.ndarray, "n 6"]) -> Float64[np.ndarray, "n 3"]:
    return np.asarray(walk[:, _X] + _turned(swing[:, _X], walk[:, _YAW]))


def _angles(walk: Float64[np.ndarray, "n 6"], swing: Float64[np.ndarray, "n 6"]) -> Float64[np.ndarray, "n 3"]:
    """Return roll, pitch and yaw of a walk with its sway, or their derivatives."""
    angles = swing[:, 3:].copy()
    angles[:, 1] += walk[:, _PITCH]
    angles[:, 2] += walk[:, _YAW]
    return angles


def _rotation(attitude: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 3 3"]:
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude.T), np.sin(attitude.T)
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _turned(v: Float64[np.ndarray, "n 3"], yaw: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 3"]:
    """Rotate vectors from the level body frame into W."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.stack([cos * v[:, 0] - sin * v[:, 1], sin * v[:, 0] + cos * v[:, 1], v[:, 2]], axis=-1)


def _across(v: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 3"]:
    """Return `z × v`: the derivative of `v`, rotated about z, with respect to the angle of rotation."""
    return np.stack([-v[:, 1], v[:, 0], np.zeros(len(v))], axis=-1)
