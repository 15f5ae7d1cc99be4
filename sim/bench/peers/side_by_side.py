"""`SideBySide`: several SLAM systems that get the same observations, so that a walk is rendered once for all of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lexis.config import Config, PoseGraphConfig
from lexis.types import Camera, Observation
from sim.harness import Scenario, SlamUnderTest, run
from sim.harness.adapters import Lexis
from sim.harness.estimate import Estimate
from sim.harness.feature_input import FeatureInput
from sim.harness.finished_run import Run
from sim.harness.slam_under_test import AcceptsFeatures


class SideBySide:
    """Gives every observation to several SLAM systems. Its own estimate is that of the first system.

    If several LEXIS make the same keyframes, a recorder makes these keyframes once. All of these LEXIS replay them at the
    end, which gives the same maps in much less time.
    """

    def __init__(self, slams: Sequence[SlamUnderTest]) -> None:
        """Prepare a run of one or more systems."""
        self._slams = tuple(slams)
        self._recorders = _recorders([slam for slam in self._slams if isinstance(slam, Lexis)])
        self._running = *self._recorders, *(slam for slam in self._slams if self._recorder_of(slam) is None)
        """All that get the observations."""
        self.estimates: tuple[Estimate, ...] = ()
        """Estimates of all systems after `finish`, in their order."""

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run on images."""
        for slam in (*self._recorders, *self._slams):
            slam.start(camera, room_names)

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        """Begin a run on percepts of the feature sensor."""
        for slam in (*self._recorders, *self._slams):
            if isinstance(slam, AcceptsFeatures):
                slam.start_on_features(camera, room_names, features)
            else:
                slam.start(camera, room_names)

    def process(self, observation: Observation) -> None:
        """Give the next observation to the recorders, and to all systems that replay no keyframes."""
        for slam in self._running:
            slam.process(observation)

    def finish(self) -> Estimate:
        """Finish all systems."""
        for recorder in self._recorders:
            recorder.finish()
        self.estimates = tuple(map(self._finished, self._slams))
        return self.estimates[0]

    def _finished(self, slam: SlamUnderTest) -> Estimate:
        recorder = self._recorder_of(slam)
        if recorder is not None and isinstance(slam, Lexis):
            slam.replay(recorder.map)
        return slam.finish()

    def _recorder_of(self, slam: SlamUnderTest) -> Lexis | None:
        """Return the recorder whose keyframes a system replays; None if it replays none."""
        return next((each for each in self._recorders if isinstance(slam, Lexis) and slam.has_keyframes_of(each)), None)


def _recorders(slams: Sequence[Lexis]) -> tuple[Lexis, ...]:
    """Return one recorder for each group of two or more LEXIS that make the same keyframes."""
    recorders: list[Lexis] = []
    for place, slam in enumerate(slams):
        if not any(slam.has_keyframes_of(each) for each in recorders) and any(
            map(slam.has_keyframes_of, slams[place + 1 :])
        ):
            recorders.append(_recorder(slam))
    return tuple(recorders)


def _recorder(slam: Lexis) -> Lexis:
    """Return a LEXIS that makes the same keyframes as `slam`, and no loops.

    No keyframe retires, because a replay can take only the pose from a retired keyframe.
    """
    keeping = PoseGraphConfig(copies=None)
    config = Config(keyframes=slam.config.keyframes, landmarks=slam.config.landmarks, pose_graph=keeping)
    return Lexis(slam.encoder, config, loops=False, refine=False)


def run_side_by_side(scenario: Scenario, slams: Mapping[str, SlamUnderTest]) -> dict[str, Run]:
    """Run several systems on one scenario, and return their runs by the names of the systems.

    Each run has the system and its estimate; the times in `Run.seconds` are those of all systems together. Raises the errors
    of `sim.harness.run`.
    """
    together = SideBySide(tuple(slams.values()))
    finished = run(scenario, together)
    found = zip(slams.items(), together.estimates, strict=True)
    return {name: replace(finished, slam=slam, estimate=estimate) for (name, slam), estimate in found}
