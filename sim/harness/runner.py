"""`run`: gives the observations of a scenario to a SLAM, and returns the SLAM's estimate together with the truth."""

from collections.abc import Callable
from contextlib import closing

from lexis.errors import ObservationError
from lexis.timing import StageTimer
from sim.errors import SimError
from sim.feature_sensor.model import MINI_FEATURES, FeatureModel
from sim.fidelity import ORACLE
from sim.harness.adapters.lexis import Lexis
from sim.harness.feature_input import FeatureInput
from sim.harness.finished_run import Given, Run
from sim.harness.last_run import last_run
from sim.harness.returned_estimate import checked_estimate
from sim.harness.scenario import Scenario
from sim.harness.scenario_sessions import feature_model, session_of
from sim.harness.slam_under_test import AcceptsFeatures, SlamUnderTest, check_slam_methods, title_of
from sim.harness.walk import walk
from sim.session import Session
from sim.truth import Truth
from sim.wording import class_of

Progress = Callable[[float], None]
"""A function that is called with the share of the frames that are done, in [0, 1]."""


def run(scenario: Scenario, slam: SlamUnderTest | None = None, progress: Progress | None = None) -> Run:
    """Give the observations of a scenario to a SLAM; by default to LEXIS with the encoder that the scenario names.

    In a scenario with faults, observations that the SLAM refuses by an `ObservationError` are skipped, as in a real robot's
    driver. In a test that pytest runs with `--lexis-replay`, the stored scenario is run in place of `scenario`; see
    `last_run`. Raises `WorldsError`, `SimError` or `LexisError` if the scenario is impossible or the estimate is not valid,
    and whatever the SLAM raises.
    """
    if not isinstance(scenario, Scenario):
        raise SimError(f"scenario is {class_of(scenario)}; valid: a Scenario, such as Scenario(preset='home', seed=7)")
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
    indices: set[int] = set()  # of the observations that the SLAM has got
    with timed("start_s"), last.calling_slam():
        _start(slam, scenario, session, model, indices)
        title_of(slam)  # raises here, and not after the run, whatever the SLAM's `settings` raise
    last.started = True
    given, delivered, refused = _processed(slam, session, timed, progress, indices)
    last.done = 1.0
    with timed("slam_s"), last.calling_slam():
        returned = slam.finish()
    estimate = checked_estimate(returned, given, len(walked.house.spec.room_labels))
    seconds = timed.seconds | {"render_s": session.render_seconds - rendered_before_s}
    last.run = Run(
        scenario, session.house, walked.walkable, session, slam, estimate, given, seconds, tuple(delivered), tuple(refused)
    )
    return last.run


def _processed(
    slam: SlamUnderTest, session: Session, timed: StageTimer, progress: Progress | None, indices: set[int]
) -> tuple[dict[int, Given], list[Truth], list[str]]:
    """Give all observations of a session to a SLAM. Before each of them, its index is added to `indices`.

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
            indices.add(observation.index)
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


def _start(slam: SlamUnderTest, scenario: Scenario, session: Session, model: FeatureModel | None, indices: set[int]) -> None:
    names, camera = session.house.spec.room_labels, session.camera.copy()  # the SLAM may write into the camera
    if model is not None and isinstance(slam, AcceptsFeatures):
        source = str(scenario.feature_model or MINI_FEATURES)
        oracle = scenario.encoder == ORACLE
        features = FeatureInput(model, source, oracle, session.verifier(), camera, indices.__contains__)
        slam.start_on_features(camera, names, features)
    else:
        slam.start(camera, names)
