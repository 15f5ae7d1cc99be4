"""`lexis-sim bench odometry`: maps with three presets of odometry, and maps of walks on which the odometry fails.

Each house is walked once for each case of `CASES`, always along the same path. The kidnapped robot skips a part of the path.
A walk that ends before its fault begins is left out.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from lexis.graph.trusted_loops import is_trusted
from lexis.graph.walked_steps import carried_before
from sim.bench.row_files import grouped, mean_and_std
from sim.errors import SimError
from sim.faults.poses import Kidnap, OdometryFreeze, OdometryJump
from sim.fidelity import Fidelity
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
from sim.harness.finished_run import Run
from sim.harness.loops import edge_truth
from sim.harness.results import RunResult
from sim.harness.world_tests import usual_rate_hz
from sim.tours.config import TourKind

USUAL = "multicam"
"""The case with which the labels of the others are compared: usual odometry without a fault."""
CASES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        USUAL: {"odometry": USUAL},
        "mono": {"odometry": "mono"},
        "degraded": {"odometry": "degraded"},
        "odometry-jump": {"faults": (OdometryJump(at_s=40.0),)},
        "odometry-freeze": {"faults": (OdometryFreeze(at_s=40.0),)},
        "kidnap": {"faults": (Kidnap(at_s=40.0, skip_s=10.0),)},
    }
)
"""Settings of scenarios by the name of the case. The faults begin 40 s after the start of the walk."""


@dataclass(frozen=True)
class OdometryRow:
    """Figures of one walk. A figure that the walk cannot have is None."""

    case: str
    seed: int
    odometry_m: float | None
    """Absolute trajectory error (ATE) of the odometry [m]."""
    ate_m: float | None
    """ATE of LEXIS [m]."""
    labels: float | None
    """Share of the keyframes with the right label."""
    rooms: float | None
    """Panoptic quality of the rooms."""
    refused: int
    """Number of loop candidates that PnP confirmed, and that LEXIS refused because they are far from its estimate, without
    those that became loop edges when the map was corrected."""
    false: int
    """Number of loop edges that are trusted and false."""
    is_corrected: bool
    """Whether LEXIS states that the robot was carried elsewhere, and has corrected its map."""


@dataclass(frozen=True)
class CaseSummary:
    """Figures of one case over the houses that have them; None if no house has them."""

    houses: int
    odometry_m: float | None
    ate_m: float | None
    """Means of the ATE of the odometry and of LEXIS [m]."""
    share_of_odometry: float | None
    """Mean over the houses of the ATE of LEXIS, divided by that of the odometry on the same walk."""
    largest_excess_m: float | None
    """Largest difference between the ATE of LEXIS and that of the odometry on the same walk [m]; negative if LEXIS has a
    smaller error in every house."""
    labels: float | None
    labels_gained: float | None
    """Means of the labels, and of their difference from those of the case `USUAL` in the same house."""
    rooms: float | None
    refused: float | None
    """Means of the panoptic quality of rooms, and of the number of refused loop candidates."""
    false: int
    """Number of trusted false loop edges in all houses."""
    corrected: int
    """Number of maps that LEXIS has corrected."""


def measure_odometry(
    cases: Sequence[str], preset: str, seeds: Sequence[int], fidelity: Fidelity, tour: TourKind
) -> Iterator[OdometryRow]:
    """Walk a house for each seed in each of the `cases`, and yield the figures of every walk that its fault has changed.

    Raises `SimError` for a case that is no key of `CASES`.
    """
    for case in cases:
        if case not in CASES:
            raise SimError(f"unknown case {case!r}; valid: {', '.join(map(repr, CASES))}")
    usual = Scenario(preset=preset, tour_kind=tour, fidelity=fidelity, frame_rate_hz=usual_rate_hz(fidelity))
    slam = Lexis(usual.encoder)
    for seed in seeds:
        for case in cases:
            finished = run(replace(usual, seed=seed, **CASES[case]), slam)
            result = evaluate(finished)
            if result.faults is None or all(result.faults.frames.values()):
                yield _row(case, finished, result, slam)


def _row(case: str, finished: Run, result: RunResult, slam: Lexis) -> OdometryRow:
    loops = finished.estimate.loops
    assert loops is not None and loops.weights is not None
    return OdometryRow(
        case=case,
        seed=finished.scenario.seed,
        odometry_m=result.trajectory.ate_odometry_m,
        ate_m=result.trajectory.ate_m,
        labels=result.labels.accuracy,
        rooms=result.rooms.pq,
        refused=sum(decision.outcome == "far from the estimate" for decision in slam.map.decisions),
        false=int((is_trusted(loops.weights) & ~edge_truth(finished)).sum()),
        is_corrected=len(carried_before(slam.map)) > 0,
    )


def summary(rows: Sequence[OdometryRow]) -> dict[str, CaseSummary]:
    """Summarise the walks of each case over the houses."""
    usual = {row.seed: row.labels for row in rows if row.case == USUAL}
    return {case: _summary(mine, usual) for (case,), mine in grouped(rows, "case").items()}


def _summary(rows: Sequence[OdometryRow], usual: Mapping[int, float | None]) -> CaseSummary:
    errors = [(row.ate_m, row.odometry_m) for row in rows if row.ate_m is not None and row.odometry_m is not None]
    labels = [(row.labels, usual.get(row.seed)) for row in rows]
    return CaseSummary(
        houses=len(rows),
        odometry_m=_mean(row.odometry_m for row in rows),
        ate_m=_mean(row.ate_m for row in rows),
        share_of_odometry=_mean(ate / odometry for ate, odometry in errors if odometry),
        largest_excess_m=max((ate - odometry for ate, odometry in errors), default=None),
        labels=_mean(row.labels for row in rows),
        labels_gained=_mean(own - other for own, other in labels if own is not None and other is not None),
        rooms=_mean(row.rooms for row in rows),
        refused=_mean(row.refused for row in rows),
        false=sum(row.false for row in rows),
        corrected=sum(row.is_corrected for row in rows),
    )


def _mean(figures: Iterator[float | None]) -> float | None:
    return mean_and_std(figures)[0]
