"""Changes to what a SLAM is given, which must not change what it claims: another origin, another clock, other prompts ...

A change works on the stream of observations and on the room names, before they reach the SLAM, and converts the claims back.
The SLAM is not touched, so that the changes apply to any SLAM. Every observation passed on has a new index, counted from 0.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from lexis.config import VerificationConfig
from lexis.maths.se3 import between, exp
from lexis.pose_graph import PoseGraph
from lexis.types import Camera, Keyframe, LoopEdge, Observation, Pose
from lexis.verification import Verifier
from sim.errors import SimError
from sim.harness.estimate import Estimate, LoopClaims
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import AcceptsFeatures, FeatureInput, SlamUnderTest

_SURE = np.repeat([0.01, 0.04], 3) ** 2
"""Variances that a false loop states, as small as those of a true loop: rotation, then translation [rad², m²]."""
_INLIERS = 40
"""Number of inliers that a false loop states."""


class StreamChange(Protocol):
    """Interface of a change. Changes have no state, so one object serves any number of runs."""

    def names(self, room_names: Sequence[str]) -> tuple[str, ...]:
        """Return the room names that the SLAM is told."""
        ...

    def observations(self, observation: Observation, number: int) -> Iterator[Observation]:
        """Yield what the SLAM gets in place of the observation with this number, counted from 0."""
        ...

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return what takes the place of images in runs on features."""
        ...

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Whether the change reaches this SLAM in this scenario at all."""
        ...


@dataclass(frozen=True)
class Nothing:
    """No change: the SLAM is run once more."""

    def names(self, room_names: Sequence[str]) -> tuple[str, ...]:
        """Return the names as they are."""
        return tuple(room_names)

    def observations(self, observation: Observation, number: int) -> Iterator[Observation]:
        """Yield the observation unchanged."""
        yield observation

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return the input unchanged."""
        return features

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Whether the change reaches this SLAM in this scenario at all."""
        return True


@dataclass(frozen=True)
class MovedOrigin(Nothing):
    """The odometry frame lies elsewhere: all poses are moved by one rigid motion that keeps z upright."""

    shift_m: tuple[float, float, float] = (30.0, -20.0, 8.0)
    yaw_rad: float = 2.0

    @property
    def T_new_old(self) -> Pose:
        """The motion from the old odometry frame to the new one."""
        T = exp(np.array([0.0, 0.0, self.yaw_rad, 0.0, 0.0, 0.0]))
        T[:3, 3] = self.shift_m
        return T

    def observations(self, observation: Observation, number: int) -> Iterator[Observation]:
        """Yield the observation with its pose in the new odometry frame."""
        yield replace(observation, T_O_B=self.T_new_old @ observation.T_O_B)


@dataclass(frozen=True)
class OtherClock(Nothing):
    """The clock starts later."""

    offset_s: float = 1000.0

    def observations(self, observation: Observation, number: int) -> Iterator[Observation]:
        """Yield the observation with its new stamp."""
        yield replace(observation, stamp=self.offset_s + observation.stamp)


@dataclass(frozen=True)
class Pause(Nothing):
    """The robot stands still for a while: one observation is repeated, and the later ones come later."""

    after: int = 10
    """Number of the observation at which the robot stands still, counted from 0."""
    pauses: int = 20
    """How often this observation is repeated."""
    period_s: float = 0.5
    """Time between the repeated observations [s]."""

    def observations(self, observation: Observation, number: int) -> Iterator[Observation]:
        """Yield the observation, and its repetitions if the robot stands still there."""
        if number <= self.after:
            yield observation
        else:
            yield replace(observation, stamp=observation.stamp + self.pauses * self.period_s)
        if number == self.after:
            still = np.eye(6) * 1e-12
            for k in range(1, self.pauses + 1):
                yield replace(observation, stamp=observation.stamp + k * self.period_s, increment_covariance=still)


@dataclass(frozen=True)
class PermutedNames(Nothing):
    """The room names come in another order: reversed."""

    def names(self, room_names: Sequence[str]) -> tuple[str, ...]:
        """Return the names in the reverse order."""
        return tuple(reversed(room_names))


@dataclass(frozen=True)
class MoreNames(Nothing):
    """There are further room names, for rooms that no house has."""

    more: tuple[str, ...] = ("swimming pool", "stable")

    def names(self, room_names: Sequence[str]) -> tuple[str, ...]:
        """Return the names, followed by the further ones."""
        return (*room_names, *self.more)


@dataclass(frozen=True)
class FalseLoops(Nothing):
    """Loop verification confirms some loops with a wrong relative pose, as it does where two places look alike.

    SLAM systems that verify loops on their own are not affected.
    """

    share: float = 0.1
    """Share of the keyframes with loop candidates that get a false loop."""
    error_m: float = 2.0
    """Distance by which the relative pose of a false loop is wrong [m]."""
    seed: int = 0

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return the input with a verifier that makes mistakes."""
        return replace(features, verifier=_Mistaken(features.verifier, self))

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Whether the SLAM may use the verifier of the feature sensor."""
        return scenario.fidelity == "features" and isinstance(slam, AcceptsFeatures)


@dataclass(frozen=True, eq=False)
class _Mistaken:
    """A loop verifier that adds false loops to those of another verifier."""

    verifier: Verifier
    mistakes: FalseLoops

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseGraph, camera: Camera, config: VerificationConfig
    ) -> list[LoopEdge]:
        """Return the confirmed loops, and for some queries one more that is wrong."""
        edges = self.verifier(query, candidates, graph, camera, config)
        rng = np.random.default_rng((self.mistakes.seed, query.id))
        if not candidates or rng.random() >= self.mistakes.share:
            return edges
        match = int(rng.choice(list(candidates)))
        wrong = between(graph.T_W_B[match], graph.T_W_B[query.id])
        angle = rng.uniform(0.0, 2.0 * np.pi)
        wrong[:2, 3] += self.mistakes.error_m * np.array([np.cos(angle), np.sin(angle)])
        return [*edges, LoopEdge(query.id, match, wrong, np.diag(_SURE), _INLIERS)]


class ChangedStream:
    """A SLAM behind a change of its input. It claims what the SLAM claims, about the unchanged observations."""

    def __init__(self, slam: SlamUnderTest, change: StreamChange) -> None:
        self._slam, self._change = slam, change
        self._names: tuple[str, ...] = ()
        self._given: list[int] = []
        """Index of the unchanged observation for each observation that the SLAM got."""
        self._processed = 0

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run with the changed room names."""
        self._reset(room_names)
        self._slam.start(camera, self._change.names(room_names))

    def process(self, observation: Observation) -> None:
        """Give the SLAM what takes the place of the observation."""
        number, self._processed = self._processed, self._processed + 1
        for changed in self._change.observations(observation, number):
            self._given.append(observation.index)
            self._slam.process(replace(changed, index=len(self._given) - 1))

    def finish(self) -> Estimate:
        """Return the claims, with indices of the unchanged observations and of the unchanged room names."""
        return _restored(self._slam.finish(), np.array(self._given), self._original_name())

    def _reset(self, room_names: Sequence[str]) -> None:
        self._names, self._given, self._processed = tuple(room_names), [], 0

    def _original_name(self) -> np.ndarray:
        """For each changed room name, its index in the unchanged room names; -1 for a name that is not among them."""
        return np.array([self._names.index(n) if n in self._names else -1 for n in self._change.names(self._names)])


