"""Simulated verification of loop candidates, for runs without images and hence without key points.

For each candidate:

1. Compute the true covisibility (the share of one view that is visible in the other, by ray casts), distance and rotation.
2. Confirm the candidate with the probability that a logistic model computes from these three values. The model is fitted to
   real verification.
3. If confirmed, return the true relative pose with the error, covariance and inlier count of a real edge, drawn at random.
4. Otherwise return a false edge with a small probability, with the error of a real false edge.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Float32, Float64, Int
from scipy.special import expit, ndtri

from lexis.config import VerificationConfig
from lexis.maths.se3 import between, exp, inverse, rotation_angle
from lexis.pose_graph import PoseGraph
from lexis.types import Camera, Keyframe, LoopEdge, Pose
from lexis.verification import plausible_edges
from sim.feature_sensor.ray_origins import RayGrid

_DEPTH_SHARE, _DEPTH_M = 0.15, 0.05
"""Two depths count as those of one point if they differ by at most this share of the depth plus this length [m]. These
bounds are generous, because rays are coarse."""
_QUERY, _PAIR = 1, 2
"""Tags of the random streams. numpy ignores trailing zeros of a seed: without tags, a query would share the stream of its
pair with keyframe 0."""
PREDICTORS = ("constant", "covisibility", "covisibility squared", "distance", "turn")
"""Inputs of the logistic model. Distance [m] and turn [rad] are those between the body poses of the two keyframes."""


@dataclass(frozen=True, eq=False)
class MeasuredEdges:
    """Loop edges that LEXIS measured on rendered images: true errors, reported covariances and numbers of inliers."""

    error: Float64[np.ndarray, "n 6"]
    """`log` of the motion from the true to the measured relative pose, rotation first [rad, m]."""
    covariance: Float64[np.ndarray, "n 6 6"]
    inliers: Int[np.ndarray, "n"]

    @cached_property
    def error_motions(self) -> Float64[np.ndarray, "n 4 4"]:
        """Motions from the true to the measured relative poses."""
        return exp(self.error)


@dataclass(frozen=True, eq=False)
class LoopModel:
    """A fitted model of loop verification: the probability that it confirms a candidate, and the edges that it returns."""

    weights: Float64[np.ndarray, "predictors"]
    """Weights of `PREDICTORS`, for the log odds of a true edge."""
    query_share: float
    """A random variable decides whether a candidate is confirmed. This share of its variance, in [0, 1), is common to all
    candidates of one query."""
    false_rate: float
    """Probability of a false edge for a candidate that does not get a true one."""
    true_edges: MeasuredEdges
    false_edges: MeasuredEdges
    """False edges to draw from. They may be empty if `false_rate` is 0."""

    def probability(self, predictors: Float64[np.ndarray, "*n predictors"]) -> Float64[np.ndarray, "*n"]:
        """Return the probability that verification confirms a loop with a correct edge; 0 if the views do not overlap."""
        shared = predictors[..., PREDICTORS.index("covisibility")] > 0.0
        return np.asarray(np.where(shared, expit(predictors @ self.weights), 0.0))


@dataclass(frozen=True, eq=False)
class TrueView:
    """Ground truth of a keyframe: the poses of its body and camera, and the depth of its rays [m]."""

    T_W_B: Pose
    T_W_C: Pose
    depth: Float32[np.ndarray, "columns rows"]
    grid: RayGrid
    """Image positions of the rays, in the order of `depth`."""

    @cached_property
    def points(self) -> Float64[np.ndarray, "3 k"]:
        """End points of the rays that hit something, in the frame of the camera [m]."""
        z = np.where(np.isfinite(self.depth), self.depth, 0.0).astype(float)
        return np.stack([self.grid.x[:, None] * z, self.grid.y[None] * z, z])[:, z > 0.0]


def predictors(first: TrueView, second: TrueView) -> Float64[np.ndarray, "predictors"]:
    """Return the inputs of the logistic loop model (`PREDICTORS`) for a pair of views."""
    shared = float(np.sqrt(_seen_by(first, second) * _seen_by(second, first)))
    relative = between(first.T_W_B, second.T_W_B)
    return np.array([1.0, shared, shared**2, np.linalg.norm(relative[:3, 3]), float(rotation_angle(relative))])


def _seen_by(viewer: TrueView, other: TrueView) -> float:
    """Return the share of the other view's rays whose end points the viewer sees, too."""
    T = inverse(viewer.T_W_C) @ other.T_W_C
    x, y, depth = T[:3, :3] @ other.points + T[:3, 3:]
    depth = np.where(depth > _DEPTH_M, depth, np.inf)  # points behind the camera are at no depth that a ray has
    column, row = _nearest(x / depth, viewer.grid.x), _nearest(y / depth, viewer.grid.y)
    columns, rows = viewer.depth.shape
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows) & (depth < np.inf)
    met, depth = viewer.depth[column[inside], row[inside]], depth[inside]
    return float(np.count_nonzero(np.abs(met - depth) <= _DEPTH_SHARE * depth + _DEPTH_M)) / other.depth.size


