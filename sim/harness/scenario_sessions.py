"""The session of a scenario, which yields its observations. Successive runs of one scenario share a session."""

from functools import cache, lru_cache

from sim.feature_sensor.model import MINI_FEATURES, FeatureModel, load_features
from sim.feature_sensor.sensor import FeatureSensor
from sim.fidelity import ORACLE
from sim.harness.scenario import Scenario
from sim.harness.walk import Walk, walk
from sim.render.rig import build_rig
from sim.session import Session

_KEPT_BYTES = 300_000_000
"""Largest size of the images of a scenario that are kept for its next run: almost a minute of walk at 10 Hz with one usual
camera."""


def picture_session(scenario: Scenario) -> Session:
    """Return a session of a scenario without a feature sensor, to render single frames.

    Raises `WorldsError` or `SimError` if the scenario is impossible.
    """
    return _session(scenario, walk(scenario), None)


def session_of(scenario: Scenario, model: FeatureModel | None) -> Session:
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


def feature_model(scenario: Scenario) -> FeatureModel | None:
    """Return the model by which the feature sensor draws embeddings; None if the SLAM gets images."""
    if scenario.fidelity == "render":
        return None
    return load_features(scenario.feature_model) if scenario.feature_model else _shipped_features()


@cache
def _shipped_features() -> FeatureModel:
    """Return the feature model that the package contains. All runs share it, because its arrays are read-only."""
    return load_features(MINI_FEATURES)
