"""`check` and `evaluate`: compute the figures of a run, as `lexis.evaluation` defines them."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from lexis.config import PlaceRecognitionConfig
from lexis.evaluation.coverage import path_covered
from lexis.evaluation.floors import floor_accuracy, floor_count_error
from lexis.evaluation.labels import accuracy, accuracy_per_room, graded_accuracy
from lexis.evaluation.loops import score_loops
from lexis.evaluation.place_recognition import count_matches, right_matches
from lexis.evaluation.planning import spl, success_rate
from lexis.evaluation.rooms import score_rooms
from lexis.evaluation.trajectory import STRETCHES_M, ate_rmse, rpe_translation
from lexis.maths.paths import arc_length
from lexis.types import Poses
from sim.doctor import versions
from sim.faults import written
from sim.harness.finished_run import Run
from sim.harness.last_run import last_run
from sim.harness.planning import try_plans
from sim.harness.results import (
    MATCHES,
    CoverageFigures,
    FaultFigures,
    FloorFigures,
    HouseFigures,
    LabelFigures,
    LoopFigures,
    MatchFigures,
    PlanningFigures,
    RoomFigures,
    RunResult,
    TimeFigures,
    TrajectoryFigures,
    WalkFigures,
)
from sim.harness.runner import run
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import SlamUnderTest, title_of
from sim.harness.trial import Trial
from worlds.truth import floor_area, openness

_ROUNDING_M = 1e-9
"""Least error of a trajectory that is reported [m]. Smaller errors come from rounding, and are reported as 0."""
_REVISIT = PlaceRecognitionConfig()
"""Settings that say how old a frame must be so that a return to its place counts as a revisit; the same for every SLAM."""


class EvaluatedRun(NamedTuple):
    """A finished run with its figures, and the plans that a robot has driven."""

    run: Run
    result: RunResult
    trials: Sequence[Trial] = ()

    @property
    def scenario(self) -> Scenario:
        """The scenario of the run."""
        return self.run.scenario


def check(scenario: Scenario, slam: SlamUnderTest | None = None) -> RunResult:
    """Run a SLAM (by default LEXIS) on a scenario, let a robot drive its plans, and compute all figures.

    Raises the errors of `run`.
    """
    finished = run(scenario, slam)
    return evaluate(finished, try_plans(finished))


def evaluate(run: Run, trials: Sequence[Trial] = ()) -> RunResult:
    """Compute all figures of a run and of the driven plans; a figure that the run cannot have is None."""
    scenario = run.scenario
    result = RunResult(
        seed=scenario.seed,
        preset=None if scenario.house else scenario.preset,
        fidelity=scenario.fidelity,
        slam=title_of(run.slam),
        encoder=run.estimate.encoder,
        odometry=scenario.odometry,
        house=_house(run),
        run=_walk(run),
        labels=_labels(run),
        rooms=_rooms(run),
        floors=_floors(run),
        loops=_loops(run),
        place_recognition=_place_recognition(run),
        coverage=_coverage(run),
        trajectory=_trajectory(run),
        planning=_planning(trials),
        time=_time(run),
        versions=versions(),
        scenario=scenario.content_hash,
        faults=_faults(run) if scenario.faults else None,
    )
    last_run().evaluated(run, result, trials)
    return result


def _faults(run: Run) -> FaultFigures:
    touched = Counter(name for truth in run.delivered for name in set(truth.faults))
    faults = run.scenario.faults
    frames = {fault.name: touched[fault.name] for fault in faults}
    return FaultFigures(tuple(map(written, faults)), frames, len(run.delivered), len(run.refused))


def _house(run: Run) -> HouseFigures:
    house = run.house
    return HouseFigures(len(house.rooms), len(house.storeys), round(floor_area(house), 2), round(openness(house), 4))


def _walk(run: Run) -> WalkFigures:
    tour = run.session.tour
    return WalkFigures(tour.length_m, _duration_s(run), len(tour.stamps), len(run.estimate.frames))


def _duration_s(run: Run) -> float:
    stamps = run.session.tour.stamps
    return float(stamps[-1] - stamps[0])


def _labels(run: Run) -> LabelFigures:
    labels, baseline = run.estimate.labels, run.estimate.baseline_labels
    before = None if baseline is None else accuracy(baseline, run.true_labels)
    if labels is None:
        return LabelFigures(accuracy_baseline=before)
    return LabelFigures(
        accuracy(labels, run.true_labels),
        before,
        graded_accuracy(labels, run.allowed_labels),
        accuracy_per_room(labels, run.true_labels, run.room_names),
    )


def _rooms(run: Run) -> RoomFigures:
    rooms = run.estimate.rooms
    return RoomFigures() if rooms is None else RoomFigures(**asdict(score_rooms(rooms, run.true_rooms)))


def _floors(run: Run) -> FloorFigures:
    floors = run.estimate.floors
    if floors is None:
        return FloorFigures()
    return FloorFigures(
        floor_accuracy(floors, run.true_floors, run.on_stairs),
        floor_count_error(floors, run.true_floors, run.on_stairs),
    )


def _loops(run: Run) -> LoopFigures:
    loops, candidates = run.estimate.loops, run.estimate.candidates
    if loops is None:
        return LoopFigures()
    proposed = sum(len(matches) for _, matches in candidates or ())
    scores = score_loops(proposed, loops.query, loops.match, loops.T_match_query, run.true_poses, run.true_stamps)
    return LoopFigures(**asdict(scores) | ({} if candidates is not None else {"proposed": None}))


def _place_recognition(run: Run) -> dict[str, MatchFigures]:
    candidates = run.estimate.candidates
    if candidates is None:
        return {str(n): MatchFigures() for n in MATCHES}
    path_m = arc_length(run.odometry_poses[:, :3, 3])
    query, match = right_matches(run.true_poses, run.true_stamps, path_m, _REVISIT)
    right = csr_array((np.ones(len(query), bool), (query, match)), shape=(len(path_m), len(path_m)))
    counts = {str(n): count_matches(candidates, right, n) for n in MATCHES}
    return {n: MatchFigures(**asdict(count), precision=count.precision) for n, count in counts.items()}


def _coverage(run: Run) -> CoverageFigures:
    distances_m = run.session.tour.distances_m
    covered = path_covered(distances_m[run.estimate.frames], float(distances_m[-1]))
    return CoverageFigures(len(set(run.true_rooms.tolist())), len(run.walked_rooms), covered)


def _trajectory(run: Run) -> TrajectoryFigures:
    def errors(poses: Poses) -> tuple[float | None, ...]:
        truth = run.true_poses
        ate_m = ate_rmse(poses[:, :3, 3], truth[:, :3, 3])
        found = ate_m, *(rpe_translation(poses, truth, length_m) for length_m in STRETCHES_M)
        return tuple(0.0 if error is not None and error < _ROUNDING_M else error for error in found)

    ate_odometry_m, rpe_8m_odometry_m, rpe_24m_odometry_m = errors(run.odometry_poses)
    estimated = run.estimate.T_W_B
    ate_m, rpe_8m_m, rpe_24m_m = (None, None, None) if estimated is None else errors(estimated)
    return TrajectoryFigures(
        ate_odometry_m=ate_odometry_m,
        ate_m=ate_m,
        rpe_8m_odometry_m=rpe_8m_odometry_m,
        rpe_8m_m=rpe_8m_m,
        rpe_24m_odometry_m=rpe_24m_odometry_m,
        rpe_24m_m=rpe_24m_m,
    )


def _planning(trials: Sequence[Trial]) -> PlanningFigures:
    success = np.array([trial.success for trial in trials], bool)
    shortest, travelled = np.array([(t.shortest_m, t.travelled_m) for t in trials], float).reshape(-1, 2).T
    collisions = sum(trial.collisions for trial in trials) if trials else None
    return PlanningFigures(len(trials), success_rate(success), spl(success, shortest, travelled), collisions)


def _time(run: Run) -> TimeFigures:
    slam_s = run.seconds["slam_s"]
    factor = _duration_s(run) / slam_s if slam_s else None
    return TimeFigures(**run.seconds, stages_s=dict(run.estimate.stage_seconds), realtime_factor=factor)
