"""Robust optimisation of a pose graph (paper, Eq. 2)."""

from collections.abc import Sequence
from typing import TypeAlias

import gtsam
import numpy as np
from jaxtyping import Float64

from lexis.config import PoseGraphConfig
from lexis.errors import LexisError
from lexis.inputs import is_invertible
from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between
from lexis.types import Covariance, LoopEdge, Pose, Poses

_Kernel: TypeAlias = gtsam.noiseModel.mEstimator.DCS | gtsam.noiseModel.mEstimator.Huber | gtsam.noiseModel.mEstimator.Null
_PRIOR_SIGMA = 1e-6
"""Standard deviation of the prior on the first pose [rad, m], which only fixes the gauge freedom."""
_UNKNOWN_SIGMA = 1e4
"""Standard deviation of the edge between two sessions [rad, m]. It says nothing about their relative pose, but it keeps the
equations solvable while no loop edge connects them."""
CONVERGED = 1e-5
"""An optimisation ends when an iteration reduces the cost by less than this share of it."""
ROUGHLY = 1e-3
"""During a walk, an optimisation ends when an iteration reduces the cost by less than this share of it, because the next
optimisation follows soon."""


def check_loops(loops: Sequence[LoopEdge], keyframes: int) -> None:
    """Raise LexisError unless each edge leads from one of the keyframes to an earlier one, and has a definite covariance."""
    for loop in loops:
        edge = f"loop edge {loop.match} -> {loop.query}"
        if not 0 <= loop.match < loop.query < keyframes:
            raise LexisError(f"{edge} does not fit the graph; valid: 0 <= match < query < {keyframes}")
        if not is_invertible(loop.covariance):
            raise LexisError(f"{edge} has a singular covariance; valid: a positive definite one")


class GraphOptimiser:
    """Optimisation of a growing pose graph by Levenberg-Marquardt: all poses but the first move, or only the last poses.

    Residuals of odometry edges are simply squared. Residuals of loop edges pass through a robust kernel, by default DCS, so
    that a wrong loop has little influence. Edges and poses are reused from one optimisation to the next.
    """

    def __init__(self, first: Pose, config: PoseGraphConfig) -> None:
        """Begin a graph with the pose `T_W_B` of its first keyframe."""
        self._config, self._count = config, 1
        self._odometry, self._loops = gtsam.NonlinearFactorGraph(), gtsam.NonlinearFactorGraph()
        self._queries = GrowingArray((), np.int64)
        self._poses = gtsam.Values()
        prior = gtsam.noiseModel.Isotropic.Sigma(6, _PRIOR_SIGMA)
        self._odometry.add(gtsam.PriorFactorPose3(0, gtsam.Pose3(first), prior))
        self._poses.insert(0, gtsam.Pose3(first))
        self.iterations: int | None = None
        """Number of iterations of the last optimisation; None before the first optimisation, and after an optimisation by
        graduated non-convexity."""
        self._min_covariance = _min_covariance(config)
        self._kernel = _kernel(config)

    def add_keyframe(self, T_W_B: Pose, step: Pose, covariance: Covariance) -> None:
        """Append a keyframe at an initial pose.

        `step` is the odometry ``T_i_j`` from the previous keyframe i to the new keyframe j, and `covariance` its covariance,
        to which the configured minimum is added.
        """
        noise = gtsam.noiseModel.Gaussian.Covariance(covariance + self._min_covariance)
        self._odometry.add(gtsam.BetweenFactorPose3(self._count - 1, self._count, gtsam.Pose3(step), noise))
        self._poses.insert(self._count, gtsam.Pose3(T_W_B))
        self._count += 1

    def add_session(self, T_W_B: Pose) -> None:
        """Append the first keyframe of a new session at an initial pose, whose relation to earlier keyframes is unknown."""
        step = self._poses.atPose3(0).between(gtsam.Pose3(T_W_B))
        unknown = gtsam.noiseModel.Isotropic.Sigma(6, _UNKNOWN_SIGMA)
        self._odometry.add(gtsam.BetweenFactorPose3(0, self._count, step, unknown))
        self._poses.insert(self._count, gtsam.Pose3(T_W_B))
        self._count += 1

    def add_loops(self, loops: Sequence[LoopEdge]) -> None:
        """Add loop edges.

        Raises LexisError, and adds no edge, unless every edge leads from a keyframe of the graph to an earlier keyframe, and
        has a positive definite covariance.
        """
        check_loops(loops, self._count)
        for loop in loops:
            plain = gtsam.noiseModel.Gaussian.Covariance(loop.covariance)
            noise = gtsam.noiseModel.Robust.Create(self._kernel, plain)
            self._loops.add(gtsam.BetweenFactorPose3(loop.match, loop.query, gtsam.Pose3(loop.T_match_query), noise))
            self._queries.append(loop.query)

    @property
    def cost(self) -> float:
        """Half of the sum of the squared whitened residuals at the current poses.

        The residuals of loop edges pass through the robust kernel.
        """
        return self._odometry.error(self._poses) + self._loops.error(self._poses)

    def start_chordally(self) -> None:
        """Replace the current poses by a start that needs no initial poses: the chordal relaxation of Carlone et al. (2015).

        The relaxation finds all rotations at once by linear least squares, and then the positions. Initial poses near a
        wrong minimum, for example from drifting odometry, thus do no harm. Wrong loops do, because the relaxation has no
        robust kernel. A graph without loops keeps its poses: odometry alone has no wrong minimum, and GTSAM's relaxation
        cannot solve it.
        """
        if self._loops.size():
            self._poses = gtsam.InitializePose3.initialize(_joined(self._odometry, self._loops))

    def optimise(self, tolerance: float = CONVERGED) -> Poses:
        """Optimise all poses, starting at the last result; return ``T_W_B`` of all keyframes in their order.

        The optimisation ends when an iteration reduces the cost by less than the share `tolerance`.
        """
        self._poses = self._solved(self._odometry, self._loops, self._poses, tolerance)
        return _matrices(self._poses)

    def optimise_last(self, count: int, tolerance: float = CONVERGED) -> Poses:
        """Optimise the last `count` poses while all earlier poses stay as they are; return ``T_W_B`` of the last ones.

        The time depends on `count` and not on the size of the graph. An edge to an earlier pose counts as a prior on the
        pose at its other end, with the same residual and the same kernel.
        """
        first = self._count - count
        if first <= 0:
            return self.optimise(tolerance)
        free = gtsam.Values()
        for key in range(first, self._count):
            free.insert(key, self._poses.atPose3(key))
        odometry, loops = gtsam.NonlinearFactorGraph(), gtsam.NonlinearFactorGraph()
        for key in range(first, self._count):
            odometry.add(self._with_earlier_fixed(self._odometry.at(key), first))
        for row in np.flatnonzero(self._queries.rows >= first).tolist():
            loops.add(self._with_earlier_fixed(self._loops.at(row), first))
        found = self._solved(odometry, loops, free, tolerance)
        self._poses.update(found)
        return _matrices(found)

    def _with_earlier_fixed(self, edge: gtsam.NonlinearFactor, first: int) -> gtsam.NonlinearFactor:
        """Return the edge, or a prior on its later pose if its earlier pose lies before the pose `first`."""
        assert isinstance(edge, gtsam.BetweenFactorPose3)
        earlier, later = edge.keys()
        if earlier >= first:
            return edge
        return gtsam.PriorFactorPose3(later, self._poses.atPose3(earlier) * edge.measured(), edge.noiseModel())

    def _solved(
        self, odometry: gtsam.NonlinearFactorGraph, loops: gtsam.NonlinearFactorGraph, start: gtsam.Values, tolerance: float
    ) -> gtsam.Values:
        """Return the poses that minimise the residuals of odometry and loops."""
        graph = _joined(odometry, loops)
        parameters = gtsam.LevenbergMarquardtParams()
        parameters.setMaxIterations(self._config.max_iterations)
        parameters.setRelativeErrorTol(tolerance)
        if self._config.kernel != "gnc" or not loops.size():
            plain = gtsam.LevenbergMarquardtOptimizer(graph, start, parameters)
            found = plain.optimize()
            self.iterations = plain.iterations()
            return found
        self.iterations = None
        graduated = gtsam.GncLMParams(parameters)
        graduated.setLossType(gtsam.GncLossType.TLS)
        graduated.setKnownInliers(list(range(odometry.size())))
        optimiser = gtsam.GncLMOptimizer(graph, start, graduated)
        optimiser.setInlierCostThresholds(self._config.outlier_threshold / 2.0)  # the cost is half of the squared residual
        return optimiser.optimize()


