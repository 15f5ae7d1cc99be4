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
"""Of the first pose [rad, m]: it only fixes the gauge."""


def optimise(
    T_W_B: Poses,
    steps: Float64[np.ndarray, "n_minus_1 4 4"],
    step_covariances: Float64[np.ndarray, "n_minus_1 6 6"],
    loops: Sequence[LoopEdge],
    config: PoseGraphConfig,
) -> Poses:
    """The poses by Levenberg-Marquardt: odometry by least squares, loops under DCS, the first pose held.

    Args:
        T_W_B: where to start from.
        steps: odometry ``T_i_j`` from every keyframe to the next.
        step_covariances: of the steps; the configured floor is added.
        loops: edges between keyframes of the graph.
        config: kernel and iterations.

    Raises:
        LexisError: a loop names a keyframe that the graph does not have.
    """
    graph = gtsam.NonlinearFactorGraph()
    graph.add(gtsam.PriorFactorPose3(0, gtsam.Pose3(T_W_B[0]), gtsam.noiseModel.Isotropic.Sigma(6, _PRIOR_SIGMA)))
    for i, (step, covariance) in enumerate(zip(steps, step_covariances, strict=True)):
        noise = gtsam.noiseModel.Gaussian.Covariance(covariance + _floor(config))
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
    """DCS weights (Agarwal et al., 2013) in [0, 1] of loop edges at given poses; below 0.5 an edge counts as rejected."""
    kernel = gtsam.noiseModel.mEstimator.DCS.Create(config.dcs)
    return np.array([kernel.weight(np.sqrt(squared_residual(T_W_B, loop))) for loop in loops], dtype=np.float64)


def squared_residual(T_W_B: Poses, loop: LoopEdge) -> float:
    """Squared Mahalanobis distance between a loop's measurement and the poses (chi² of 6 degrees of freedom)."""
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


def _floor(config: PoseGraphConfig) -> Covariance:
    sigmas = np.repeat([config.min_rotation_sigma_rad, config.min_translation_sigma_m], 3)
    return np.diag(sigmas**2)
