"""`report_data`: converts a run to the plain data that a report shows."""

import math
from collections.abc import Mapping, Sequence
from typing import SupportsFloat

import numpy as np
from jaxtyping import Bool, Float, Float64, Int

from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD
from lexis.evaluation.relative import separation
from lexis.evaluation.trajectory import aligned
from lexis.maths.se3 import between
from lexis.maths.ties import rounded
from sim.harness.diagnosis.usual_mistakes import usual_mistakes
from sim.harness.finished_run import Run
from sim.harness.loops import edge_truth
from sim.harness.results import RunResult
from sim.harness.trial import Trial
from sim.report.data import UNKNOWN, CandidateMark, KeyframeTable, LoopMark, PlanPath, ReportData, SampleFrame, ShownFailure
from sim.report.house_plan import floor_plans
from sim.robot.drive import DROP
from worlds.truth import NOWHERE, room_at

_SAMPLES = 6
_SCORES = 3


def report_data(
    run: Run, result: RunResult, trials: Sequence[Trial] = (), failure: ShownFailure | None = None
) -> ReportData:
    """Collect the data of a run that `sim.report.write_report` shows."""
    return ReportData(
        result.data(),
        run.room_names,
        floor_plans(run.house),
        _keyframes(run),
        _loops(run),
        _samples(run),
        tuple(_plan(run, trial) for trial in trials),
        faults_of_images=run.session.faults_of_images,
        unseen_rooms=run.unseen_rooms,
        candidates=_candidates(run),
        failure=failure,
        estimates_poses=run.estimate.T_W_B is not None,
        mistakes=tuple(usual_mistakes(run)),
    )


def _keyframes(run: Run) -> KeyframeTable:
    truth, estimate = run.true_poses, run.estimate
    odometry = aligned(run.odometry_poses, truth)
    unknown = np.full(len(truth), UNKNOWN)
    return KeyframeTable(
        run.true_stamps,
        truth,
        odometry,
        odometry if estimate.T_W_B is None else aligned(estimate.T_W_B, truth),
        run.true_storeys,
        run.true_labels,
        unknown if estimate.baseline_labels is None else estimate.baseline_labels,
        unknown if estimate.labels is None else estimate.labels,
        tuple(run.house.rooms[room].id for room in run.true_rooms),
        _room_of_frames(run),
    )


def _room_of_frames(run: Run) -> tuple[str, ...]:
    """Return the name of the estimated room instance of every frame; "" for a frame in no room."""
    rooms = run.estimate.rooms
    if rooms is None:
        return ("",) * len(run.estimate.frames)
    return tuple(run.estimated_rooms.get(room, "") for room in rooms.tolist())


def _plan(run: Run, trial: Trial) -> PlanPath:
    reason = "" if trial.success else _why_failed(run, trial)
    return PlanPath(trial.start, trial.goal, trial.path, trial.success, reason, trial.room, trial.shortest_m or None)


def _why_failed(run: Run, trial: Trial) -> str:
    if trial.refusal:
        return trial.refusal
    if trial.touched:
        return "came to a drop" if DROP in trial.touched else f"ran into {trial.touched[0]}"
    # Heights of keyframes sway with the walk: a point at eye height is in the room, a point near its floor may be below it.
    intended = _room(run, trial.planned[-1] + [0.0, 0.0, run.session.tour.eye_height_m])
    if intended is None or run.house.room_by_id[intended].label != trial.goal:
        return f"the plan itself ends in {intended or 'no room'}, which the SLAM labels {trial.goal}"
    short_m = np.linalg.norm(trial.planned[-1] - trial.path[-1])
    return f"stopped {short_m:.1f} m short of the end of its plan, which is in {intended}"


def _room(run: Run, point: Float64[np.ndarray, "3"]) -> str | None:
    """Return the id of the room that contains a point in W [m]; None outside of all rooms."""
    room = int(room_at(run.house, point[None])[0])
    return None if room == NOWHERE else run.house.rooms[room].id


def _loops(run: Run) -> tuple[LoopMark, ...]:
    loops = run.estimate.loops
    if loops is None:
        return ()
    weights = np.ones(len(loops.query)) if loops.weights is None else loops.weights
    truth = between(run.true_poses[loops.match], run.true_poses[loops.query])
    errors = separation(truth, loops.T_match_query)
    columns = (loops.query, loops.match, edge_truth(run), weights, *errors)
    return tuple(LoopMark(*mark) for mark in zip(*(column.tolist() for column in columns), strict=True))


def _candidates(run: Run) -> tuple[CandidateMark, ...]:
    decisions = run.estimate.decisions or ()
    queries, matches = (np.array([getattr(each, name) for each in decisions], int) for name in ("query", "match"))
    distances_m, angles_rad = separation(run.true_poses[queries], run.true_poses[matches])
    revisits = (distances_m <= PLACE_M) & (angles_rad <= PLACE_RAD)
    truths = zip(decisions, distances_m.tolist(), revisits.tolist(), strict=True)
    return tuple(
        CandidateMark(
            decision.query, decision.match, decision.accepted, decision.reason, _known(decision.figures), distance_m, revisit
        )
        for decision, distance_m, revisit in truths
    )


def _known(figures: Mapping[str, SupportsFloat]) -> dict[str, float]:
    """Return figures as Python's floats, without those that are NaN. A SLAM may give numbers of any type."""
    numbers = {name: float(value) for name, value in figures.items()}
    return {name: value for name, value in numbers.items() if not math.isnan(value)}


def _samples(run: Run) -> tuple[SampleFrame, ...]:
    """Render up to six frames with a right label and six with a wrong label, those of which the SLAM was most sure.

    The labels are those before refinement.
    """
    similarities, baseline = run.estimate.similarities, run.estimate.baseline_labels
    if run.scenario.fidelity != "render" or similarities is None or baseline is None:
        return ()
    ranked = np.sort(similarities, axis=1)
    margin = ranked[:, -1] - ranked[:, -2] if ranked.shape[1] > 1 else ranked[:, -1]
    wrong = baseline != run.true_labels
    chosen = [*_surest(margin, ~wrong, run.true_rooms), *_surest(margin, wrong, run.true_rooms)]
    pictures = run.session.pictures(run.estimate.frames[chosen].tolist())
    return tuple(SampleFrame(k, image, run.most_similar(k, _SCORES)) for k, image in zip(chosen, pictures, strict=True))


def _surest(margin: Float[np.ndarray, "n"], eligible: Bool[np.ndarray, "n"], rooms: Int[np.ndarray, "n"]) -> list[int]:
    """Return the rows of the eligible frames with the largest margins, in the order of time.

    At most six rows are chosen, and at most one of each true room.
    """
    best: dict[int, int] = {}
    for k in np.argsort(-rounded(margin), kind="stable").tolist():
        if eligible[k]:
            best.setdefault(int(rooms[k]), k)
    return sorted(list(best.values())[:_SAMPLES])
