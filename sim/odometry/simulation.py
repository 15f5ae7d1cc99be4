"""Simulated visual-inertial odometry: the estimate of the pose drifts in position and yaw, not in roll and pitch.

Every increment of the motion, 100 or more in a second, has white noise and biases: those of translation and yaw drift
themselves (Gauss-Markov), the error in scale stays the same through a run. Gravity holds roll and pitch near the truth.
Noise and biases go with the way travelled, so that the law of the drift depends neither on the rate nor on the speed;
turning counts as way, so that the estimate drifts on the spot too.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int
from scipy.linalg import solve_banded
from scipy.spatial.transform import Rotation

from lexis.maths.se3 import between, is_rigid, rotation_angle, skew
from sim.errors import SimError
from sim.odometry.config import ODOMETRY_PRESETS, OdometryConfig
from sim.tours.tour import Tour

__all__ = ["ODOMETRY_PRESETS", "Odometry", "OdometryConfig", "simulate_odometry", "tour_odometry"]

METRES_PER_RADIAN = 0.3
_VARIANCE_FLOOR = 1e-10
"""Keeps covariances invertible where nothing moved or nothing drifts [rad², m²]."""


@dataclass(frozen=True, eq=False)
class Odometry:
    """What the odometry reports at every stamp."""

    T_O_B: Float64[np.ndarray, "n 4 4"]
    """O and W coincide at the first pose."""
    increment_covariance: Float64[np.ndarray, "n 6 6"]
    """Of the error made since the previous pose, rotation first, on the right: `T = T_true @ Exp(xi)` [rad², m²]."""


def tour_odometry(tour: Tour, config: OdometryConfig, rng: np.random.Generator) -> Odometry:
    """Drift along a tour, integrated at `config.rate_hz` or more, reported at the tour's frames."""
    pieces = np.ceil(np.diff(tour.stamps) * config.rate_hz - 1e-6).astype(int)
    frames = np.append(0, np.cumsum(pieces))
    stamps = np.interp(np.arange(frames[-1] + 1), frames, tour.stamps)
    return simulate_odometry(tour.motion.poses_at(stamps, tour.eye_height_m), stamps, config, rng, frames)


def simulate_odometry(
    T_W_B: Float64[np.ndarray, "m 4 4"],
    stamps: Float64[np.ndarray, "m"],
    config: OdometryConfig,
    rng: np.random.Generator,
    reported: Int[np.ndarray, "n"] | None = None,
) -> Odometry:
    """Drift along true poses, one increment from each to the next.

    `reported` are the indices at which the odometry is read, ascending from 0; None: all. Raises `SimError` where poses
    are not rigid, or stamps or indices do not ascend.
    """
    reported = np.arange(len(T_W_B)) if reported is None else reported
    _check(T_W_B, stamps, reported)
    step = np.diff(T_W_B[:, :3, 3], axis=0)
    way = np.linalg.norm(step, axis=1) + METRES_PER_RADIAN * rotation_angle(between(T_W_B[:-1], T_W_B[1:]))
    scale = rng.normal(0.0, config.scale_error)
    yaw, translation_error = _drift(T_W_B[:-1, :3, :3], way, config, rng)
    tilt = np.zeros((len(T_W_B), 3))
    tilt[:, :2] = config.tilt_rad * _gauss_markov(np.zeros(2), way, config.tilt_correlation_m, rng)

    turned = Rotation.from_rotvec(yaw[:, None] * [0.0, 0.0, 1.0]).as_matrix()
    believed = (turned[:-1] @ ((1.0 + scale) * step + translation_error)[..., None])[..., 0]
    position_error = np.append(np.zeros((1, 3)), np.cumsum(believed - step, axis=0), axis=0)

    T_O_B = T_W_B[reported]
    tilted = Rotation.from_rotvec(tilt[reported]).as_matrix()
    T_O_B[:, :3, :3] = turned[reported] @ tilted @ T_O_B[:, :3, :3]
    T_O_B[:, :3, 3] += position_error[reported]
    between_reports = np.diff(np.append(0.0, np.cumsum(way))[reported])
    return Odometry(T_O_B, _covariance(T_W_B[reported], between_reports, config))


