"""`SideBySide`: several SLAM systems that get the same observations, so that a walk is rendered once for all of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lexis.types import Camera, Observation
from sim.harness import Scenario, SlamUnderTest, run
from sim.harness.adapters import Lexis
from sim.harness.estimate import Estimate
from sim.harness.runner import Run
from sim.harness.slam_under_test import AcceptsFeatures, FeatureInput


class SideBySide:
    """Gives every observation to several SLAM systems. Its own estimate is that of the first system.

    Of several LEXIS that make the same keyframes, only the first gets the observations. The others replay its keyframes at
    the end, which gives the same maps in much less time.
    """

    def __init__(self, slams: Sequence[SlamUnderTest]) -> None:
        """Prepare a run of one or more systems."""
        self._slams = tuple(slams)
        self._models = _models(self._slams)
        self.estimates: tuple[Estimate, ...] = ()
        """Estimates of all systems after `finish`, in their order."""

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run on images."""
        for slam in self._slams:
            slam.start(camera, room_names)

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        """Begin a run on percepts of the feature sensor."""
        for slam in self._slams:
            if isinstance(slam, AcceptsFeatures):
                slam.start_on_features(camera, room_names, features)
            else:
                slam.start(camera, room_names)

    def process(self, observation: Observation) -> None:
        """Give the next observation to all systems that replay no keyframes."""
        for slam, model in zip(self._slams, self._models, strict=True):
            if model is None:
                slam.process(observation)

    def finish(self) -> Estimate:
        """Finish all systems."""
        self.estimates = tuple(map(_finished, self._slams, self._models))
        return self.estimates[0]


def _models(slams: Sequence[SlamUnderTest]) -> tuple[Lexis | None, ...]:
    """For each system, the first LEXIS before it whose keyframes it can replay; None: there is none."""
    lexis = [slam for slam in slams if isinstance(slam, Lexis)]
    return tuple(_model(slam, lexis[: lexis.index(slam)]) if isinstance(slam, Lexis) else None for slam in slams)


def _model(slam: Lexis, before: Sequence[Lexis]) -> Lexis | None:
    return next((each for each in before if slam.has_keyframes_of(each)), None)


def _finished(slam: SlamUnderTest, model: Lexis | None) -> Estimate:
    if model is not None and isinstance(slam, Lexis):
        slam.replay(model.map)
    return slam.finish()


def run_side_by_side(scenario: Scenario, slams: Mapping[str, SlamUnderTest]) -> dict[str, Run]:
    """Run several systems on one scenario, and return their runs by the names of the systems.

    Each run has the system and its estimate; the times in `Run.seconds` are those of all systems together. Raises the errors
    of `sim.harness.run`.
    """
    together = SideBySide(tuple(slams.values()))
    finished = run(scenario, together)
    found = zip(slams.items(), together.estimates, strict=True)
    return {name: replace(finished, slam=slam, estimate=estimate) for (name, slam), estimate in found}
