"""Simulated verification of loop candidates, for runs without images and hence without key points.

For each candidate:

1. Compute the true distance, the true rotation, and the true covisibility: the share of one view that is visible in the
   other view, by ray casts.
2. Confirm the candidate with the probability that a logistic model computes from these three values. The model is fitted to
   real verification. With a rig of several cameras, the largest probability of all pairs of cameras counts.
3. If the candidate is confirmed, draw a real edge that is true, at random. Return the true relative pose with the error,
   covariance, inlier count, and spread of inliers of the real edge.
4. Otherwise, if the query would be nearer to the candidate in another room of its label (`mistaken_by`), move it there, and
   repeat the first three steps with the same random number. Rooms that look alike, such as those of stacked apartments, thus
   give false edges as a single room gives true ones.
5. Otherwise return an edge with the error of a real false edge, but only with a small probability.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float64, Int
from scipy.special import expit, ndtri

from lexis.config import VerificationConfig
from lexis.graph.pose_estimate import PoseEstimate
from lexis.maths.se3 import between, exp, rotation_angle
from lexis.types import Camera, Keyframe, LoopDecision, LoopEdge, Pose
from lexis.verification import Verification, plausible
from sim.feature_sensor.true_view import TrueView, covisibilities, mistaken_by

_QUERY, _PAIR = 1, 2
"""Tags of the random streams for a query, and for a pair of a query and a match. numpy ignores trailing zeros of a seed, so
that without tags, the streams of a query and of its pair with keyframe 0 would be the same."""
PREDICTORS = ("constant", "covisibility", "covisibility squared", "distance", "turn")
"""Inputs of the logistic model, for a pair of keyframes. Distance [m] and turn [rad] are between their body poses."""


@dataclass(frozen=True, eq=False)
class MeasuredEdges:
    """Loop edges that LEXIS measured on rendered images: true errors, reported covariances, numbers of inliers and cells."""

    error: Float64[np.ndarray, "n 6"]
    """Error of each measured relative pose: `log(T_true^-1 T_measured)`, rotation first [rad, m]. The errors of false edges
    are relative to the place that may be mistaken for the true one (`mistaken_by`), if there is one."""
    covariance: Float64[np.ndarray, "n 6 6"]
    inliers: Int[np.ndarray, "n"]
    cells: Int[np.ndarray, "n"]
    """Numbers of image cells that contain an inlier, as in `lexis.types.LoopDecision`."""

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
    """Probability of a false edge to a candidate that is neither confirmed nor taken for a room that looks alike."""
    true_edges: MeasuredEdges
    false_edges: MeasuredEdges
    """False edges to draw from, without those between rooms that look alike. There may be none if `false_rate` is 0."""

    def probability(self, predictors: Float64[np.ndarray, "*n predictors"]) -> Float64[np.ndarray, "*n"]:
        """Return the probability that verification finds a true edge for a pair; 0 if the views do not overlap."""
        shared = predictors[..., PREDICTORS.index("covisibility")] > 0.0
        return np.asarray(np.where(shared, expit(predictors @ self.weights), 0.0))


def predictors(firsts: Sequence[TrueView], seconds: Sequence[TrueView]) -> Float64[np.ndarray, "pairs predictors"]:
    """Return the inputs of the logistic loop model (`PREDICTORS`) for pairs of views: firsts[i] with seconds[i]."""
    shared = covisibilities(firsts, seconds)
    relative = between(np.stack([view.T_W_B for view in firsts]), np.stack([view.T_W_B for view in seconds]))
    distance = np.linalg.norm(relative[:, :3, 3], axis=1)
    return np.stack([np.ones(len(shared)), shared, shared**2, distance, rotation_angle(relative)], axis=1)


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
        true poses of the second session are moved by `away_m` along x, so that it can be in another house. No room of that
        house is mistaken for a room of the first session.
        """
        offset = np.array([away_m, 0.0, 0.0])

        def views_of(index: int) -> tuple[TrueView, ...]:
            if index < count:
                return self._views_of(index)
            views = second._views_of(index - count)
            return tuple(view.moved(offset) for view in views) if away_m else views

        return CovisibilityVerifier(self._model, views_of, second._seed)

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseEstimate, camera: Camera, config: VerificationConfig
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
        places = self._places(before, seen)
        located = [self._located(query.id, match, own, common) for match, own in zip(candidates, places, strict=True)]
        return plausible(located, graph, config)

    def _places(self, before: Sequence[tuple[TrueView, ...]], seen: tuple[TrueView, ...]) -> list[list["_Place"]]:
        """Return, for each candidate, the places where verification may find the query: the true one is the first."""
        pairs = [_Pair(i, views, seen) for i, views in enumerate(before)]
        moved: dict[tuple[float, ...], tuple[TrueView, ...]] = {}
        for i, views in enumerate(before):
            offset = mistaken_by(views[0], seen[0])
            if offset is not None:
                there = moved.setdefault(tuple(offset.tolist()), tuple(view.moved(offset) for view in seen))
                pairs.append(_Pair(i, views, there))
        firsts, seconds = [pair.before for pair in pairs], [pair.seen for pair in pairs]
        relative = between(
            np.stack([first.T_W_B for first, *_ in firsts]), np.stack([second.T_W_B for second, *_ in seconds])
        )
        limits = ndtri(self._probabilities(firsts, seconds)).tolist()
        places: list[list[_Place]] = [[] for _ in before]
        for pair, T_match_query, limit in zip(pairs, relative, limits, strict=True):
            places[pair.candidate].append(_Place(T_match_query, limit))
        return places

    def _probabilities(
        self, firsts: Sequence[tuple[TrueView, ...]], seconds: Sequence[tuple[TrueView, ...]]
    ) -> Float64[np.ndarray, "pairs"]:
        """Return the probability that each pair of keyframes is confirmed, by the best pair of their cameras."""
        of_cameras = [
            self._model.probability(predictors(first, second))
            for first in zip(*firsts, strict=True)
            for second in zip(*seconds, strict=True)
        ]
        return np.asarray(np.max(of_cameras, axis=0))

    def _located(
        self, query: int, match: int, places: Sequence["_Place"], common: float
    ) -> tuple[LoopDecision, LoopEdge | None]:
        """Return the decision on a candidate, and the edge to it or None.

        The query is found at the first place whose limit exceeds a standard normal variable. The variable is partly
        `common`, which all candidates of a query share, because the results of real verification are correlated within a
        query. If the query is found nowhere, a false edge is returned with the probability `LoopModel.false_rate`. Its error
        is relative to the last place, which is the one that may be mistaken for the true place, if there is one.
        """
        rng = np.random.default_rng((self._seed, _PAIR, query, match))
        share = self._model.query_share
        luck = math.sqrt(share) * common + math.sqrt(1.0 - share) * rng.standard_normal()
        found, pool = [place for place in places if luck < place.limit], self._model.true_edges
        if not found and rng.random() < self._model.false_rate:
            found, pool = [places[-1]], self._model.false_edges
        if not found:
            return LoopDecision(query, match, "unconfirmed"), None
        drawn = int(rng.integers(len(pool.inliers)))
        inliers, cells = int(pool.inliers[drawn]), int(pool.cells[drawn])
        T_match_query = found[0].T_match_query @ pool.error_motions[drawn]
        edge = LoopEdge(query, match, T_match_query, pool.covariance[drawn].copy(), inliers)
        return LoopDecision(query, match, "accepted", inliers=inliers, cells=cells), edge


class _Pair(NamedTuple):
    """The views of a candidate, and those of the query at its true place or at one that may be mistaken for it."""

    candidate: int
    """Index into the candidates of the query."""
    before: tuple[TrueView, ...]
    seen: tuple[TrueView, ...]


class _Place(NamedTuple):
    """A place where verification may find the query."""

    T_match_query: Pose
    limit: float
    """Quantile of the standard normal distribution at the probability that verification finds the query here."""


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
