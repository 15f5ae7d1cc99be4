"""Robust optimisation of a pose graph (paper, Eq. 2)."""

from collections.abc import Sequence

import gtsam
import numpy as np
from jaxtyping import Float64

from lexis.config import PoseGraphConfig
from lexis.errors import LexisError
from lexis.maths.se3 import between
from lexis.types import Covariance, LoopEdge, Poses

_PRIOR_SIGMA = 1e-6
"""Standard deviation of the prior on the first pose [rad, m], which only fixes the gauge freedom."""


def optimise(
    T_W_B: Poses,
    steps: Float64[np.ndarray, "n_minus_1 4 4"],
    step_covariances: Float64[np.ndarray, "n_minus_1 6 6"],
    loops: Sequence[LoopEdge],
    config: PoseGraphConfig,
) -> Poses:
    """Optimise the poses by Levenberg-Marquardt, with the first pose fixed.

    Odometry edges enter by least squares. Loop edges enter under the robust DCS kernel, so that a wrong loop counts little.

    Args:
        T_W_B: initial poses.
        steps: odometry ``T_i_j`` from every keyframe i to the next keyframe j.
        step_covariances: covariances of the steps, to which the configured minimum is added.
        loops: loop edges between keyframes of the graph.
        config: kernel parameter, minimum covariance and iterations.

    Raises:
        LexisError: a loop refers to a keyframe that the graph does not have, or does not lead back to an earlier one.
    """
    graph = gtsam.NonlinearFactorGraph()
    graph.add(gtsam.PriorFactorPose3(0, gtsam.Pose3(T_W_B[0]), gtsam.noiseModel.Isotropic.Sigma(6, _PRIOR_SIGMA)))
    for i, (step, covariance) in enumerate(zip(steps, step_covariances, strict=True)):
        noise = gtsam.noiseModel.Gaussian.Covariance(covariance + _min_covariance(config))
        graph.add(gtsam.BetweenFactorPose3(i, i + 1, gtsam.Pose3(step), noise))
    for loop in loops:
        graph.add(_loop_factor(loop, len(T_W_B), config))
    initial = gtsam.Values()
    for i, pose in enumerate(T_W_B):
        initial.insert(i, gtsam.Pose3(pose))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setMaxIterations(config.max_iterations)
    solution = gtsam.LevenbergMarquardtOptimizer(graph, initial, parameters).optimize()
    return np.stack([solution.atPose3(i).matrix() for i in range(len(T_W_B))])


def loop_weights(T_W_B: Poses, loops: Sequence[LoopEdge], config: PoseGraphConfig) -> Float64[np.ndarray, "loops"]:
    """DCS weights (Agarwal et al., 2013) of loop edges at given poses, in [0, 1]; below 0.5, a loop counts as rejected."""
    kernel = gtsam.noiseModel.mEstimator.DCS.Create(config.dcs)
    return np.array([kernel.weight(np.sqrt(squared_residual(T_W_B, loop))) for loop in loops], dtype=np.float64)


def squared_residual(T_W_B: Poses, loop: LoopEdge) -> float:
    """Squared Mahalanobis distance between a loop's measurement and the poses (chi² with 6 degrees of freedom)."""
    predicted = gtsam.Pose3(between(T_W_B[loop.match], T_W_B[loop.query]))
    error = gtsam.Pose3.Logmap(gtsam.Pose3(loop.T_match_query).between(predicted))
    return float(error @ np.linalg.solve(loop.covariance, error))


def _loop_factor(loop: LoopEdge, count: int, config: PoseGraphConfig) -> gtsam.BetweenFactorPose3:
    if not 0 <= loop.match < loop.query < count:
        raise LexisError(
            f"loop edge {loop.match} -> {loop.query} does not fit the graph; valid: 0 <= match < query < {count}"
        )
    kernel = gtsam.noiseModel.mEstimator.DCS.Create(config.dcs)
    noise = gtsam.noiseModel.Robust.Create(kernel, gtsam.noiseModel.Gaussian.Covariance(loop.covariance))
    return gtsam.BetweenFactorPose3(loop.match, loop.query, gtsam.Pose3(loop.T_match_query), noise)


def _min_covariance(config: PoseGraphConfig) -> Covariance:
    sigmas = np.repeat([config.min_rotation_sigma_rad, config.min_translation_sigma_m], 3)
    return np.diag(sigmas**2)
