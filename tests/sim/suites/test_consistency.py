"""A law about a single run holds for LEXIS, and fails once one estimate contradicts another."""

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from lexis.maths.se3 import between, exp
from sim.faults import parse_fault
from sim.harness import Estimate, Lexis, run
from sim.harness.adapters import OdometryOnly
from sim.harness.estimate import EstimatedLoops
from sim.harness.figures import EvaluatedRun, evaluate
from sim.suites.consistency import (
    CONSISTENCY,
    LastLoopsFit,
    fitting_loops_are_trusted,
    floors_are_level,
    loops_join_visits,
    rooms_are_uniform,
    steps_follow_odometry,
    trusted_loops_fit,
)

LAST_LOOPS_FIT = LastLoopsFit(end_m=1.0, most_m=0.07, ratio=2.0)


@pytest.fixture(scope="module")
def lexis():
    return run(replace(OPEN_FLAT, length_m=50.0), Lexis("oracle"))


def estimating(finished, **estimates):
    return replace(finished, estimate=replace(finished.estimate, **estimates))


@pytest.mark.parametrize("law", CONSISTENCY, ids=lambda law: law.name)
def test_lexis_does_not_contradict_itself(law, lexis):
    about_stairs = law.name in ("labels on stairs", "a staircase is one room")  # there are none
    assert law.find(lexis).holds is (None if about_stairs else True)


def test_odometry_follows_itself_and_is_not_judged_by_what_it_does_not_estimate():
    finished = run(OPEN_FLAT, OdometryOnly())
    assert [law.find(finished).holds for law in CONSISTENCY] == [True, *[None] * (len(CONSISTENCY) - 1)]


