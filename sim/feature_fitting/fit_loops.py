"""Fits the model of loop verification to outcomes of LEXIS's real verification.

`try_verification` runs LEXIS on the rendered images of a walk, then verifies LEXIS's loop candidates and other pairs of
nearby keyframes. `fit_loops` fits the model to the outcomes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.special import ndtr, ndtri

from lexis.config import Config
from lexis.evaluation.loops import within_limits
from lexis.locator import Locator
from lexis.maths.se3 import between, log
from lexis.perception import Encoder
from lexis.slam import Slam
from lexis.types import Camera, LexisMap, LoopArrays
from sim.feature_sensor.covisibility_verifier import PREDICTORS, LoopModel, MeasuredEdges, fit_logistic, predictors
from sim.feature_sensor.surroundings import survey
from sim.feature_sensor.true_view import TrueView, mistaken_by, true_views
from sim.feature_sensor.visible_shares import look
from sim.odometry.config import ODOMETRY_PRESETS
from sim.odometry.simulation import tour_odometry
from sim.render.camera import wide_camera
from sim.session import Session
from sim.tours.tour import TourConfig, plan_tour
from sim.training.houses import HouseDraw
from worlds.house import build_house
from worlds.walkable import Walkable

_FRAME_RATE_HZ = 3.5
"""Frames per second [Hz]. At the usual speed of 0.7 m/s there is a frame every 0.2 m, which is enough for keyframes and
support frames."""
_OTHERS = 4
"""Number of nearby keyframes that are verified per query, in addition to LEXIS's candidates."""
_OTHERS_M = 4.0
"""Largest distance between a query and the additional keyframes that are verified [m]."""
_GAP = 20
"""A nearby keyframe is verified only if it is older than the query by more than this number of keyframes."""
_LAGS = 9
"""Two trials of a query are compared if they are fewer than this number of rows apart. The trials of a query are consecutive
rows."""
_NODES = 21
"""Number of nodes of the quadrature over the random variable that all trials of a query share."""


@dataclass(frozen=True, eq=False)
class Trials:
    """Outcomes of loop verification, one row for each verified pair of a query keyframe and an earlier keyframe."""

    query: Int[np.ndarray, "n"]
    """Number of each pair's query keyframe, unique over all walks."""
    predictors: Float64[np.ndarray, "n predictors"]
    is_true: Bool[np.ndarray, "n"]
    """Whether each pair was confirmed and its edge is right."""
    is_false: Bool[np.ndarray, "n"]
    """Whether each pair was confirmed and its edge is neither right nor mistaken."""
    is_mistaken: Bool[np.ndarray, "n"]
    """Whether each pair was confirmed and its edge would be right if a room were another one of its label."""
    true_edges: MeasuredEdges
    false_edges: MeasuredEdges


class Judged(NamedTuple):
    """Loop edges compared with the truth, one row for each edge."""

    errors: Float64[np.ndarray, "k 4 4"]
    """Error of each edge: `T_true^-1 T_measured`. If the edge is not true, the error is relative to the place for which the
    query's place may be mistaken (`mistaken_by`), if there is one."""
    is_true: Bool[np.ndarray, "k"]
    is_mistaken: Bool[np.ndarray, "k"]
    """Whether each edge is not true, but would be true at the place for which the query's place may be mistaken."""


def fit_loops(trials: Trials) -> LoopModel:
    """Fit the model of loop verification to the outcomes of real verification."""
    model = LoopModel(
        fit_logistic(trials.predictors, trials.is_true.astype(float)),
        0.0,
        float(trials.is_false.sum() / max(1, (~trials.is_true & ~trials.is_mistaken).sum())),
        trials.true_edges,
        trials.false_edges,
    )
    share = _query_share(model.probability(trials.predictors), trials.is_true, trials.query)
    return LoopModel(model.weights, share, model.false_rate, model.true_edges, model.false_edges)


def try_verification(choice: HouseDraw, encoder: Encoder, seed: int) -> Trials:
    """Run LEXIS on rendered images of a walk through a house, and return the outcomes of verifying pairs of keyframes.

    The pairs are LEXIS's loop candidates and other pairs of nearby keyframes.
    """
    camera, config = wide_camera(), Config()
    house = build_house(choice.spec())
    rng = np.random.default_rng((choice.seed, seed))
    tour = plan_tour(house, Walkable(house), rng, TourConfig(frame_rate_hz=_FRAME_RATE_HZ))
    session = Session(house, tour, tour_odometry(tour, ODOMETRY_PRESETS["multicam"], rng), camera)
    slam = Slam(camera, encoder, house.spec.room_labels, config)
    for observation, _ in session:
        slam.process(observation)
    mapped = slam.finish()
    poses = tour.T_W_B[[keyframe.observation_index for keyframe in mapped.keyframes]]
    views = true_views(look(survey(house), poses, camera), poses, camera)
    return _tried(mapped, _pairs(mapped, poses, rng), views, camera, config)