def _drift(
    R_W_B: Float64[np.ndarray, "m 3 3"], way: Float64[np.ndarray, "m"], config: OdometryConfig, rng: np.random.Generator
) -> tuple[Float64[np.ndarray, "m+1"], Float64[np.ndarray, "m 3"]]:
    """Yaw errors at all poses [rad], and the error of each step in the world's axes, scale and yaw apart [m]."""
    bias = _gauss_markov(rng.standard_normal(4), way, config.bias_correlation_m, rng)[:-1]
    root = np.sqrt(way)
    yaw = config.yaw_walk_rad * root * rng.standard_normal(len(way)) + config.yaw_bias_rad_m * bias[:, 0] * way
    noise = config.position_walk_m * root[:, None] * rng.standard_normal((len(way), 3))
    biased = config.velocity_bias * way[:, None] * np.einsum("nij,nj->ni", R_W_B, bias[:, 1:])
    return np.append(0.0, np.cumsum(yaw)), noise + biased


def _gauss_markov(
    start: Float64[np.ndarray, "k"], way: Float64[np.ndarray, "m"], correlation_m: float, rng: np.random.Generator
) -> Float64[np.ndarray, "m+1 k"]:
    """Independent first-order Gauss-Markov processes of unit variance, from `start`, exact for steps of any length."""
    kept = np.exp(-way / correlation_m)
    fresh = np.sqrt(1.0 - kept**2)[:, None] * rng.standard_normal((len(way), len(start)))
    # x[i + 1] - kept[i] x[i] = fresh[i] for all i at once.
    band = np.stack([np.ones(len(way) + 1), np.append(-kept, 0.0)])
    return np.asarray(solve_banded((1, 0), band, np.concatenate([start[None], fresh])))


def _covariance(
    T_W_B: Float64[np.ndarray, "n 4 4"], way: Float64[np.ndarray, "n-1"], config: OdometryConfig
) -> Float64[np.ndarray, "n 6 6"]:
    """Second moments of each increment's error, first in the world's axes, then in the body's."""
    step = np.diff(T_W_B[:, :3, 3], axis=0)
    horizontal = np.diag([1.0, 1.0, 0.0])
    kept = np.exp(-way / config.tilt_correlation_m)
    tilt = config.tilt_rad**2 * (1.0 - np.exp(-2.0 * np.append(0.0, np.cumsum(way)) / config.tilt_correlation_m))
    tilt_change = (1.0 - kept) ** 2 * tilt[:-1] + config.tilt_rad**2 * (1.0 - kept**2)
    lever = skew(step)

    covariance = np.zeros((len(T_W_B), 6, 6))
    covariance[1:, :3, :3] = tilt_change[:, None, None] * horizontal
    covariance[1:, 2, 2] = config.yaw_walk_rad**2 * way + (config.yaw_bias_rad_m * way) ** 2
    isotropic = config.position_walk_m**2 * way + (config.velocity_bias * way) ** 2
    covariance[1:, 3:, 3:] = isotropic[:, None, None] * np.eye(3)
    covariance[1:, 3:, 3:] += config.scale_error**2 * step[:, :, None] * step[:, None, :]
    covariance[1:, 3:, 3:] -= tilt[:-1, None, None] * (lever @ horizontal @ lever)  # tilted steps; lever is antisymmetric

    to_body = np.zeros_like(covariance)
    to_body[:, :3, :3] = to_body[:, 3:, 3:] = np.swapaxes(T_W_B[:, :3, :3], -1, -2)
    covariance = to_body @ covariance @ np.swapaxes(to_body, -1, -2)
    return covariance / config.overconfidence + _VARIANCE_FLOOR * np.eye(6)


def _check(T_W_B: Float64[np.ndarray, "m 4 4"], stamps: Float64[np.ndarray, "m"], reported: Int[np.ndarray, "n"]) -> None:
    if len(T_W_B) == 0 or len(T_W_B) != len(stamps):
        raise SimError(f"odometry: {len(T_W_B)} poses and {len(stamps)} stamps; valid: as many of each, at least one")
    if not np.all(np.diff(stamps) > 0.0):
        raise SimError(f"odometry: stamps must ascend; they do not at index {int(np.argmin(np.diff(stamps) > 0.0)) + 1}")
    if not np.all(rigid := is_rigid(T_W_B)):
        raise SimError(f"odometry: pose {int(np.argmin(rigid))} is not a rigid motion")
    if len(reported) == 0 or reported[0] != 0 or reported[-1] >= len(T_W_B) or not np.all(np.diff(reported) > 0):
        raise SimError(f"odometry: poses are reported from 0 up, ascending, below {len(T_W_B)}; these are {reported}")
