"""`run`: gives the observations of a scenario to a SLAM, and returns the SLAM's claims together with the truth."""

from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.errors import ObservationError
from lexis.maths.ties import rounded
from lexis.timing import StageTimer
from lexis.types import Pose
from sim.errors import ClaimError
from sim.feature_sensor.model import MINI_FEATURES, FeatureModel, load_features
from sim.feature_sensor.sensor import FeatureSensor
from sim.fidelity import ORACLE
from sim.harness.adapters.lexis import Lexis
from sim.harness.estimate import Estimate
from sim.harness.last_run import last_run
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import AcceptsFeatures, FeatureInput, SlamUnderTest, check_slam_methods
from sim.harness.walk import Walk, walk
from sim.render.rig import build_rig
from sim.session import Session
from sim.truth import Truth
from worlds.house import House
from worlds.labels import STAIRS
from worlds.walkable import Walkable

_KEPT_BYTES = 300_000_000
"""Largest size of the images of a scenario that are kept for its next run: 50 s of walk at 10 Hz with one usual camera."""
Progress = Callable[[float], None]
"""A function that is called with the share of the frames that are done, in [0, 1]."""


class Given(NamedTuple):
    """What the SLAM was given at a frame, without the image."""

    stamp: float
    """Time stamp [s]."""
    T_O_B: Pose
    """Pose of the body in the odometry frame, from the odometry."""


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run. Arrays have one row for each frame of the estimate, unless they say otherwise."""

    scenario: Scenario
    house: House
    walkable: Walkable
    session: Session
    slam: object
    """The SLAM after its `finish`, or the `CommandSlam` of an external program. Some SLAMs also implement `PlansPaths` or
    `SavesFiles`."""
    estimate: Estimate
    given: Mapping[int, Given]
    """Input of the SLAM at every frame that it accepted; the key is `Observation.index`."""
    seconds: dict[str, float]
    """Wall times by part of the run [s]: making house and tour, building the scene, rendering, and the SLAM."""
    delivered: tuple[Truth, ...]
    """The truth of every observation that the SLAM was given, including refused ones, in the order of delivery."""
    refused: tuple[str, ...] = ()
    """Error messages with which the SLAM refused observations; always empty without faults."""

    @property
    def room_names(self) -> tuple[str, ...]:
        """The labels that rooms may have, as the SLAM was told; claimed and true labels are indices into these names."""
        return self.house.spec.room_labels

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Time stamps of the frames [s], as the SLAM received them."""
        return np.array([self.given[frame].stamp for frame in self.estimate.frames.tolist()])

    @property
    def true_stamps(self) -> Float64[np.ndarray, "n"]:
        """True times of the frames [s], which no fault of the clock changes; see `Truth.stamp`."""
        stamps = {truth.index: truth.stamp for truth in self.delivered}
        return np.array([stamps[frame] for frame in self.estimate.frames.tolist()])

    @property
    def true_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """True poses of the body in the world, `T_W_B`."""
        return np.asarray(self.session.tour.T_W_B[self.estimate.frames])

    @property
    def odometry_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """Poses of the body in the odometry frame, `T_O_B`, as the SLAM received them.

        A pose that a fault has made NaN is replaced by the last finite pose before it or, if there is none, by the identity,
        at which the odometry begins.
        """
        poses = np.array([self.given[frame].T_O_B for frame in self.estimate.frames.tolist()])
        known = np.where(np.isfinite(poses).all(axis=(1, 2)), np.arange(len(poses)), -1)
        held = np.maximum.accumulate(known)
        return np.where(held[:, None, None] < 0, np.eye(4), poses[held])

    @property
    def true_rooms(self) -> Int[np.ndarray, "n"]:
        """True room of every frame, as an index into `house.rooms`."""
        return np.array([self.session.truths[frame].room for frame in self.estimate.frames.tolist()], int)

    @property
    def true_labels(self) -> Int[np.ndarray, "n"]:
        """True label of every frame, as an index into `room_names`."""
        names = self.room_names
        return np.array([names.index(self.session.truths[i].label) for i in self.estimate.frames.tolist()], int)

    @property
    def on_stairs(self) -> Bool[np.ndarray, "n"]:
        """For every frame, whether the camera is truly on stairs."""
        return np.array([self.house.rooms[room].label == STAIRS for room in self.true_rooms], bool)

    @property
    def true_storeys(self) -> Int[np.ndarray, "n"]:
        """True storey of every frame, 0 for the lowest."""
        return np.array([self.session.truths[frame].storey for frame in self.estimate.frames.tolist()], int)

    def most_similar(self, row: int, count: int) -> tuple[tuple[str, float], ...]:
        """Return the `count` room names most similar to the frame in a row of the estimate, with similarities, best first.

        The result is empty if the SLAM claims no similarities.
        """
        if self.estimate.similarities is None:
            return ()
        scores = self.estimate.similarities[row]
        best = np.argsort(-rounded(scores), kind="stable")[:count]
        return tuple((self.room_names[k], float(scores[k])) for k in best.tolist())

    @property
    def walked_rooms(self) -> tuple[int, ...]:
        """Rooms that the tour went through, as indices into `house.rooms`, in the order of the first visit."""
        return tuple(dict.fromkeys(truth.room for truth in self.session.truths))

    @property
    def unseen_rooms(self) -> tuple[str, ...]:
        """Ids of the rooms on the tour that contain no frame of the estimate, in the order of the first visit."""
        seen = set(self.true_rooms.tolist())
        return tuple(self.house.rooms[room].id for room in self.walked_rooms if room not in seen)


