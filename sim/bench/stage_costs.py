"""`lexis-sim bench stages`: how much each stage costs in labels, rooms, trajectories and plans, over many houses.

LEXIS maps every house as it is, and once more for each substitution of the blame table
(`sim.harness.failures.blame_table`). A substitution puts the truth in the place of one stage, or leaves out one difficulty.
The gain of a substitution is the cost of its stage.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import astuple, dataclass, fields
from warnings import catch_warnings

import numpy as np

from lexis.errors import PlanError
from sim.bench.row_files import grouped
from sim.harness import Scenario, evaluate
from sim.harness.adapters import Lexis
from sim.harness.failures.blame_table import substitutions
from sim.harness.finished_run import Run
from sim.harness.planning import planned_pairs
from sim.harness.run_settings import with_listed_house
from sim.harness.runner import run
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ
from sim.processes import process_pool, usable_cores

UNCHANGED = "nothing"
"""Name of the substitution that replaces nothing."""


@dataclass(frozen=True)
class Figures:
    """The figures of one run."""

    labels: float
    """Share of the keyframes with the right label."""
    rooms: float
    """Panoptic quality of the rooms."""
    ate_m: float
    """Absolute trajectory error [m]."""
    plans: float
    """Share of the plans, from each estimated label to each other one, that end in a room truly labelled as the goal."""


@dataclass(frozen=True)
class StageRow:
    """The figures of one house with one substitution."""

    preset: str
    seed: int
    replaced: str
    """Name of the substitution, such as "oracle encoder", or of a changed setting; `UNCHANGED` if nothing is replaced."""
    labels: float
    rooms: float
    ate_m: float
    plans: float


@dataclass(frozen=True)
class StageGain:
    """The change of the figures by one substitution: means over the houses in which it can be made."""

    houses: int
    mean: Figures
    error: Figures
    """Standard errors of the means; NaN for a single house."""


def measure_stages(presets: Sequence[str], seeds: Sequence[int]) -> Iterator[list[StageRow]]:
    """Yield the rows of each house as soon as it is finished, on the feature sensor, in as many processes as cores."""
    with process_pool(usable_cores()) as pool:
        houses = [pool.submit(measure_house, preset, seed) for preset in presets for seed in seeds]
        for finished in as_completed(houses):
            yield finished.result()


def measure_house(preset: str, seed: int) -> list[StageRow]:
    """Map a house with each substitution. Substitutions that would leave the scenario as it is are left out."""
    usual = Scenario(preset=preset, seed=seed, fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ)
    scenario, lexis = with_listed_house(usual), Lexis(usual.encoder)
    tried = [(UNCHANGED, scenario, lexis.with_stages())]
    tried += [
        (each.name, each.scenario, each.slam or lexis.with_stages())
        for each in substitutions(scenario, lexis)
        if each.slam is not None or each.scenario != scenario
    ]
    rows = []
    for name, changed, slam in tried:
        rows.append(StageRow(preset, seed, name, *astuple(figures_of(run(changed, slam), slam))))
    return rows


def gains(rows: Sequence[StageRow]) -> dict[str, StageGain]:
    """Average the paired differences to the unchanged run, by substitution. `UNCHANGED` has the figures themselves.

    Each figure is over the houses that have it; NaN if there are none.
    """
    unchanged = {(row.preset, row.seed): _values(row) for row in rows if row.replaced == UNCHANGED}
    found = {}
    for (name,), mine in grouped(rows, "replaced").items():
        values = np.array([_values(row) for row in mine])
        if name != UNCHANGED:
            values = values - [unchanged[row.preset, row.seed] for row in mine]
        known = np.isfinite(values).sum(axis=0)
        with catch_warnings(action="ignore", category=RuntimeWarning):  # numpy warns of a figure that no house has
            mean, std = np.nanmean(values, axis=0), np.nanstd(values, axis=0)
        error = np.where(known > 1, std / np.sqrt(np.maximum(known - 1, 1)), np.nan)
        found[name] = StageGain(len(mine), Figures(*mean.tolist()), Figures(*error.tolist()))
    return found


def _values(row: StageRow) -> list[float]:
    return [getattr(row, field.name) for field in fields(Figures)]


def figures_of(finished: Run, slam: Lexis) -> Figures:
    """Return the figures of a finished run of LEXIS."""
    result = evaluate(finished)
    labels, rooms, ate_m = (result.known(name) for name in ("labels.accuracy", "rooms.pq", "trajectory.ate_m"))
    return Figures(labels, rooms, ate_m, _right_plans(finished, slam))


def _right_plans(finished: Run, slam: Lexis) -> float:
    """Share of the plans whose last keyframe is truly in a room of the goal's label; NaN if there is nothing to plan."""
    pairs = planned_pairs(finished)
    right = sum(_ends_right(finished, slam, start, goal) for start, goal in pairs)
    return right / len(pairs) if pairs else np.nan


def _ends_right(finished: Run, slam: Lexis, start: str, goal: str) -> bool:
    try:
        plan = slam.plan(start, goal)
    except PlanError:
        return False
    return bool(finished.true_labels[plan[-1]] == finished.room_names.index(goal))
