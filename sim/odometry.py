"""Simulated visual-inertial odometry: the estimate of the pose drifts in position and yaw, not in roll and pitch.

The error is a random walk over the way travelled, plus a scale error and a yaw bias that stay the same through a run;
gravity holds roll and pitch near the truth. Turning counts as way, so that the estimate drifts on the spot too.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.spatial.transform import Rotation

from lexis.se3 import between, is_rigid, rotation_angle, skew
from sim.errors import SimError

_METRES_PER_RADIAN = 0.3
_VARIANCE_FLOOR = 1e-10
"""Keeps covariances invertible where nothing moved or nothing drifts [rad², m²]."""


@dataclass(frozen=True)
class OdometryConfig:
    """How odometry drifts. Raises `SimError` for negative or non-finite values, or an overconfidence below 1."""

    position_walk_m: float = 0.0
    """Standard deviation of the position's random walk after 1 m, per axis [m/√m]."""
    yaw_walk_rad: float = 0.0
    """The same of yaw [rad/√m]."""
    scale_error: float = 0.0
    """Standard deviation over runs of the relative error in length."""
    yaw_bias_rad_m: float = 0.0
    """Standard deviation over runs of the yaw's steady drift [rad/m]."""
    tilt_rad: float = 0.0
    """Standard deviation of roll and of pitch, which are bounded by gravity [rad]."""
    tilt_correlation_m: float = 2.0
    """Way over which roll and pitch errors are forgotten [m]."""
    overconfidence: float = 1.0
    """Factor by which the reported covariance is too small; 1 is honest. Published filters reach 200 in orientation."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 <= value < np.inf:
                raise SimError(f"odometry: {name} is {value}; valid: not negative, finite")
        if self.overconfidence < 1.0 or self.tilt_correlation_m <= 0.0:
            raise SimError("odometry: overconfidence must be at least 1 and tilt_correlation_m above 0")


def _preset(walk_m: float, yaw_walk_deg: float, scale: float, yaw_bias_deg_m: float, tilt_deg: float) -> OdometryConfig:
    return OdometryConfig(walk_m, math.radians(yaw_walk_deg), scale, math.radians(yaw_bias_deg_m), math.radians(tilt_deg))


PRESETS = {
    "perfect": OdometryConfig(),
    "multicam": _preset(0.026, 0.20, 0.005, 0.02, 0.15),
    "mono": _preset(0.038, 0.34, 0.008, 0.03, 0.30),
    "degraded": _preset(0.043, 0.75, 0.010, 0.10, 0.50),
    "openvins": _preset(0.012, 0.16, 0.001, 0.003, 0.38),
}
"""Mean relative pose error after 8, 24 and 48 m of a tour, and ATE of about 100 m (averages over runs; a test holds them):

============  =================  =================  =================  ========
preset        8 m                24 m               48 m               ATE
============  =================  =================  =================  ========
multicam      0.14 m  0.65 deg   0.25 m  1.17 deg   0.38 m  1.85 deg   0.23 m
mono          0.21 m  1.14 deg   0.38 m  1.97 deg   0.56 m  3.05 deg   0.34 m
degraded      0.26 m  2.43 deg   0.54 m  4.67 deg   0.83 m  7.70 deg   0.53 m
openvins      0.07 m  0.85 deg   0.13 m  1.11 deg   0.20 m  1.42 deg   0.12 m
============  =================  =================  =================  ========

