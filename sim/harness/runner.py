"""`run`: gives the observations of a scenario to a SLAM, and returns the SLAM's estimate together with the truth."""

from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import replace

import numpy as np

from lexis.errors import ObservationError
from lexis.timing import StageTimer
from sim.errors import EstimateError
from sim.feature_sensor.model import MINI_FEATURES, FeatureModel
from sim.fidelity import ORACLE
from sim.harness.adapters.lexis import Lexis
from sim.harness.estimate import Estimate
from sim.harness.finished_run import Given, Run
from sim.harness.last_run import last_run
from sim.harness.scenario import Scenario
from sim.harness.scenario_sessions import feature_model, session_of
from sim.harness.slam_under_test import AcceptsFeatures, FeatureInput, SlamUnderTest, check_slam_methods
from sim.harness.walk import walk
from sim.session import Session
from sim.truth import Truth

Progress = Callable[[float], None]
"""A function that is called with the share of the frames that are done, in [0, 1]."""


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
        model = feature_model(scenario)
        session = session_of(scenario, model)
    rendered_before_s = session.render_seconds
    last.done = 0.0
    with timed("slam_s"), last.calling_slam():
        _start(slam, scenario, session, model)
    given, delivered, refused = _processed(slam, session, timed, progress)
    last.done = 1.0
    with timed("slam_s"), last.calling_slam():
        estimate = slam.finish()
    if not isinstance(estimate, Estimate):
        raise EstimateError(f"SLAM under test: finish() returned {type(estimate).__name__}; valid: an Estimate")
    seconds = timed.seconds | {"render_s": session.render_seconds - rendered_before_s}
    # The estimate is checked again, because a SLAM may have written into the arrays since it made the estimate.
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
    """Raise `EstimateError` if an estimate has frames that the SLAM was not given, or indices of names that do not exist."""
    for row, frame in enumerate(estimate.frames.tolist()):
        if frame not in given:
            raise EstimateError(f"estimate: frames has {frame} in row {row}; valid: {_indices(given)}")
    for name in ("labels", "baseline_labels"):
        values = getattr(estimate, name)
        if values is not None and (beyond := np.flatnonzero(values >= names)).size:
            bad = f"{name} has {values[beyond[0]]} in row {beyond[0]}"
            raise EstimateError(f"estimate: {bad}; valid: -1 to {names - 1}, since there are {names} room names")
    columns = names if estimate.similarities is None else estimate.similarities.shape[1]
    if columns != names:
        raise EstimateError(f"estimate: similarities has {columns} columns; valid: {names}, one for each room name")
