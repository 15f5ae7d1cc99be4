"""`lexis-sim bench planning`: drives between the same rooms with different pose estimates, with and without the range scan.

In each drive, the waypoints and the robot's pose come from the same source: LEXIS, the truth or odometry alone. A blind
robot does not use its scan to avoid obstacles.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from lexis.evaluation.planning import spl, success_rate
from lexis.files.replace import replaced_file
from sim.bench.houses import for_seeds
from sim.errors import SimError
from sim.harness import Run, Scenario, run, try_plans
from sim.harness.adapters import Lexis
from sim.harness.planning import Steering
from sim.harness.trial import Trial
from sim.output_files import make_output_folder
from sim.report.drive_picture import drive_png

DRIVERS: "MappingProxyType[str, tuple[Steering, bool]]" = MappingProxyType(
    {
        "truth": ("truth", False),
        "LEXIS": ("estimate", False),
        "odometry": ("odometry", False),
        "LEXIS, blind": ("estimate", True),
        "odometry, blind": ("odometry", True),
    }
)
"""Drivers by name: the source of waypoints and pose, and whether the robot is blind. All drivers follow plans of LEXIS."""


@dataclass(frozen=True)
class PlanningRow:
    """Results of one driver on all plans of a house."""

    seed: int
    driver: str
    queries: int
    success: float | None
    spl: float | None
    touched: int
    """Number of drives that ended in a collision."""
    seconds: float
    """Wall time for all queries together [s]."""


def drive_houses(
    scenario: Scenario,
    seeds: Sequence[int],
    pictures: Path | None = None,
    openness: float | None = None,
    drivers: Sequence[str] = tuple(DRIVERS),
) -> Iterator[PlanningRow]:
    """Make one run per seed, with all other settings from `scenario`, and let every driver drive all plans of the run.

    For `openness` see `sim.bench.houses.for_seeds`. `drivers` are names in `DRIVERS`. `pictures` is a folder for PNGs of the
    failed drives of the driver LEXIS. Raises `SimError` if that folder cannot be made, or for an unknown driver.
    """
    for driver in drivers:
        if driver not in DRIVERS:
            raise SimError(f"no driver {driver!r}; valid: {', '.join(map(repr, DRIVERS))}")
    if pictures is not None:
        make_output_folder(pictures)
    slam = Lexis(scenario.encoder)
    for own in for_seeds(scenario, seeds, openness):
        finished = run(own, slam)
        for driver in drivers:
            steering, blind = DRIVERS[driver]
            start = time.perf_counter()
            trials = try_plans(finished, steering, blind)
            yield _row(own.seed, driver, trials, time.perf_counter() - start)
            if pictures is not None and driver == "LEXIS":
                _draw(finished, trials, pictures)


def _row(seed: int, driver: str, trials: Sequence[Trial], seconds: float) -> PlanningRow:
    success = np.array([trial.success for trial in trials], bool)
    shortest, travelled = np.array([(t.shortest_m, t.travelled_m) for t in trials], float).reshape(-1, 2).T
    touched = sum(trial.collisions for trial in trials)
    return PlanningRow(seed, driver, len(trials), success_rate(success), spl(success, shortest, travelled), touched, seconds)


def _draw(finished: Run, trials: Sequence[Trial], folder: Path) -> None:
    for trial in trials:
        if not trial.success and len(trial.path):
            name = f"{finished.scenario.seed} {trial.start} to {trial.goal}.png".replace(" ", "-").replace("'", "")
            with replaced_file(folder / name) as beside:
                beside.write_bytes(drive_png(finished.house, trial.planned, trial.path, trial.touched))