def _pairs(mapped: LexisMap, poses: Float64[np.ndarray, "n 4 4"], rng: np.random.Generator) -> list[tuple[int, list[int]]]:
    pairs = []
    for query, candidates in mapped.candidates:
        distance = np.linalg.norm(poses[: max(query - _GAP, 0), :3, 3] - poses[query, :3, 3], axis=1)
        near = np.flatnonzero(distance < _OTHERS_M)
        others = rng.choice(near, min(_OTHERS, len(near)), replace=False).tolist()
        pairs.append((query, [*candidates, *(match for match in others if match not in candidates)]))
    return pairs


def _tried(
    mapped: LexisMap, pairs: Sequence[tuple[int, list[int]]], views: Sequence[TrueView], camera: Camera, config: Config
) -> Trials:
    queries, located = [], []
    rows = [np.zeros((0, len(PREDICTORS)))]
    for query, matches in pairs:
        locator = Locator(mapped.keyframes[query], mapped.keyframes, camera, config.verification)
        queries += [query] * len(matches)
        located += [locator.from_match(match) for match in matches]
        if matches:
            rows.append(predictors([views[match] for match in matches], [views[query]] * len(matches)))
    found = np.array([edge is not None for _, edge in located], bool)
    edges = LoopArrays.of([edge for _, edge in located if edge is not None])
    cells = np.array([decision.cells for decision, edge in located if edge is not None], int)
    errors, right, mistaken = judged(edges, views)
    measured = MeasuredEdges(log(errors).reshape(-1, 6), edges.covariance, edges.inliers, cells)
    false = ~right & ~mistaken
    outcomes = np.zeros((3, len(found)), bool)
    outcomes[:, found] = right, false, mistaken
    is_true, is_false, is_mistaken = outcomes
    inputs = np.concatenate(rows)
    return Trials(np.array(queries, int), inputs, is_true, is_false, is_mistaken, measured[right], measured[false])


def judged(edges: LoopArrays, views: Sequence[TrueView]) -> Judged:
    """Compare loop edges with the truth, given what the keyframes truly see."""
    T_W_B = np.array([view.T_W_B for view in views]).reshape(-1, 4, 4)
    mistaken = T_W_B[edges.query].copy()
    for row, (match, query) in enumerate(zip(edges.match.tolist(), edges.query.tolist(), strict=True)):
        offset = mistaken_by(views[match], views[query])
        if offset is not None:
            mistaken[row] = views[query].moved(offset).T_W_B
    places = (T_W_B[edges.query], mistaken)
    true, alike = (between(between(T_W_B[edges.match], place), edges.T_match_query) for place in places)
    is_true = within_limits(true)
    return Judged(np.where(is_true[:, None, None], true, alike), is_true, ~is_true & within_limits(alike))


def joined(parts: Sequence[Trials]) -> Trials:
    """Join the trials of several walks. The queries are renumbered, so that no two walks share a number."""
    first = np.cumsum([0, *(int(part.query.max(initial=-1)) + 1 for part in parts)])
    return Trials(
        np.concatenate([part.query + offset for part, offset in zip(parts, first, strict=False)]),
        np.concatenate([part.predictors for part in parts]),
        np.concatenate([part.is_true for part in parts]),
        np.concatenate([part.is_false for part in parts]),
        np.concatenate([part.is_mistaken for part in parts]),
        _pooled([part.true_edges for part in parts]),
        _pooled([part.false_edges for part in parts]),
    )


def _pooled(parts: Sequence[MeasuredEdges]) -> MeasuredEdges:
    return MeasuredEdges(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(MeasuredEdges)))


def _query_share(chance: Float64[np.ndarray, "n"], outcome: Bool[np.ndarray, "n"], query: Int[np.ndarray, "n"]) -> float:
    """Return the value of `LoopModel.query_share` that explains how often two candidates of a query are both confirmed."""
    pairs = [(i, i + lag) for lag in range(1, _LAGS) for i in np.flatnonzero(query[lag:] == query[:-lag]).tolist()]
    a, b = np.array(pairs, int).reshape(-1, 2).T
    both = float((outcome[a] & outcome[b]).mean()) if len(a) else 0.0
    nodes, weights = np.polynomial.hermite_e.hermegauss(_NODES)
    level = ndtri(np.clip(chance, 1e-9, 1 - 1e-9))
    shares = np.linspace(0.0, 0.95, 20)
    expected = []
    for share in shares:
        given = ndtr((level[:, None] - np.sqrt(share) * nodes) / np.sqrt(1.0 - share))
        expected.append(float(np.mean((given[a] * given[b]) @ weights) / weights.sum()) if len(a) else 0.0)
    return float(shares[np.argmin(np.abs(np.array(expected) - both))])