def run(scenario: Scenario, slam: SlamUnderTest | None = None, progress: Progress | None = None) -> Run:
    """Give the observations of a scenario to a SLAM; by default to LEXIS with the encoder that the scenario names.

    In a scenario with faults, observations that the SLAM refuses by an `ObservationError` are skipped, as in a real robot's
    driver. In a test that pytest runs with `--lexis-replay`, the stored scenario is run in place of `scenario`; see
    `last_run`. Raises `WorldsError`, `SimError` or `LexisError` if the scenario is impossible or the estimate is not valid,
    and whatever the SLAM raises.
    """
    last = last_run()
    scenario = last.begin(scenario)
    if slam is None:
        slam = Lexis(scenario.encoder)
    last.slam = slam
    check_slam_methods(slam)
    timed = StageTimer()
    with timed("house_s"):
        walked = walk(scenario)
    with timed("scene_s"):
        model = _feature_model(scenario)
        session = _session_of(scenario, model)
    rendered_before_s = session.render_seconds
    last.done = 0.0
    with timed("slam_s"), last.calling_slam():
        _start(slam, scenario, session, model)
    given, delivered, refused = _processed(slam, session, timed, progress)
    last.done = 1.0
    with timed("slam_s"), last.calling_slam():
        estimate = slam.finish()
    if not isinstance(estimate, Estimate):
        raise ClaimError(f"SLAM under test: finish() returned {type(estimate).__name__}; valid: an Estimate")
    seconds = timed.seconds | {"render_s": session.render_seconds - rendered_before_s}
    # The claims are checked again, because a SLAM may have written into its arrays since it made the estimate.
    _check_estimate(replace(estimate), given, len(walked.house.spec.room_labels))
    last.run = Run(
        scenario, session.house, walked.walkable, session, slam, estimate, given, seconds, tuple(delivered), tuple(refused)
    )
    return last.run


def _processed(
    slam: SlamUnderTest, session: Session, timed: StageTimer, progress: Progress | None
) -> tuple[dict[int, Given], list[Truth], list[str]]:
    """Give all observations of a session to a SLAM.

    Return what the SLAM has accepted, by the index of the observation; the truth of all delivered observations; and the
    messages of those that it has refused, which only a session with faults allows.
    """
    last = last_run()
    given: dict[int, Given] = {}
    delivered: list[Truth] = []
    refused: list[str] = []
    allowed = (ObservationError,) if session.faults else ()
    with closing(iter(session)) as pairs:
        for observation, truth in pairs:
            delivered.append(truth)
            last.done = observation.index / len(session)
            now = Given(observation.stamp, observation.T_O_B.copy())  # the SLAM may write into the observation
            try:
                with timed("slam_s"), last.calling_slam(*allowed):
                    slam.process(observation)
                given.setdefault(observation.index, now)
            except allowed as error:
                refused.append(str(error))
            if progress is not None:
                progress((observation.index + 1) / len(session))
    return given, delivered, refused


