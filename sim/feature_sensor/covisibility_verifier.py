"""Simulated verification of loop candidates, for runs without images and hence without key points.

For each candidate:

1. Compute the true distance, the true rotation, and the true covisibility: the share of one view that is visible in the
   other view, by ray casts.
2. Confirm the candidate with the probability that a logistic model computes from these three values. The model is fitted to
   real verification.
   With a rig of several cameras, the largest probability of all pairs of cameras counts.
3. If the candidate is confirmed, draw a real edge that is true, at random. Return the true relative pose with the error,
   covariance, inlier count, and spread of inliers of the real edge.
4. Otherwise do the same with a real edge that is false, but only with a small probability.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Float32, Float64, Int
from scipy.special import expit, ndtri

from lexis.config import VerificationConfig
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.se3 import between, exp, inverse, rotation_angle
from lexis.types import Camera, Keyframe, LoopEdge, Pose, Verdict
from lexis.verification import Verification, plausible
from sim.feature_sensor.ray_origins import RayGrid

_DEPTH_SHARE, _DEPTH_M = 0.15, 0.05
"""Two depths count as depths of the same point if they differ by at most this share of the depth plus this length [m]. These
bounds are generous, because the grid of rays is coarse."""
_QUERY, _PAIR = 1, 2
"""Tags of the random streams for a query, and for a pair of a query and a match. numpy ignores trailing zeros of a seed, so
that without tags, the streams of a query and of its pair with keyframe 0 would be the same."""
PREDICTORS = ("constant", "covisibility", "covisibility squared", "distance", "turn")
"""Inputs of the logistic model, for a pair of keyframes. Distance [m] and turn [rad] are between their body poses."""


@dataclass(frozen=True, eq=False)
class MeasuredEdges:
    """Loop edges that LEXIS measured on rendered images: true errors, reported covariances, numbers of inliers and cells."""

    error: Float64[np.ndarray, "n 6"]
    """Error of each measured relative pose: `log(T_true^-1 T_measured)`, rotation first [rad, m]."""
    covariance: Float64[np.ndarray, "n 6 6"]
    inliers: Int[np.ndarray, "n"]
    cells: Int[np.ndarray, "n"]
    """Numbers of image cells that contain an inlier, as in `lexis.types.Verdict`."""

    def __getitem__(self, rows: Int[np.ndarray, "k"] | Bool[np.ndarray, "n"]) -> "MeasuredEdges":
        return MeasuredEdges(*(getattr(self, field.name)[rows] for field in fields(self)))

    @cached_property
    def error_motions(self) -> Float64[np.ndarray, "n 4 4"]:
        """The errors as rigid motions: `T_true^-1 T_measured` of each edge."""
        return exp(self.error.copy())  # scipy refuses an array that cannot be written to


@dataclass(frozen=True, eq=False)
class LoopModel:
    """A fitted model of loop verification: the probability that a candidate is confirmed, and loop edges to return."""

    weights: Float64[np.ndarray, "predictors"]
    """Weights of `PREDICTORS` in the log odds that verification returns a true edge."""
    query_share: float
    """A random variable decides whether a candidate is confirmed. This share of the variable's variance, in [0, 1), is
    common to all candidates of one query."""
    false_rate: float
    """Probability that a candidate without a true edge gets a false edge."""
    true_edges: MeasuredEdges
    false_edges: MeasuredEdges
    """False edges to draw from. There may be none if `false_rate` is 0."""

    def probability(self, predictors: Float64[np.ndarray, "*n predictors"]) -> Float64[np.ndarray, "*n"]:
        """Return the probability that verification finds a true edge for a pair; 0 if the views do not overlap."""
        shared = predictors[..., PREDICTORS.index("covisibility")] > 0.0
        return np.asarray(np.where(shared, expit(predictors @ self.weights), 0.0))


@dataclass(frozen=True, eq=False)
class TrueView:
    """Ground truth of what one camera of a keyframe sees: its pose, and the depth of its rays [m].

    The camera is taken to be upright, so that the points of a camera that looks down by 20 degrees are up to 6 % off.

    For a further camera of a rig, the pose of the body is the pose at which the first camera would look in the direction of
    this camera.
    """

    T_W_B: Pose
    T_W_C: Pose
    depth: Float32[np.ndarray, "columns rows"]
    grid: RayGrid
    """Image positions of the rays, in the order of `depth`."""

    @cached_property
    def T_C_W(self) -> Pose:
        """The inverse of `T_W_C`."""
        return np.asarray(inverse(self.T_W_C))

    @cached_property
    def points(self) -> Float64[np.ndarray, "3 rays"]:
        """End points of the rays in the frame of the camera [m]; NaN for a ray that hits nothing."""
        z = np.where(np.isfinite(self.depth) & (self.depth > 0.0), self.depth, np.nan).astype(float)
        return np.stack([self.grid.x[:, None] * z, self.grid.y[None] * z, z]).reshape(3, -1)


def predictors(firsts: Sequence[TrueView], seconds: Sequence[TrueView]) -> Float64[np.ndarray, "pairs predictors"]:
    """Return the inputs of the logistic loop model (`PREDICTORS`) for pairs of views: firsts[i] with seconds[i].

    The covisibility is the geometric mean of two shares: of the second view in the first view, and of the first in the
    second.
    """
    shared = _seen_by(firsts, seconds)
    overlap = np.flatnonzero(shared)  # pairs without overlap in this direction have covisibility 0
    if len(overlap):
        back = _seen_by([seconds[i] for i in overlap.tolist()], [firsts[i] for i in overlap.tolist()])
        shared[overlap] = np.sqrt(shared[overlap] * back)
    relative = between(np.stack([view.T_W_B for view in firsts]), np.stack([view.T_W_B for view in seconds]))
    distance = np.linalg.norm(relative[:, :3, 3], axis=1)
    return np.stack([np.ones(len(shared)), shared, shared**2, distance, rotation_angle(relative)], axis=1)


def _seen_by(viewers: Sequence[TrueView], others: Sequence[TrueView]) -> Float64[np.ndarray, "pairs"]:
    """Return, for each pair, the share of the rays of `others[i]` whose end points are also visible in `viewers[i]`.

    All views have the same grid of rays.
    """
    T = np.stack([view.T_C_W for view in viewers]) @ np.stack([view.T_W_C for view in others])
    points = T[:, :3, :3] @ np.stack([view.points for view in others]) + T[:, :3, 3:]
    depths, grid = np.stack([view.depth.reshape(-1) for view in viewers]), viewers[0].grid
    depth, rays = points[:, 2].reshape(-1), points.shape[2]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # NaN for rays that hit nothing
        column = _nearest(points[:, 0] / points[:, 2], grid.x).reshape(-1)
        row = _nearest(points[:, 1] / points[:, 2], grid.y).reshape(-1)
        inside = (column >= 0) & (column < len(grid.x)) & (row >= 0) & (row < len(grid.y))
        inside &= depth > _DEPTH_M  # leaves out points behind the camera
    point = np.flatnonzero(inside)  # one integer array selects faster than a boolean array
    pair, depth = point // rays, depth[point]
    met = depths[pair, (column[point] * len(grid.y) + row[point]).astype(int)]
    same = np.abs(met - depth) <= _DEPTH_SHARE * depth + _DEPTH_M
    return np.asarray(np.bincount(pair[same], minlength=len(points)) / rays)


def _nearest(values: Float64[np.ndarray, "n k"], axis: Float32[np.ndarray, "m"]) -> Float64[np.ndarray, "n k"]:
    """Return the number of the grid line nearest to each value, counted from 0, as if the grid had no ends; NaN for NaN."""
    return np.asarray(np.rint((values - axis[0]) / (axis[1] - axis[0])))


class CovisibilityVerifier:
    """A `lexis.verification.Verifier` that uses the ground truth. The edge of a pair depends on pair and seed only."""

    def __init__(self, model: LoopModel, views_of: Callable[[int], tuple[TrueView, ...]], seed: int) -> None:
        """`views_of` maps the index of an observation to its ground truth for each camera, the first camera first."""
        self._model, self._views_of, self._seed = model, views_of, seed

    def renumbered(self, original: Callable[[int], int]) -> "CovisibilityVerifier":
        """Return this verifier for a SLAM that gets the observations under other indices.

        `original` maps the SLAM's index of an observation to the index in the tour.
        """
        return CovisibilityVerifier(self._model, lambda index: self._views_of(original(index)), self._seed)

    def followed_by(self, second: "CovisibilityVerifier", count: int, away_m: float = 0.0) -> "CovisibilityVerifier":
        """Return a verifier for two sessions: the session of this verifier, then the session of the verifier `second`.

        The first session has `count` observations; the observations of the second session are numbered from `count` on. The
        true poses of the second session are moved by `away_m` along x, so that it can be in another house.
        """
        shift = np.eye(4)
        shift[0, 3] = away_m

        def views_of(index: int) -> tuple[TrueView, ...]:
            if index < count:
                return self._views_of(index)
            views = second._views_of(index - count)
            return tuple(replace(view, T_W_B=shift @ view.T_W_B, T_W_C=shift @ view.T_W_C) for view in views)

        return CovisibilityVerifier(self._model, views_of, second._seed)

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseGraph, camera: Camera, config: VerificationConfig
    ) -> Verification:
        """Return loop edges, true or false, to candidates of `query`.

        Edges that contradict the odometry are left out. So are edges that are uncertain, or whose inliers cover little of
        the image, if they do not confirm the estimate.
        """
        if not candidates:
            return Verification(())
        common = np.random.default_rng((self._seed, _QUERY, query.id)).standard_normal()
        seen = self._views_of(query.observation_index)
        before = [self._views_of(graph.keyframes[match].observation_index) for match in candidates]
        limits = ndtri(self._probabilities(before, seen))
        true = between(np.stack([first.T_W_B for first, *_ in before]), seen[0].T_W_B)
        located = [
            self._located(query.id, match, T_match_query, limit, common)
            for match, T_match_query, limit in zip(candidates, true, limits.tolist(), strict=True)
        ]
        return plausible(located, graph, config)

    def _probabilities(
        self, before: Sequence[tuple[TrueView, ...]], seen: tuple[TrueView, ...]
    ) -> Float64[np.ndarray, "candidates"]:
        """Return the probability that each candidate is confirmed, by its best pair of cameras."""
        of_pairs = [
            self._model.probability(predictors(views, [view] * len(views)))
            for views in zip(*before, strict=True)
            for view in seen
        ]
        return np.asarray(np.max(of_pairs, axis=0))

    def _located(self, query: int, match: int, true: Pose, limit: float, common: float) -> tuple[Verdict, LoopEdge | None]:
        """Return the verdict on a candidate with the relative pose `true`, and the edge to it or None.

        The candidate is confirmed if a standard normal variable is below `limit`. The variable is partly `common`, which all
        candidates of a query share, because the results of real verification are correlated within a query. If the candidate
        is not confirmed, a false edge is returned with the probability `LoopModel.false_rate`.
        """
        rng = np.random.default_rng((self._seed, _PAIR, query, match))
        share = self._model.query_share
        if math.sqrt(share) * common + math.sqrt(1.0 - share) * rng.standard_normal() < limit:
            pool = self._model.true_edges
        elif rng.random() < self._model.false_rate:
            pool = self._model.false_edges
        else:
            return Verdict(query, match, "unconfirmed"), None
        drawn = int(rng.integers(len(pool.inliers)))
        inliers, cells = int(pool.inliers[drawn]), int(pool.cells[drawn])
        edge = LoopEdge(query, match, true @ pool.error_motions[drawn], pool.covariance[drawn].copy(), inliers)
        return Verdict(query, match, "accepted", inliers=inliers, cells=cells), edge


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
