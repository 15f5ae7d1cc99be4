"""Simulated visual-inertial odometry, whose pose estimate drifts in position and yaw but not in roll and pitch.

Errors are added to each increment of the motion (`OdometryConfig.rate_hz` or more in a second):

- Translation and yaw have white noise and slowly varying biases, which are first-order Gauss-Markov processes.
- The scale has a relative error that is constant through a run.
- Roll and pitch have a bounded error, because gravity makes them observable.

Noise and biases grow with the distance travelled. The statistics of the drift therefore depend neither on the rate of the
increments nor on the speed. Rotation counts as distance, too, so that the estimate also drifts while turning on the spot.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int
from scipy.linalg import solve_banded
from scipy.spatial.transform import Rotation

from lexis.maths.se3 import is_rigid, rotation_angle, skew, upright
from sim.errors import SimError
from sim.odometry.config import OdometryConfig
from sim.tours.tour import Tour

METRES_PER_RADIAN = 0.3
"""Distance that makes errors grow as much as a rotation by one radian does [m/rad]."""
ORIGIN_M = (10.0, 10.0, 3.0)
"""Greatest distance of the origin of a random frame from that of the earlier frame, along x, y and z [m]."""
_VARIANCE_FLOOR = 1e-10
"""Variance that is added to keep covariances invertible where the body stands still or does not drift [rad², m²]."""


@dataclass(frozen=True, eq=False)
class Odometry:
    """Output of the odometry at each reported stamp."""

    T_O_B: Float64[np.ndarray, "n 4 4"]
    """Estimated poses in the odometry frame O, whose z axis points up."""
    increment_covariance: Float64[np.ndarray, "n 6 6"]
    """Covariance of the error `xi` of the motion since the previous pose, rotation first [rad², m²].

    The error is on the right: `T = T_true @ Exp(xi)`.
    """

    def in_random_frame(self, rng: np.random.Generator) -> "Odometry":
        """Return this odometry in another frame O, whose origin and heading are random and whose z axis points up.

        A real odometry knows neither the frame of the building's plan nor the heights of its floors. The covariances stay as
        they are, because they are those of motions in the axes of B.
        """
        T_new_old = upright(rng.uniform(-np.pi, np.pi), rng.uniform(-1.0, 1.0, 3) * ORIGIN_M)
        return replace(self, T_O_B=T_new_old @ self.T_O_B)


def tour_odometry(tour: Tour, config: OdometryConfig, rng: np.random.Generator) -> Odometry:
    """Simulate odometry along a tour, with O equal to W at the first pose; every frame is reported.

    The odometry adds up at least `config.rate_hz` increments in a second.
    """
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
    """Simulate odometry along true poses, with one increment between consecutive poses. O equals W at the first pose.

    `reported` has the indices of the poses to report, in ascending order from 0; None stands for all poses. Raises
    `SimError` if poses are not rigid, or if stamps or indices do not ascend.
    """
    reported = np.arange(len(T_W_B)) if reported is None else reported
    _check(T_W_B, stamps, reported)
    step = np.diff(T_W_B[:, :3, 3], axis=0)
    turn = np.swapaxes(T_W_B[:-1, :3, :3], 1, 2) @ T_W_B[1:, :3, :3]
    moved = np.linalg.norm(step, axis=1) + METRES_PER_RADIAN * rotation_angle(turn)
    scale = rng.normal(0.0, config.scale_error)
    yaw, translation_error = _drift(T_W_B[:-1, :3, :3], moved, config, rng)
    tilt = np.zeros((len(T_W_B), 3))
    tilt[:, :2] = config.tilt_rad * _gauss_markov(np.zeros(2), moved, config.tilt_correlation_m, rng)

    turned = Rotation.from_rotvec(yaw[:, None] * [0.0, 0.0, 1.0]).as_matrix()
    believed = (turned[:-1] @ ((1.0 + scale) * step + translation_error)[..., None])[..., 0]
    position_error = np.append(np.zeros((1, 3)), np.cumsum(believed - step, axis=0), axis=0)

    T_O_B = T_W_B[reported]
    tilted = Rotation.from_rotvec(tilt[reported]).as_matrix()
    T_O_B[:, :3, :3] = turned[reported] @ tilted @ T_O_B[:, :3, :3]
    T_O_B[:, :3, 3] += position_error[reported]
    between_reports = np.diff(np.append(0.0, np.cumsum(moved))[reported])
    return Odometry(T_O_B, _covariance(T_W_B[reported], between_reports, config))


def _drift(
    R_W_B: Float64[np.ndarray, "m 3 3"], moved: Float64[np.ndarray, "m"], config: OdometryConfig, rng: np.random.Generator
) -> tuple[Float64[np.ndarray, "m_plus_1"], Float64[np.ndarray, "m 3"]]:
    """Return the yaw error of each pose [rad] and the translation error of each step in W [m].

    The translation errors do not include the effects of the errors of scale and yaw.
    """
    bias = _gauss_markov(rng.standard_normal(4), moved, config.bias_correlation_m, rng)[:-1]
    root = np.sqrt(moved)
    yaw = config.yaw_walk_rad * root * rng.standard_normal(len(moved)) + config.yaw_bias_rad_m * bias[:, 0] * moved
    noise = config.position_walk_m * root[:, None] * rng.standard_normal((len(moved), 3))
    biased = config.velocity_bias * moved[:, None] * np.einsum("nij,nj->ni", R_W_B, bias[:, 1:])
    return np.append(0.0, np.cumsum(yaw)), noise + biased


def _gauss_markov(
    start: Float64[np.ndarray, "k"], moved: Float64[np.ndarray, "m"], correlation_m: float, rng: np.random.Generator
) -> Float64[np.ndarray, "m_plus_1 k"]:
    """Draw `k` independent first-order Gauss-Markov processes of unit variance, with the values `start` at the first pose.

    `moved` are the lengths of the steps [m], and `correlation_m` is the length over which the correlation falls to 1/e [m].
    The processes are exact for steps of any length.
    """
    kept = np.exp(-moved / correlation_m)
    fresh = np.sqrt(1.0 - kept**2)[:, None] * rng.standard_normal((len(moved), len(start)))
    # The banded system solves x[i + 1] - kept[i] x[i] = fresh[i] for all i at once.
    band = np.stack([np.ones(len(moved) + 1), np.append(-kept, 0.0)])
    return np.asarray(solve_banded((1, 0), band, np.concatenate([start[None], fresh])))


def _covariance(
    T_W_B: Float64[np.ndarray, "n 4 4"], moved: Float64[np.ndarray, "n_minus_1"], config: OdometryConfig
) -> Float64[np.ndarray, "n 6 6"]:
    """Return the covariance of the error of each increment in the axes of B. It is first computed in the axes of W."""
    step = np.diff(T_W_B[:, :3, 3], axis=0)
    horizontal = np.diag([1.0, 1.0, 0.0])
    kept = np.exp(-moved / config.tilt_correlation_m)
    tilt = config.tilt_rad**2 * (1.0 - np.exp(-2.0 * np.append(0.0, np.cumsum(moved)) / config.tilt_correlation_m))
    tilt_change = (1.0 - kept) ** 2 * tilt[:-1] + config.tilt_rad**2 * (1.0 - kept**2)
    lever = skew(step)

    covariance = np.zeros((len(T_W_B), 6, 6))
    covariance[1:, :3, :3] = tilt_change[:, None, None] * horizontal
    covariance[1:, 2, 2] = config.yaw_walk_rad**2 * moved + (config.yaw_bias_rad_m * moved) ** 2
    isotropic = config.position_walk_m**2 * moved + (config.velocity_bias * moved) ** 2
    covariance[1:, 3:, 3:] = isotropic[:, None, None] * np.eye(3)
    covariance[1:, 3:, 3:] += config.scale_error**2 * step[:, :, None] * step[:, None, :]
    # A tilt rotates the step. The minus is there because the lever is antisymmetric.
    covariance[1:, 3:, 3:] -= tilt[:-1, None, None] * (lever @ horizontal @ lever)

    to_body = np.zeros_like(covariance)
    to_body[:, :3, :3] = to_body[:, 3:, 3:] = np.swapaxes(T_W_B[:, :3, :3], -1, -2)
    covariance = to_body @ covariance @ np.swapaxes(to_body, -1, -2)
    return covariance / config.overconfidence + _VARIANCE_FLOOR * np.eye(6)


def _check(T_W_B: Float64[np.ndarray, "m 4 4"], stamps: Float64[np.ndarray, "m"], reported: Int[np.ndarray, "n"]) -> None:
    if len(T_W_B) == 0 or len(T_W_B) != len(stamps):
        raise SimError(f"odometry: {len(T_W_B)} poses and {len(stamps)} stamps; valid: equal numbers of both, at least one")
    if not np.all(ascends := np.diff(stamps) > 0.0):
        raise SimError(f"odometry: stamps do not ascend at index {int(np.argmin(ascends)) + 1}; valid: ascending stamps")
    if not np.all(rigid := is_rigid(T_W_B)):
        raise SimError(f"odometry: pose {int(np.argmin(rigid))} is not a rigid motion; valid: rotation and translation only")
    if len(reported) == 0 or reported[0] != 0 or reported[-1] >= len(T_W_B) or not np.all(np.diff(reported) > 0):
        raise SimError(f"odometry: reported indices are {reported}; valid: ascending from 0, below {len(T_W_B)}")