def test_a_jump_of_the_trajectory_is_found(lexis):
    poses = lexis.estimate.T_W_B.copy()
    poses[len(poses) // 2 :, 0, 3] += 1.0
    found = steps_follow_odometry(estimating(lexis, T_W_B=poses))
    jump_m = float(re.search(r"by ([\d.]+) m,", found.measured)[1])
    assert found.holds is False and jump_m == pytest.approx(1.0, abs=0.1)  # the step was also corrected by loops


def test_a_single_frame_has_no_steps(lexis):
    only = Estimate(lexis.estimate.frames[:1], lexis.estimate.T_W_B[:1])
    assert steps_follow_odometry(replace(lexis, estimate=only)).holds is None


def test_loops_that_fit_have_to_be_trusted(lexis):
    loops, poses = lexis.estimate.loops, lexis.estimate.T_W_B
    fitting = replace(loops, T_match_query=between(poses[loops.match], poses[loops.query]), weights=None)
    assert len(loops.query) >= 5 and fitting_loops_are_trusted(estimating(lexis, loops=fitting)).holds is None
    mostly = replace(fitting, weights=np.linspace(0.45, 1.0, len(loops.query)))
    assert fitting_loops_are_trusted(estimating(lexis, loops=mostly)).holds
    doubted = replace(fitting, weights=np.full(len(loops.query), 0.2))
    assert fitting_loops_are_trusted(estimating(lexis, loops=doubted)).holds is False
    few = [values[:4] for values in (doubted.query, doubted.match, doubted.T_match_query, doubted.weights)]
    few_loops = replace(doubted, **dict(zip(("query", "match", "T_match_query", "weights"), few, strict=True)))
    assert fitting_loops_are_trusted(estimating(lexis, loops=few_loops)).holds is None
    far = doubted.T_match_query.copy()
    far[:, 0, 3] += 0.3
    assert fitting_loops_are_trusted(estimating(lexis, loops=replace(doubted, T_match_query=far))).holds is None


def test_a_trusted_loop_that_the_trajectory_does_not_satisfy_is_found_and_an_untrusted_one_is_not(lexis):
    loops = lexis.estimate.loops
    T, weights = loops.T_match_query.copy(), np.ones(len(loops.query))
    T[0, 0, 3] += 3.0
    assert trusted_loops_fit(estimating(lexis, loops=replace(loops, T_match_query=T, weights=None))).holds is None
    assert trusted_loops_fit(estimating(lexis, loops=replace(loops, T_match_query=T, weights=weights))).holds is False
    weights[0] = 0.1
    assert trusted_loops_fit(estimating(lexis, loops=replace(loops, T_match_query=T, weights=weights))).holds


def test_nearly_all_loops_have_to_join_separate_visits(lexis):
    loops = lexis.estimate.loops
    once = np.unique(loops.query, return_index=True)[1]  # one loop for each query, so that no pair is repeated below
    loops = EstimatedLoops(loops.query[once], loops.match[once], loops.T_match_query[once])
    matches = loops.match.copy()
    matches[: len(matches) // 20] = loops.query[: len(matches) // 20] - 1
    assert len(matches) >= 20 and not loops_join_visits(estimating(lexis, loops=replace(loops, match=matches))).holds
    found = loops_join_visits(estimating(lexis, loops=replace(loops, match=loops.query - 1)))
    assert found.holds is False and found.measured.startswith("0.0% of the loop closures and 100.0% of the proposed")
    assert loops_join_visits(estimating(lexis, loops=None, candidates=None)).holds is None


def test_proposed_revisits_of_the_same_visit_are_found(lexis):
    assert loops_join_visits(lexis).holds
    recent = tuple((query, (query - 1,)) for query, matches in lexis.estimate.candidates if matches)
    found = loops_join_visits(estimating(lexis, candidates=recent))
    assert (
        found.holds is False and "0.0% of the proposed revisits join frames that are at least 10 s apart" in found.measured
    )


def test_loops_at_the_end_of_the_walk_have_to_fit_as_well_as_the_others(lexis):
    fitting = with_loops_at_the_end(lexis, 3)
    assert LAST_LOOPS_FIT(estimating(lexis, loops=fitting)).holds
    at_end = are_at_the_end(lexis, fitting.query)
    T = fitting.T_match_query.copy()
    T[at_end, 0, 3] += 0.1
    found = LAST_LOOPS_FIT(estimating(lexis, loops=replace(fitting, T_match_query=T)))
    assert found.holds is False and "by 0.1 m, others by" in found.measured
    T[~at_end, 0, 3] += 0.1  # a SLAM whose loop closures are less accurate
    assert LAST_LOOPS_FIT(estimating(lexis, loops=replace(fitting, T_match_query=T))).holds
    assert LAST_LOOPS_FIT(estimating(lexis, loops=replace(fitting, weights=None))).holds is None
    doubted = replace(fitting, T_match_query=T, weights=np.where(at_end, 0.1, 1.0))
    assert LAST_LOOPS_FIT(estimating(lexis, loops=doubted)).holds is None


def test_one_or_two_loops_at_the_end_of_the_walk_are_too_few_to_judge(lexis):
    for count, holds in ((1, None), (2, None), (3, False)):
        loops = with_loops_at_the_end(lexis, count)
        T = loops.T_match_query.copy()
        T[are_at_the_end(lexis, loops.query), 0, 3] += 0.3
        found = LAST_LOOPS_FIT(estimating(lexis, loops=replace(loops, T_match_query=T)))
        assert found.holds is holds


def with_loops_at_the_end(finished, count):
    """Return the loop closures of a run, with `count` of them at the end of the walk; all are trusted, and fit exactly."""
    loops, last = finished.estimate.loops, len(finished.estimate.frames) - 1
    earlier = ~are_at_the_end(finished, loops.query)
    query, match = np.append(loops.query[earlier], [last] * count), np.append(loops.match[earlier], range(count))
    T = between(finished.estimate.T_W_B[match], finished.estimate.T_W_B[query])
    return replace(loops, query=query, match=match, T_match_query=T, weights=np.ones(len(query)))


def are_at_the_end(finished, frames):
    """Return which frames are at most 1 m from the end of the walk, along the path of the odometry."""
    steps = np.linalg.norm(np.diff(finished.odometry_poses[:, :3, 3], axis=0), axis=1)
    return np.append(steps[::-1].cumsum()[::-1], 0.0)[frames] <= 1.0


def test_a_frame_with_another_label_than_its_room_is_found_and_one_without_a_label_is_not(lexis):
    labels = lexis.estimate.labels.copy()
    labels[3] = (labels[3] + 1) % len(lexis.room_names)
    found = rooms_are_uniform(estimating(lexis, labels=labels))
    assert found.holds is False and found.measured.startswith("1 rooms")
    labels[3] = -1
    assert rooms_are_uniform(estimating(lexis, labels=labels)).holds


def test_without_any_room_nothing_can_be_said_about_rooms(lexis):
    none = np.full_like(lexis.estimate.rooms, -1)
    assert rooms_are_uniform(estimating(lexis, rooms=none)).holds is None
    assert rooms_are_uniform(estimating(lexis, labels=none, floors=none)).holds is None


def test_a_room_on_two_floors_is_found_and_one_that_reaches_onto_stairs_is_not(lexis):
    floors = lexis.estimate.floors.copy()
    floors[3] = 1
    assert rooms_are_uniform(estimating(lexis, floors=floors)).holds is False
    floors[3] = -1
    assert rooms_are_uniform(estimating(lexis, floors=floors)).holds


def test_a_floor_that_is_not_level_is_found(lexis):
    poses = lexis.estimate.T_W_B.copy()
    poses[3, 2, 3] += 2.0
    assert floors_are_level(estimating(lexis, T_W_B=poses)).holds is False


def test_floors_that_are_numbered_downwards_are_found(lexis):
    n = len(lexis.estimate.frames)
    poses, floors = lexis.estimate.T_W_B.copy(), np.where(np.arange(n) < n // 2, 0, 1)
    poses[n // 2 :, 2, 3] += 3.0
    assert floors_are_level(estimating(lexis, T_W_B=poses, floors=floors)).holds
    assert floors_are_level(estimating(lexis, T_W_B=poses, floors=1 - floors)).holds is False


def test_heights_are_measured_along_the_vertical_of_the_odometry(lexis):
    tilted = exp(np.array([0.7, 0.4, 0.0, 1.0, 2.0, 3.0])) @ lexis.estimate.T_W_B
    assert floors_are_level(estimating(lexis, T_W_B=tilted)).holds


def test_a_sparse_trajectory_may_correct_more_in_one_step(lexis):
    poses = lexis.estimate.T_W_B.copy()
    poses[len(poses) // 2 :, 0, 3] += 0.4
    assert steps_follow_odometry(estimating(lexis, T_W_B=poses)).holds is False
    length_m = 4.0
    odometry = np.tile(np.eye(4), (2, 1, 1))
    odometry[1, 0, 3] = length_m
    given = {frame: lexis.given[0]._replace(T_O_B=T) for frame, T in zip((0, 1), odometry, strict=True)}
    corrected = odometry.copy()
    corrected[1, 1, 3] = 0.4
    two = Estimate(np.arange(2), T_W_B=corrected)
    assert steps_follow_odometry(replace(lexis, estimate=two, given=given)).holds


def test_a_run_with_faults_is_not_judged(lexis):
    faulty = replace(lexis, scenario=replace(lexis.scenario, faults=(parse_fault("dropped:0.2"),)))
    base = EvaluatedRun(faulty, evaluate(lexis))
    assert all(law.examine(base, Lexis).holds is None for law in CONSISTENCY)