def picture_session(scenario: Scenario) -> Session:
    """Return a session of a scenario without a feature sensor, to render single frames.

    Raises `WorldsError` or `SimError` if the scenario is impossible.
    """
    return _session(scenario, walk(scenario), None)


def _session_of(scenario: Scenario, model: FeatureModel | None) -> Session:
    """Return the session of a scenario with its feature model. Successive runs of a scenario share it if that saves time.

    Runs on features share a session, unless the file of their feature model might change in between. Runs on few images
    share one that keeps the images.
    """
    if model is not None:
        shared = scenario.feature_model is None
        return _session_on_features(scenario, walk(scenario)) if shared else _session(scenario, walk(scenario), model)
    frames, camera = len(walk(scenario).tour.stamps), build_rig(scenario.rig).front
    size = 3 * frames * sum(each.intrinsics.width * each.intrinsics.height for each in camera.rig)
    return (
        _session_with_images(scenario, walk(scenario)) if size <= _KEPT_BYTES else _session(scenario, walk(scenario), None)
    )


def _session(scenario: Scenario, walked: Walk, model: FeatureModel | None, keeps_images: bool = False) -> Session:
    """Return the session that yields a scenario's observations: percepts with a feature model, images without one."""
    camera = build_rig(scenario.rig).front
    sensor = None if model is None else FeatureSensor(model, camera, scenario.seed, scenario.encoder == ORACLE)
    given = walked.house, walked.tour, walked.odometry, camera, scenario.faults, scenario.seed, sensor
    return Session(*given, keeps_images=keeps_images)


@lru_cache(maxsize=2)
def _session_on_features(scenario: Scenario, walked: Walk) -> Session:
    """Return the session of a scenario on the features of the shipped model.

    Successive runs of the scenario share the session, so that percepts are computed only once when several laws run it.
    """
    return _session(scenario, walked, _shipped_features())


@lru_cache(maxsize=1)
def _session_with_images(scenario: Scenario, walked: Walk) -> Session:
    """Return the session of a scenario on images, which keeps the images, so that several laws render them only once."""
    return _session(scenario, walked, None, keeps_images=True)


def _feature_model(scenario: Scenario) -> FeatureModel | None:
    """Return the model by which the feature sensor draws embeddings; None if the SLAM gets images."""
    if scenario.fidelity == "render":
        return None
    return load_features(scenario.feature_model) if scenario.feature_model else _shipped_features()


@cache
def _shipped_features() -> FeatureModel:
    """Return the feature model that the package contains. All runs share it, because its arrays are read-only."""
    return load_features(MINI_FEATURES)


def _start(slam: SlamUnderTest, scenario: Scenario, session: Session, model: FeatureModel | None) -> None:
    names, camera = session.house.spec.room_labels, session.camera.copy()  # the SLAM may write into the camera
    if model is not None and isinstance(slam, AcceptsFeatures):
        source = str(scenario.feature_model or MINI_FEATURES)
        slam.start_on_features(camera, names, FeatureInput(model, source, scenario.encoder == ORACLE, session.verifier()))
    else:
        slam.start(camera, names)


def _indices(given: Mapping[int, Given]) -> str:
    """Return the indices of the observations that the SLAM was given, as text for messages."""
    if not given:
        return "indices of observations that the SLAM was given and did not refuse, of which there are none"
    low, high = min(given), max(given)
    gaps = len(given) <= high - low
    return f"{low} to {high}" + (", without observations that were dropped or that the SLAM refused" if gaps else "")


def _check_estimate(estimate: Estimate, given: Mapping[int, Given], names: int) -> None:
    """Raise ClaimError for claims about frames that the SLAM was not given, or about room names that do not exist."""
    for row, frame in enumerate(estimate.frames.tolist()):
        if frame not in given:
            raise ClaimError(f"estimate: frames has {frame} in row {row}; valid: {_indices(given)}")
    for name in ("labels", "baseline_labels"):
        claim = getattr(estimate, name)
        if claim is not None and (beyond := np.flatnonzero(claim >= names)).size:
            bad = f"{name} has {claim[beyond[0]]} in row {beyond[0]}"
            raise ClaimError(f"estimate: {bad}; valid: -1 to {names - 1}, since there are {names} room names")
    columns = names if estimate.similarities is None else estimate.similarities.shape[1]
    if columns != names:
        raise ClaimError(f"estimate: similarities has {columns} columns; valid: {names}, one for each room name")
