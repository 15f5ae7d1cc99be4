"""`lexis-sim bench segmentation`: measures labels, rooms, places, loops, and plans that a robot drives, in preset houses."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from typing import Any

from lexis.config import Config
from lexis.graph.trusted_loops import is_trusted
from sim.bench.houses import for_seeds
from sim.bench.row_files import mean_and_std
from sim.harness import Scenario, evaluate, run, try_plans
from sim.harness.adapters import Lexis
from sim.harness.loops import edge_truth


@dataclass(frozen=True)
class SegmentationRow:
    """The figures of a run in one house: labels, rooms, floors, places, loops and plans."""

    baseline: float | None
    """Label accuracy before refinement."""
    refined: float | None
    """Label accuracy after refinement."""
    pq: float | None
    """Panoptic quality of rooms."""
    floors: float | None
    """Share of keyframes with the right floor."""
    odometry_m: float | None
    """Absolute trajectory error of the odometry [m]."""
    ate_m: float | None
    """Absolute trajectory error of the optimised trajectory [m]."""
    place_recall: float | None
    """Share of the revisits for which place recognition proposes an earlier keyframe at the same place; None without
    revisits. See `lexis.evaluation.place_recognition.MatchCounts` for N = 1."""
    false_loops: int
    trusted_false_loops: int
    """Number of false loop edges that are trusted after the optimisation."""
    loop_recall: float | None
    """Share of revisits with a true loop edge; None if there were no revisits."""
    plans: float | None
    """Share of plans whose drive reached the goal; None if there were no plans."""
    spl: float | None
    """Success weighted by path length of the plans."""
    touched: int | None
    """Number of drives that ended in a collision."""


def run_houses(
    scenario: Scenario, seeds: Sequence[int], openness: float | None = None, settings: Config | None = None
) -> Iterator[tuple[int, SegmentationRow]]:
    """Make one run for each scenario of `sim.bench.houses.for_seeds`; yield the seed and the figures of each run.

    The first three arguments are those of `for_seeds`; `settings` are those of LEXIS.
    """
    slam = Lexis(scenario.encoder, settings)
    for own in for_seeds(scenario, seeds, openness):
        finished = run(own, slam)
        result = evaluate(finished, try_plans(finished))
        loops, is_true = finished.estimate.loops, edge_truth(finished)
        assert loops is not None and loops.weights is not None
        places = result.place_recognition["1"]
        yield (
            own.seed,
            SegmentationRow(
                result.labels.accuracy_baseline,
                result.labels.accuracy,
                result.rooms.pq,
                result.floors.accuracy,
                result.trajectory.ate_odometry_m,
                result.trajectory.ate_m,
                places.tp / places.possible if places.tp is not None and places.possible else None,
                int((~is_true).sum()),
                int(is_trusted(loops.weights[~is_true]).sum()),
                result.loops.recall,
                result.planning.success,
                result.planning.spl,
                result.planning.collisions,
            ),
        )


def means_and_stds(rows: Sequence[Any]) -> tuple[list[float | None], list[float | None]]:
    """Return the means and the standard deviations of all fields of `rows`, in the order of the fields.

    `rows` are dataclasses with one figure per field. A figure that is None is left out. If a field has no figures, its mean
    and standard deviation are None.
    """
    columns = [mean_and_std(column) for column in zip(*map(astuple, rows), strict=True)]
    return [mean for mean, _ in columns], [std for _, std in columns]
