"""`lexis-sim bench rigs`: whether LEXIS recognises places from the opposite direction with each rig, and what a rig costs.

LEXIS maps every house on a walk through all rooms and back along the same path (tour `both ways`), with each rig.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lexis.config import Config
from lexis.evaluation.loops import opposite_edges, opposite_revisits
from lexis.graph.trusted_loops import is_trusted
from sim.bench.row_files import mean_and_std
from sim.fidelity import Fidelity
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
from sim.harness.finished_run import Run
from sim.harness.loops import edge_truth
from sim.harness.world_tests import usual_rate_hz


@dataclass(frozen=True)
class RigRow:
    """Figures of one house with one rig."""

    rig: str
    seed: int
    revisits: int
    """Number of keyframes that revisit a place in the opposite direction alone; see `opposite_revisits`."""
    found: int
    """Number of these keyframes from which a true loop edge leads to a keyframe that looks more than 90 degrees away."""
    trusted: int
    """Number of loop edges that are trusted after the optimisation; see `is_trusted`."""
    false: int
    """Number of trusted loop edges that are false."""
    labels: float | None
    """Share of the keyframes with the right label; None, as the next two figures, if the run cannot have it."""
    rooms: float | None
    """Panoptic quality of the rooms."""
    ate_m: float | None
    """Absolute trajectory error [m]."""
    keyframe_ms: float
    """Time that LEXIS takes for each keyframe, in all stages [ms]."""

    @property
    def recall(self) -> float:
        """Share of the revisits in the opposite direction that are found; NaN without a revisit."""
        return self.found / self.revisits if self.revisits else np.nan


def measure_rigs(
    rigs: Sequence[str], preset: str, seeds: Sequence[int], fidelity: Fidelity, config: Config | None = None
) -> Iterator[RigRow]:
    """Map a house for each seed with each rig, and yield the figures of every run. `config` has the settings of LEXIS."""
    usual = Scenario(preset=preset, tour_kind="both ways", fidelity=fidelity, frame_rate_hz=usual_rate_hz(fidelity))
    slam = Lexis(config=config)
    for seed in seeds:
        for rig in rigs:
            finished = run(replace(usual, seed=seed, rig=replace(usual.rig, name=rig)), slam)
            yield _row(finished, rig, slam)


def _row(finished: Run, rig: str, slam: Lexis) -> RigRow:
    loops, result = finished.estimate.loops, evaluate(finished)
    assert loops is not None and loops.weights is not None
    is_true, trusted = edge_truth(finished), is_trusted(loops.weights)
    stamps = np.array([keyframe.stamp for keyframe in slam.map.keyframes])
    revisits = opposite_revisits(finished.true_poses, stamps)
    across = loops.query[is_true & opposite_edges(loops.query, loops.match, finished.true_poses)]
    return RigRow(
        rig=rig,
        seed=finished.scenario.seed,
        revisits=len(revisits),
        found=int(np.isin(revisits, across).sum()),
        trusted=int(trusted.sum()),
        false=int((trusted & ~is_true).sum()),
        labels=result.labels.accuracy,
        rooms=result.rooms.pq,
        ate_m=result.trajectory.ate_m,
        keyframe_ms=1e3 * sum(slam.map.stage_seconds.values()) / len(stamps),
    )


def summary(rows: Sequence[RigRow]) -> Iterator[RigRow]:
    """Yield one row for each rig, with the seed -1: sums of the counts, and means of the other figures.

    A figure that a house does not have is left out; its mean is None if no house has it.
    """
    for rig in dict.fromkeys(row.rig for row in rows):
        mine = [row for row in rows if row.rig == rig]
        counts = np.sum([(row.revisits, row.found, row.trusted, row.false) for row in mine], axis=0)
        averaged = ("labels", "rooms", "ate_m", "keyframe_ms")
        figures = [*counts.tolist(), *(mean_and_std(getattr(row, name) for row in mine)[0] for name in averaged)]
        yield RigRow(rig, -1, *figures)
