"""Measures by how much rendering and LEXIS slow each other down when they run in parallel, as they do in every run."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from lexis.encoder.open_clip_encoder import load_encoder
from lexis.slam import Slam
from lexis.types import Observation
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.odometry.simulation import Odometry
from sim.render.rig import build_rig
from sim.session import Session
from sim.tours.tour import Tour


@dataclass(frozen=True)
class Seconds:
    """Wall time of some work, and processor time of all its threads together [s]."""

    wall: float
    processor: float


@dataclass(frozen=True)
class Overlap:
    """Times of one repetition: rendering alone, LEXIS alone, then both in parallel."""

    rendering: Seconds
    lexis: Seconds
    both: Seconds
    slower_s: float
    """Time of the slower task while both ran in parallel: the larger of the times of rendering and of LEXIS [s]."""

    @property
    def wall_over_slower_within(self) -> float:
        """Wall time of rendering and LEXIS in parallel, divided by `slower_s`; the excess over 1 is time spent waiting."""
        return self.both.wall / self.slower_s

    @property
    def wall_over_slower_alone(self) -> float:
        """Wall time of both in parallel, divided by the wall time of the slower task alone; 1 is ideal on two free cores."""
        return self.both.wall / max(self.rendering.wall, self.lexis.wall)

    @property
    def extra_work(self) -> float:
        """Processor time of both in parallel, divided by that of both run alone; 1 is ideal, also on a busy machine."""
        return self.both.processor / (self.rendering.processor + self.lexis.processor)


def measure_overlap(scenario: Scenario, frames: int, repetitions: int) -> list[Overlap]:
    """Measure the first `frames` frames of a run, `repetitions` times. LEXIS alone gets images that are kept in memory."""
    walked, encoder, camera = walk(scenario), load_encoder(scenario.encoder), build_rig(scenario.rig).front
    tour, odometry = walked.tour, walked.odometry
    part = Tour(tour.stamps[:frames], tour.T_W_B[:frames], tour.motion, tour.eye_height_m)
    reported = Odometry(odometry.T_O_B[:frames], odometry.increment_covariance[:frames])
    session = Session(walked.house, part, reported, camera, scenario.faults, scenario.seed)

    def lexis(observations: Iterable[Observation]) -> float:
        """Run LEXIS; return the total time spent in its stages [s]."""
        slam = Slam(camera, encoder, walked.house.spec.room_labels)
        for observation in observations:
            slam.process(observation)
        return sum(slam.finish().stage_seconds.values())

    def rendering() -> float:
        """Render all frames and discard them; return the time spent on rendering since the session began [s]."""
        for _ in session:
            pass
        return session.render_seconds

    def repetition() -> Overlap:
        rendered, before = _clocked(rendering)
        alone, _ = _clocked(lambda: lexis(seen))
        both, slam_s = _clocked(lambda: lexis(observation for observation, _ in session))
        return Overlap(rendered, alone, both, max(slam_s, session.render_seconds - before))

    seen = [observation for observation, _ in session]
    lexis(seen[: len(seen) // 4])  # warm-up: torch compiles and allocates at its first use
    return [repetition() for _ in range(repetitions)]


def _clocked(work: Callable[[], float]) -> tuple[Seconds, float]:
    wall, processor = time.perf_counter(), time.process_time()
    value = work()
    return Seconds(time.perf_counter() - wall, time.process_time() - processor), value
