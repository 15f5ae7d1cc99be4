"""One run: a SLAM gets the observations of a scenario, and what it claims is kept beside the truth."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int

from lexis.errors import ObservationError
from lexis.types import Pose
from sim.errors import SimError
from sim.feature_sensor.model import MINI_FEATURES, load_features
from sim.feature_sensor.sensor import FeatureSensor
from sim.fidelity import ORACLE
from sim.harness.adapters.lexis import Lexis
from sim.harness.estimate import Estimate
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import AcceptsFeatures, FeatureInput, SlamUnderTest, check_slam_methods
from sim.harness.walk import walk
from sim.render.rig import build_rig
from sim.session import Session
from sim.truth import Truth
from worlds.house import House
from worlds.walkable import Walkable

Progress = Callable[[float], None]
"""Told the share of the frames that are done, from 0 to 1."""


class Given(NamedTuple):
    """What the SLAM was told about a frame, besides its image."""

    stamp: float
    """[s]"""
    T_O_B: Pose
    """Pose of the body by odometry."""


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run. Arrays have one row for each frame of the estimate, unless they say otherwise."""

    scenario: Scenario
    house: House
    walkable: Walkable
    session: Session
    slam: object
    """The SLAM after `finish`, which may plan paths and save files; or the program that was run."""
    estimate: Estimate
    given: Mapping[int, Given]
    """What the SLAM was told about every frame that it took, by the index of the observation."""
    seconds: dict[str, float]
    """Wall time of house and tour, of building the scene, of rendering, and of the SLAM [s]."""
    delivered: tuple[Truth, ...]
    """The truth of every observation, in the order in which the SLAM was given them."""
    refused: tuple[str, ...] = ()
    """Why the SLAM refused some observations; only under faults."""

    @property
    def room_names(self) -> tuple[str, ...]:
        """The labels that the SLAM was told; labels are indices into them."""
        return self.house.spec.room_labels

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Times of the frames, as the SLAM was told them [s]."""
        return np.array([self.given[frame].stamp for frame in self.estimate.frames.tolist()])

    @property
    def true_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """True T_W_B."""
        return np.asarray(self.session.tour.T_W_B[self.estimate.frames])

    @property
    def odometry_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """T_O_B by odometry, as the SLAM was told it."""
        return np.array([self.given[frame].T_O_B for frame in self.estimate.frames.tolist()])

    @property
    def true_rooms(self) -> Int[np.ndarray, "n"]:
        """Index into `house.rooms` of the room that holds the camera."""
        return np.array([self.session.truths[frame].room for frame in self.estimate.frames.tolist()], int)

    @property
    def true_labels(self) -> Int[np.ndarray, "n"]:
        """Index into `room_names` of the true label."""
        return np.array([self.room_names.index(self.session.truths[i].label) for i in self.estimate.frames.tolist()], int)

    @property
    def true_storeys(self) -> Int[np.ndarray, "n"]:
        """Storey that the camera is on, 0 for the lowest."""
        return np.array([self.session.truths[frame].storey for frame in self.estimate.frames.tolist()], int)

    @property
    def walked_rooms(self) -> tuple[int, ...]:
        """Indices into `house.rooms` of the rooms that the tour went through, in that order."""
        return tuple(dict.fromkeys(truth.room for truth in self.session.truths))

    @property
    def unseen_rooms(self) -> tuple[str, ...]:
        """Ids of the rooms that the tour went through and that no frame of the estimate is in, in that order."""
        seen = set(self.true_rooms.tolist())
        return tuple(self.house.rooms[room].id for room in self.walked_rooms if room not in seen)


def run(scenario: Scenario, slam: SlamUnderTest | None = None, progress: Progress | None = None) -> Run:
    """Give the observations of a scenario to a SLAM; without one, to LEXIS with the encoder that the scenario names.

    Under faults, observations that the SLAM refuses (`ObservationError`) are left out, as by a driver that logs the error
    and goes on. Raises `WorldsError`, `SimError` or `LexisError` where the scenario asks for what cannot be, or where the
    estimate is not valid, and whatever the SLAM raises.
    """
    slam = slam or Lexis(scenario.encoder)
    check_slam_methods(slam)
    seconds: dict[str, float] = {}
    with _timed(seconds, "house_s"):
        walked = walk(scenario)
    camera = build_rig(scenario.rig).front
    sensor = _sensor(scenario)
    with _timed(seconds, "scene_s"):
        session = Session(walked.house, walked.tour, walked.odometry, camera, scenario.faults, scenario.seed, sensor)
    with _timed(seconds, "slam_s"):
        _start(slam, scenario, session)
    delivered, refused = [], []
    given: dict[int, Given] = {}
    with closing(iter(session)) as pairs:
        for observation, truth in pairs:
            delivered.append(truth)
            try:
                with _timed(seconds, "slam_s"):
                    slam.process(observation)
                given.setdefault(observation.index, Given(observation.stamp, observation.T_O_B))
            except ObservationError as error:
                if not scenario.faults:
                    raise
                refused.append(str(error))
            if progress is not None:
                progress((observation.index + 1) / len(session))
    with _timed(seconds, "slam_s"):
        estimate = slam.finish()
    if not isinstance(estimate, Estimate):
        raise SimError(f"SLAM under test: finish() returned {type(estimate).__name__}; valid: an Estimate")
    seconds["render_s"] = session.render_seconds
    _check_frames(estimate, given)
    return Run(
        scenario, walked.house, walked.walkable, session, slam, estimate, given, seconds, tuple(delivered), tuple(refused)
    )


def _sensor(scenario: Scenario) -> FeatureSensor | None:
    """The feature sensor; None if the SLAM gets images."""
    if scenario.fidelity == "render":
        return None
    model = load_features(scenario.feature_model or MINI_FEATURES)
    return FeatureSensor(model, build_rig(scenario.rig).front, scenario.seed, scenario.encoder == ORACLE)


def _start(slam: SlamUnderTest, scenario: Scenario, session: Session) -> None:
    names = session.house.spec.room_labels
    if scenario.fidelity == "features" and isinstance(slam, AcceptsFeatures):
        source = scenario.feature_model or MINI_FEATURES
        features = FeatureInput(load_features(source), str(source), scenario.encoder == ORACLE, session.verifier())
        slam.start_on_features(session.camera, names, features)
    else:
        slam.start(session.camera, names)


def _check_frames(estimate: Estimate, given: Mapping[int, Given]) -> None:
    """Raise SimError for claims about a frame that the SLAM was not given."""
    unknown = [frame for frame in estimate.frames.tolist() if frame not in given]
    if unknown:
        raise SimError(f"estimate: frame {unknown[0]} is none; valid: indices of observations that the SLAM was given")


@contextmanager
def _timed(seconds: dict[str, float], name: str) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[name] = seconds.get(name, 0.0) + time.perf_counter() - start
