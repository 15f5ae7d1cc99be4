"""One run: a SLAM gets the observations of a scenario, and what it claims is kept beside the truth."""

from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.errors import ObservationError
from lexis.timing import StageTimer
from lexis.types import Pose
from sim.errors import SimError
from sim.feature_sensor.model import MINI_FEATURES, FeatureModel, load_features
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
from worlds.labels import STAIRS
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
    def on_stairs(self) -> Bool[np.ndarray, "n"]:
        """Whether the camera is truly on stairs."""
        return np.array([self.house.rooms[room].label == STAIRS for room in self.true_rooms], bool)

    @property
    def true_storeys(self) -> Int[np.ndarray, "n"]:
        """Storey that the camera is on, 0 for the lowest."""
        return np.array([self.session.truths[frame].storey for frame in self.estimate.frames.tolist()], int)

    def most_similar(self, row: int, count: int) -> tuple[tuple[str, float], ...]:
        """The room names that the SLAM found most similar to a frame, best first; none without a claim of similarities."""
        if self.estimate.similarities is None:
            return ()
        scores = self.estimate.similarities[row]
        return tuple((self.room_names[k], float(scores[k])) for k in np.argsort(-scores)[:count])

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
    timed = StageTimer()
    with timed("house_s"):
        walked = walk(scenario)
    camera, model = build_rig(scenario.rig).front, _feature_model(scenario)
    sensor = None if model is None else FeatureSensor(model, camera, scenario.seed, scenario.encoder == ORACLE)
    with timed("scene_s"):
        session = Session(walked.house, walked.tour, walked.odometry, camera, scenario.faults, scenario.seed, sensor)
    with timed("slam_s"):
        _start(slam, scenario, session, model)
    delivered, refused = [], []
    given: dict[int, Given] = {}
    with closing(iter(session)) as pairs:
        for observation, truth in pairs:
            delivered.append(truth)
            try:
                with timed("slam_s"):
                    slam.process(observation)
                given.setdefault(observation.index, Given(observation.stamp, observation.T_O_B))
            except ObservationError as error:
                if not scenario.faults:
                    raise
                refused.append(str(error))
            if progress is not None:
                progress((observation.index + 1) / len(session))
    with timed("slam_s"):
        estimate = slam.finish()
    if not isinstance(estimate, Estimate):
        raise SimError(f"SLAM under test: finish() returned {type(estimate).__name__}; valid: an Estimate")
    seconds = timed.seconds | {"render_s": session.render_seconds}
    _check_frames(estimate, given)
    return Run(
        scenario, walked.house, walked.walkable, session, slam, estimate, given, seconds, tuple(delivered), tuple(refused)
    )


def _feature_model(scenario: Scenario) -> FeatureModel | None:
    """The model of the feature sensor; None if the SLAM gets images."""
    return None if scenario.fidelity == "render" else load_features(scenario.feature_model or MINI_FEATURES)


def _start(slam: SlamUnderTest, scenario: Scenario, session: Session, model: FeatureModel | None) -> None:
    names = session.house.spec.room_labels
    if model is not None and isinstance(slam, AcceptsFeatures):
        source = str(scenario.feature_model or MINI_FEATURES)
        features = FeatureInput(model, source, scenario.encoder == ORACLE, session.verifier())
        slam.start_on_features(session.camera, names, features)
    else:
        slam.start(session.camera, names)


def _check_frames(estimate: Estimate, given: Mapping[int, Given]) -> None:
    """Raise SimError for claims about a frame that the SLAM was not given."""
    unknown = [frame for frame in estimate.frames.tolist() if frame not in given]
    if unknown:
        raise SimError(f"estimate: frame {unknown[0]} is none; valid: indices of observations that the SLAM was given")