def _joined(odometry: gtsam.NonlinearFactorGraph, loops: gtsam.NonlinearFactorGraph) -> gtsam.NonlinearFactorGraph:
    graph = gtsam.NonlinearFactorGraph()
    graph.push_back(odometry)
    graph.push_back(loops)
    return graph


def _matrices(poses: gtsam.Values) -> Poses:
    """Return the poses as 4x4 matrices, in the order of their keys."""
    rows = gtsam.utilities.extractPose3(poses)  # nine elements of the rotation, row by row, and the translation
    matrices = np.tile(np.eye(4), (len(rows), 1, 1))
    matrices[:, :3, :3], matrices[:, :3, 3] = rows[:, :9].reshape(-1, 3, 3), rows[:, 9:]
    return matrices


def loop_weights(T_W_B: Poses, loops: Sequence[LoopEdge], config: PoseGraphConfig) -> Float64[np.ndarray, "loops"]:
    """Return the weights of loop edges under the kernel at given poses, in [0, 1].

    `lexis.graph.trusted_loops` tells which weights count as trusted. Without a kernel, all weights are 1. Under graduated
    non-convexity, each weight is 1 or 0.
    """
    squared = np.array([squared_residual(T_W_B, loop) for loop in loops], dtype=np.float64)
    if config.kernel == "gnc":
        return (squared <= config.outlier_threshold).astype(np.float64)
    kernel = _kernel(config)
    return np.array([kernel.weight(residual) for residual in np.sqrt(squared)], dtype=np.float64)


def _kernel(config: PoseGraphConfig) -> _Kernel:
    """Return the robust kernel of loop edges. For the settings gnc and none, it is the null kernel, with weights of 1."""
    match config.kernel:
        case "dcs":
            return gtsam.noiseModel.mEstimator.DCS.Create(config.outlier_threshold)
        case "huber":
            return gtsam.noiseModel.mEstimator.Huber.Create(np.sqrt(config.outlier_threshold))
        case _:
            return gtsam.noiseModel.mEstimator.Null.Create()


def squared_residual(T_W_B: Poses, loop: LoopEdge) -> float:
    """Return the squared Mahalanobis distance between a loop edge's relative pose and the relative pose in `T_W_B`.

    For a correct edge, this distance follows a chi² distribution with 6 degrees of freedom.
    """
    predicted = gtsam.Pose3(between(T_W_B[loop.match], T_W_B[loop.query]))
    error = gtsam.Pose3.Logmap(gtsam.Pose3(loop.T_match_query).between(predicted))
    return float(error @ np.linalg.solve(loop.covariance, error))


def _min_covariance(config: PoseGraphConfig) -> Covariance:
    sigmas = np.repeat([config.min_rotation_sigma_rad, config.min_translation_sigma_m], 3)
    return np.diag(sigmas**2)