class ChangedFeatureStream(ChangedStream):
    """A SLAM behind a change of its input, for a SLAM that accepts features."""

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        """Begin a run on percepts with the changed room names."""
        self._reset(room_names)
        if not isinstance(self._slam, AcceptsFeatures):
            raise SimError("SLAM under test: has no method start_on_features(); valid: ChangedStream")
        renumbered = features.renumbered(lambda index: self._given[index])
        self._slam.start_on_features(camera, self._change.names(room_names), self._change.features(renumbered))


def changed(slam: SlamUnderTest, change: StreamChange) -> ChangedStream:
    """Put a SLAM behind a change of its input. It accepts features if the SLAM does."""
    return (ChangedFeatureStream if isinstance(slam, AcceptsFeatures) else ChangedStream)(slam, change)


def _restored(claims: Estimate, given: np.ndarray, name_of: np.ndarray) -> Estimate:
    """Convert claims about changed observations; of several frames for one observation, the first stays."""
    frames, first = np.unique(given[claims.frames], return_index=True)
    new_row = np.searchsorted(frames, given[claims.frames])
    similarities = claims.similarities
    if similarities is not None:
        kept = name_of >= 0
        columns = np.zeros((len(similarities), int(name_of.max()) + 1))
        columns[:, name_of[kept]] = similarities[:, kept]
        similarities = columns[first]
    return replace(
        claims,
        frames=frames,
        T_W_B=None if claims.T_W_B is None else claims.T_W_B[first],
        labels=_renamed(claims.labels, first, name_of),
        baseline_labels=_renamed(claims.baseline_labels, first, name_of),
        rooms=None if claims.rooms is None else claims.rooms[first],
        floors=None if claims.floors is None else claims.floors[first],
        loops=_moved(claims.loops, new_row),
        candidates=None,
        similarities=similarities,
    )


def _renamed(labels: np.ndarray | None, first: np.ndarray, name_of: np.ndarray) -> np.ndarray | None:
    return None if labels is None else np.where(labels[first] < 0, -1, name_of[labels[first]])


def _moved(loops: LoopClaims | None, new_row: np.ndarray) -> LoopClaims | None:
    return None if loops is None else replace(loops, query=new_row[loops.query], match=new_row[loops.match])
