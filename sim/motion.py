"""From a line on the floor to a motion: corners rounded without touching anything, constant speed, bounded turn rate."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.ndimage import uniform_filter1d

from worlds.walkable import Walkable

_STEP_M = 0.02
_ROUNDS = 4
_MAX_CUT_M = 0.4
_HEADING_SMOOTHING_M = 0.24


@dataclass(frozen=True, eq=False)
class Motion:
    """Where an upright body is at any time: linear between knots."""

    times: Float64[np.ndarray, "k"]
    """Ascending from 0 [s]."""
    positions: Float64[np.ndarray, "k 3"]
    """On the walked surface, in W [m]."""
    yaw: Float64[np.ndarray, "k"]
    """Unwrapped [rad]."""

    @property
    def duration_s(self) -> float:
        """[s]."""
        return float(self.times[-1])

    def poses_at(self, stamps: Float64[np.ndarray, "n"], height_m: float) -> Float64[np.ndarray, "n 4 4"]:
        """Poses `T_W_B` of a level body frame (x forward, z up) carried `height_m` above the surface."""
        yaw = np.interp(stamps, self.times, self.yaw)
        T_W_B = np.tile(np.eye(4), (len(stamps), 1, 1))
        T_W_B[:, 0, 0] = T_W_B[:, 1, 1] = np.cos(yaw)
        T_W_B[:, 1, 0] = np.sin(yaw)
        T_W_B[:, 0, 1] = -np.sin(yaw)
        T_W_B[:, :3, 3] = np.stack([np.interp(stamps, self.times, axis) for axis in self.positions.T], axis=-1)
        T_W_B[:, 2, 3] += height_m
        return T_W_B


def round_corners(line: Float64[np.ndarray, "k 3"], walkable: Walkable) -> Float64[np.ndarray, "_ 3"]:
    """Cut the corners of a walkable line, again and again, where the cut keeps the body's radius from everything solid."""
    for _ in range(_ROUNDS):
        line = line[np.append(True, np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-6)]
        step = np.diff(line, axis=0)
        length = np.linalg.norm(step, axis=1, keepdims=True)
        cut = np.minimum(0.25 * length, _MAX_CUT_M) * step / length
        before, after = line[1:-1] - cut[:-1], line[1:-1] + cut[1:]
        free = walkable.solids.clear(before, after, walkable.radius_m)[:, None]
        corners = np.stack([np.where(free, before, line[1:-1]), np.where(free, after, line[1:-1])], axis=1)
        line = np.concatenate([line[:1], corners.reshape(-1, 3), line[-1:]])
    return line


def resample(line: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "_ 3"]:
    """Points every 2 cm along a line, corners included, none twice."""
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.union1d(np.arange(0.0, s[-1], _STEP_M), s)
    at = at[np.append(True, np.diff(at) > 1e-6)]
    return np.stack([np.interp(at, s, axis) for axis in line.T], axis=-1)


def heading(points: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "k"]:
    """Direction of motion along a resampled line, unwrapped, smoothed over a quarter of a metre [rad]."""
    step = np.diff(points, axis=0)
    yaw = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    width = round(_HEADING_SMOOTHING_M / _STEP_M)
    return uniform_filter1d(uniform_filter1d(np.append(yaw, yaw[-1]), width, mode="nearest"), width, mode="nearest")


def timed(
    points: Float64[np.ndarray, "k 3"], yaw: Float64[np.ndarray, "k"], speed_m_s: float, turn_rate_rad_s: float
) -> Motion:
    """Go through points at constant speed, slower where the turn rate would exceed its bound."""
    driving = np.linalg.norm(np.diff(points, axis=0), axis=1) / speed_m_s
    turning = np.abs(np.diff(yaw)) / turn_rate_rad_s
    return Motion(np.append(0.0, np.cumsum(np.maximum(driving, turning))), points, yaw)