def _nearest(values: Float64[np.ndarray, "k"], axis: Float32[np.ndarray, "m"]) -> Int[np.ndarray, "k"]:
    """Return the indices of the nearest grid lines; outside of the grid they are negative, or `m` and more."""
    return np.asarray(np.rint((values - axis[0]) / (axis[1] - axis[0])), int)


class CovisibilityVerifier:
    """A `lexis.verification.Verifier` that uses the ground truth. Its result for a pair depends on pair and seed only."""

    def __init__(self, model: LoopModel, view_of: Callable[[int], TrueView], seed: int) -> None:
        """`view_of` maps the index of an observation to its ground truth."""
        self._model, self._view_of, self._seed = model, view_of, seed

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseGraph, camera: Camera, config: VerificationConfig
    ) -> list[LoopEdge]:
        """Return edges to the confirmed candidates, except those that contradict the odometry."""
        common = np.random.default_rng((self._seed, _QUERY, query.id)).standard_normal()
        edges = [self._edge(query, graph.keyframes[match], common) for match in candidates]
        return plausible_edges([edge for edge in edges if edge is not None], graph, config)

    def _edge(self, query: Keyframe, match: Keyframe, common: float) -> LoopEdge | None:
        """Return the edge to a candidate, or None. `common` is the normal draw that all candidates of the query share."""
        seen, before = self._view_of(query.observation_index), self._view_of(match.observation_index)
        chance = float(self._model.probability(predictors(before, seen)))
        rng = np.random.default_rng((self._seed, _PAIR, query.id, match.id))
        share = self._model.query_share
        # A standard normal draw, correlated between the candidates of a query, because real successes of a query are.
        drawn_value = np.sqrt(share) * common + np.sqrt(1.0 - share) * rng.standard_normal()
        if drawn_value < ndtri(chance):
            pool = self._model.true_edges
        elif rng.random() < self._model.false_rate:
            pool = self._model.false_edges
        else:
            return None
        drawn = int(rng.integers(len(pool.inliers)))
        measured = between(before.T_W_B, seen.T_W_B) @ pool.error_motions[drawn]
        return LoopEdge(query.id, match.id, measured, pool.covariance[drawn], int(pool.inliers[drawn]))


def fit_logistic(
    inputs: Float64[np.ndarray, "n p"], outcome: Float[np.ndarray, "n"], ridge: float = 1e-3
) -> Float64[np.ndarray, "p"]:
    """Fit a logistic regression with a ridge penalty by Newton's method and return its weights."""
    weights = np.zeros(inputs.shape[1])
    for _ in range(50):
        chance = expit(inputs @ weights)
        gradient = inputs.T @ (outcome - chance) - ridge * weights
        hessian = (inputs * (chance * (1.0 - chance))[:, None]).T @ inputs + ridge * np.eye(len(weights))
        step = np.linalg.solve(hessian, gradient)
        weights = weights + step
        if np.abs(step).max() < 1e-8:
            break
    return weights
