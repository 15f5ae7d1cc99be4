"""`lexis-sim bench place-recognition`: methods of place recognition on the same walks, and a fit of the revisit probability.

In each run, all methods propose candidates on the same pose graph, whose loops come from the default method. Each house is
walked three times, so that the methods are also tested on bad pose estimates: with usual odometry, with degraded odometry,
and with a robot that is kidnapped. The errors of the maps show whether LEXIS has noticed the kidnapping.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64
from scipy.optimize import minimize
from scipy.sparse import csr_array

from lexis.config import Config, PlaceRecognitionConfig
from lexis.errors import one_line
from lexis.evaluation.place_recognition import MatchCounts, at_one_place, count_matches
from lexis.evaluation.trajectory import ate_rmse
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.se3 import between, rotation_angle
from lexis.place_recognition import old_enough, propose, revisit_log_odds
from lexis.types import Keyframe, RoomInstance
from sim.bench.odometry import CASES, USUAL
from sim.errors import SimError
from sim.fidelity import Fidelity
from sim.harness import Scenario, run
from sim.harness.adapters import Lexis
from sim.harness.world_tests import usual_rate_hz

METHODS: Mapping[str, PlaceRecognitionConfig] = MappingProxyType(
    {
        "room": PlaceRecognitionConfig(method="room"),
        "similarity": PlaceRecognitionConfig(method="similarity"),
        "probability": PlaceRecognitionConfig(method="probability"),
    }
)
"""Settings of place recognition by the names of the methods. All methods may propose the same number of candidates."""
_CONDITIONS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "usual odometry": CASES[USUAL],
        "degraded odometry": CASES["degraded"],
        "kidnapped": CASES["kidnap"],
    }
)
"""Settings of scenarios by the name of the condition in which a house is walked."""
FITTED = ("log_odds", "similarity_weight", "place_m", "place_rad", "lost_log_odds")
"""The settings that `fit_revisits` fits."""

PerPair = Float64[np.ndarray, "pairs"]


@dataclass(frozen=True)
class PlaceRow:
    """Counts of right and wrong answers of one method over several walks.

    The counts are for N = 1, 3 and 5 required matches, as in Fig. 5 of the LEXIS paper.
    """

    method: str
    counts: tuple[MatchCounts, MatchCounts, MatchCounts]


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of a query and an older keyframe: the inputs of place recognition, and whether both are at the same place."""

    similarities: PerPair
    distances_m: PerPair
    angles_rad: PerPair
    revisit: Bool[np.ndarray, "pairs"]


@dataclass(frozen=True, eq=False)
class Answers:
    """What the methods proposed for all queries of one walk, and the truth about all pairs of keyframes."""

    proposed: Mapping[str, Sequence[tuple[int, tuple[int, ...]]]]
    """For each method, the queries with the candidates proposed for them."""
    eligible: Bool[np.ndarray, "n n"]
    """For every query (rows), whether each keyframe (columns) is old enough to be proposed."""
    right: Bool[np.ndarray, "n n"]
    pairs: Pairs
    ate_m: float | None
    """Absolute trajectory error (ATE) of the finished map [m]; None if it has fewer than three keyframes."""
    ate_odometry_m: float | None
    """Absolute trajectory error of the odometry at the keyframes [m]."""


@dataclass(eq=False)
class _Listener:
    """Proposes candidates by the default method, and records what each method would propose on the same graph."""

    proposed: dict[str, list[tuple[int, tuple[int, ...]]]] = field(default_factory=lambda: {name: [] for name in METHODS})
    seen: list[tuple[PerPair, PerPair, PerPair]] = field(default_factory=list)
    eligible: list[Bool[np.ndarray, "k"]] = field(default_factory=list)

    def __call__(
        self, query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig
    ) -> tuple[int, ...]:
        old = old_enough(query.id, graph.stamps, graph.path_m, config)
        T_old_query = between(graph.T_W_B[old], graph.T_W_B[query.id])
        embeddings = np.array([graph.keyframes[id].embedding for id in np.flatnonzero(old).tolist()]).reshape(
            -1, query.embedding.size
        )
        similarities = embeddings.astype(np.float64) @ query.embedding
        self.seen.append((similarities, np.linalg.norm(T_old_query[:, :3, 3], axis=1), rotation_angle(T_old_query)))
        self.eligible.append(old)
        for name, settings in METHODS.items():
            self.proposed[name].append((query.id, propose(query, label, rooms, graph, settings)))
        return propose(query, label, rooms, graph, PlaceRecognitionConfig())