`multicam` is 1 % and 0.05 deg/m at 24 m, `degraded` 2 % and 0.2 deg/m: what visual-inertial odometry makes of a house with
little texture. `mono` turns 1/0.61 as far off as `multicam`, the published ratio. `openvins` is the curve published for
monocular OpenVINS in EuRoC's Vicon rooms (0.094 m 0.83 deg, 0.111 m 1.22 deg, 0.184 m 1.43 deg), a small room that it never
leaves: it drifts too little over a house to tell a good back end from a bad one, so no other preset is measured by it.
"""


@dataclass(frozen=True, eq=False)
class Odometry:
    """What the odometry reports at every stamp."""

    T_O_B: Float64[np.ndarray, "n 4 4"]
    """O and W coincide at the first pose."""
    increment_covariance: Float64[np.ndarray, "n 6 6"]
    """Of the error made since the previous pose, rotation first, on the right: `T = T_true @ Exp(xi)` [rad², m²]."""


def simulate_odometry(
    T_W_B: Float64[np.ndarray, "n 4 4"],
    stamps: Float64[np.ndarray, "n"],
    config: OdometryConfig,
    rng: np.random.Generator,
) -> Odometry:
    """Drift along true poses. The law of the drift depends on the way, not on the frame rate.

    Raises `SimError` where poses are not rigid, or stamps do not ascend.
    """
    _check(T_W_B, stamps)
    step = np.diff(T_W_B[:, :3, 3], axis=0)
    way = np.linalg.norm(step, axis=1) + _METRES_PER_RADIAN * rotation_angle(between(T_W_B[:-1], T_W_B[1:]))
    yaw_bias, scale = rng.normal(0.0, [config.yaw_bias_rad_m, config.scale_error])
    yaw = np.append(0.0, np.cumsum(config.yaw_walk_rad * np.sqrt(way) * rng.standard_normal(len(way)) + yaw_bias * way))
    noise = config.position_walk_m * np.sqrt(way)[:, None] * rng.standard_normal((len(way), 3))
    tilt = _tilt(way, config, rng)

    turned = Rotation.from_rotvec(yaw[:, None] * [0.0, 0.0, 1.0]).as_matrix()
    T_O_B = T_W_B.copy()
    T_O_B[:, :3, :3] = turned @ Rotation.from_rotvec(tilt).as_matrix() @ T_W_B[:, :3, :3]
    believed = (turned[:-1] @ ((1.0 + scale) * step + noise)[..., None])[..., 0]
    T_O_B[1:, :3, 3] += np.cumsum(believed - step, axis=0)
    return Odometry(T_O_B, _covariance(T_W_B[:, :3, :3], step, way, config))


def _tilt(way: Float64[np.ndarray, "m"], config: OdometryConfig, rng: np.random.Generator) -> Float64[np.ndarray, "m+1 3"]:
    """Rotation vectors about the world's x and y: a mean-reverting walk that starts at zero [rad]."""
    kept = np.exp(-way / config.tilt_correlation_m)
    fresh = config.tilt_rad * np.sqrt(1.0 - kept**2)[:, None] * rng.standard_normal((len(way), 2))
    tilt = np.zeros((len(way) + 1, 3))
    for i, (keep, new) in enumerate(zip(kept, fresh, strict=True)):
        tilt[i + 1, :2] = keep * tilt[i, :2] + new
    return tilt


def _covariance(
    R_W_B: Float64[np.ndarray, "n 3 3"],
    step: Float64[np.ndarray, "n-1 3"],
    way: Float64[np.ndarray, "n-1"],
    config: OdometryConfig,
) -> Float64[np.ndarray, "n 6 6"]:
    """Second moments of each increment's error, first in the world's axes, then in the body's."""
    horizontal = np.diag([1.0, 1.0, 0.0])
    kept = np.exp(-way / config.tilt_correlation_m)
    tilt = config.tilt_rad**2 * (1.0 - np.exp(-2.0 * np.append(0.0, np.cumsum(way)) / config.tilt_correlation_m))
    tilt_change = (1.0 - kept) ** 2 * tilt[:-1] + config.tilt_rad**2 * (1.0 - kept**2)
    lever = skew(step)

    covariance = np.zeros((len(R_W_B), 6, 6))
    covariance[1:, :3, :3] = tilt_change[:, None, None] * horizontal
    covariance[1:, 2, 2] = config.yaw_walk_rad**2 * way + (config.yaw_bias_rad_m * way) ** 2
    covariance[1:, 3:, 3:] = (config.position_walk_m**2 * way)[:, None, None] * np.eye(3)
    covariance[1:, 3:, 3:] += config.scale_error**2 * step[:, :, None] * step[:, None, :]
    covariance[1:, 3:, 3:] -= tilt[:-1, None, None] * (lever @ horizontal @ lever)  # tilted steps; lever is antisymmetric

    to_body = np.zeros_like(covariance)
    to_body[:, :3, :3] = to_body[:, 3:, 3:] = np.swapaxes(R_W_B, -1, -2)
    covariance = to_body @ covariance @ np.swapaxes(to_body, -1, -2)
    return covariance / config.overconfidence + _VARIANCE_FLOOR * np.eye(6)


def _check(T_W_B: Float64[np.ndarray, "n 4 4"], stamps: Float64[np.ndarray, "n"]) -> None:
    if len(T_W_B) == 0 or len(T_W_B) != len(stamps):
        raise SimError(f"odometry: {len(T_W_B)} poses and {len(stamps)} stamps; valid: as many of each, at least one")
    if not np.all(np.diff(stamps) > 0.0):
        raise SimError(f"odometry: stamps must ascend; they do not at index {int(np.argmin(np.diff(stamps) > 0.0)) + 1}")
    if not np.all(rigid := is_rigid(T_W_B)):
        raise SimError(f"odometry: pose {int(np.argmin(rigid))} is not a rigid motion")