def walks(presets: Sequence[str], seeds: Sequence[int], fidelity: Fidelity) -> dict[str, list[Scenario]]:
    """Return the scenarios by the name of their condition. Every house is walked once in each condition."""
    usual = Scenario(fidelity=fidelity, frame_rate_hz=usual_rate_hz(fidelity))
    return {
        name: [replace(usual, preset=preset, seed=seed, **settings) for preset in presets for seed in seeds]
        for name, settings in _CONDITIONS.items()
    }


def ask_everywhere(scenario: Scenario) -> Answers:
    """Run LEXIS on a scenario, and return what every method proposes for each of its keyframes."""
    listener = _Listener()
    with_rooms = Config(place_recognition=METHODS["room"])  # other methods need no rooms before the map is finished
    finished = run(scenario, Lexis(config=with_rooms, place_recogniser=listener))
    right = at_one_place(finished.true_poses)
    eligible = np.zeros_like(right)
    for query, old in enumerate(listener.eligible):
        eligible[query, : len(old)] = old
    similarities, distances, angles = (np.concatenate(each) for each in zip(*listener.seen, strict=True))
    pairs = Pairs(similarities, distances, angles, right[eligible])
    assert finished.estimate.T_W_B is not None  # LEXIS estimates poses
    ate_m, ate_odometry_m = (
        ate_rmse(poses[:, :3, 3], finished.true_poses[:, :3, 3])
        for poses in (finished.estimate.T_W_B, finished.odometry_poses)
    )
    return Answers(listener.proposed, eligible, right, pairs, ate_m, ate_odometry_m)


def compare_places(answers: Sequence[Answers]) -> Iterator[PlaceRow]:
    """Yield the counts of each method over all walks."""
    for name in METHODS:
        yield PlaceRow(name, (_total(answers, name, 1), _total(answers, name, 3), _total(answers, name, 5)))


def _total(answers: Sequence[Answers], method: str, n: int) -> MatchCounts:
    found = (count_matches(walk.proposed[method], csr_array(walk.eligible & walk.right), n) for walk in answers)
    return sum(found, start=MatchCounts(0, 0, 0))


def fit_revisits(answers: Sequence[Answers]) -> PlaceRecognitionConfig:
    """Fit the probability of a revisit to all pairs of the walks, by maximum likelihood, starting from the defaults."""
    start = PlaceRecognitionConfig()
    similarities, distances, angles, revisit = (
        np.concatenate([getattr(walk.pairs, name) for walk in answers])
        for name in ("similarities", "distances_m", "angles_rad", "revisit")
    )

    def settings(values: Float64[np.ndarray, "5"]) -> PlaceRecognitionConfig:
        offset, *positive = values
        return replace(start, **dict(zip(FITTED, (float(offset), *np.exp(positive).tolist()), strict=True)))

    def loss(values: Float64[np.ndarray, "5"]) -> float:
        odds = revisit_log_odds(similarities, distances, angles, settings(values))
        return float(np.mean(np.logaddexp(0.0, odds) - revisit * odds))

    first = [start.log_odds, *(np.log(getattr(start, name)) for name in FITTED[1:])]
    found = minimize(loss, first, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-8, "maxiter": 1000})
    if not found.success:
        raise SimError(
            f"the fit of revisits does not end: {one_line(found.message, 120)}; valid: other walks, or more of them"
        )
    return settings(found.x)
