"""From a run to the data shown in its report."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from helpers.map_builder import corridor_with_offices

from sim.errors import EstimateError
from sim.harness import CandidateDecision, Scenario, evaluate, run
from sim.harness.adapters import Lexis
from sim.harness.adapters.lexis import estimate_of
from sim.harness.estimate import EstimatedLoops
from sim.harness.report_data import report_data
from sim.harness.trial import Trial
from sim.report import render_report
from sim.robot.drive import DROP
from worlds.presets import sample_from_rooms

CONFIG = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom", "bathroom"), seed=21), seed=5, fidelity="features", length_m=24.0,
    frame_rate_hz=4.0, odometry="degraded",
)  # fmt: skip


@pytest.fixture(scope="module")
def finished():
    return run(CONFIG, Lexis(loops=False))


def test_equal_trajectories_have_equal_curves(finished):
    """Without loops, the optimised trajectory is the odometry, moved as a whole."""
    table = report_data(finished, evaluate(finished)).keyframes
    assert table.odometry_errors.max() > 0.02
    np.testing.assert_allclose(table.estimated_errors, table.odometry_errors, atol=1e-9)
    rmse = np.sqrt(np.mean(table.odometry_errors**2))
    assert rmse == pytest.approx(evaluate(finished).trajectory.ate_odometry_m)


def test_odometry_in_another_frame_has_the_same_curve(finished):
    T = np.array([[0.0, -1.0, 0.0, 5.0], [1.0, 0.0, 0.0, -3.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]])
    turned = {frame: given._replace(T_O_B=T @ given.T_O_B) for frame, given in finished.given.items()}
    table = report_data(replace(finished, given=turned), evaluate(finished)).keyframes
    np.testing.assert_allclose(table.odometry_errors, table.estimated_errors, atol=1e-9)


def test_a_failed_plan_says_where_it_ended_and_why(finished):
    eye = finished.session.tour.eye_height_m
    feet = finished.true_poses[:, :3, 3] - [0.0, 0.0, eye]
    labels = [finished.room_names[k] for k in finished.true_labels]
    there, elsewhere = labels.index("kitchen"), labels.index("bedroom")
    room = finished.house.rooms[int(finished.true_rooms[elsewhere])].id

    def plan(end, planned, touched=(), success=False):
        path = feet[[end, end]]
        trial = Trial("bathroom", "kitchen", success, 3.0, 0.0, touched, room, path, feet[[planned]])
        (shown,) = report_data(finished, evaluate(finished), [trial]).paths
        return shown.ended, shown.reason

    metres = np.linalg.norm(feet[there] - feet[elsewhere])
    assert plan(elsewhere, there)[0] == room
    assert plan(elsewhere, there)[1].startswith(f"stopped {metres:.1f} m short of the end of its plan, which is in ")
    assert plan(elsewhere, elsewhere)[1].startswith(f"the plan itself ends in {room}, ")
    assert plan(elsewhere, there, ("sofa#1",))[1] == "ran into sofa#1"
    assert plan(elsewhere, there, (DROP,))[1] == "came to a drop"
    assert plan(there, there, success=True)[1] == ""
    nothing = np.zeros((0, 3))
    trial = Trial("a", "b", False, 0.0, 0.0, (), None, nothing, nothing, "no plan was found")
    (unplanned,) = report_data(finished, evaluate(finished), [trial]).paths
    assert (unplanned.ended, unplanned.reason, unplanned.shortest_m) == (None, "no plan was found", None)
    undriven = Trial("bathroom", "kitchen", False, 0.0, 0.0, (), None, nothing, feet[[there]], "no way")
    (shown,) = report_data(finished, evaluate(finished), [undriven]).paths
    assert shown.ended is None and shown.reason == "no way"


def test_candidates_carry_the_reasons_that_the_slam_estimates_and_the_truth(finished):
    estimates = (
        CandidateDecision(9, 0, accepted=False, reason="few matches", figures={"matches": 4.0}),
        CandidateDecision(8, 8, accepted=True, reason="accepted", figures={}),
    )
    estimated = replace(finished, estimate=replace(finished.estimate, decisions=estimates))
    far, same = report_data(estimated, evaluate(estimated)).candidates
    assert (far.query, far.match, far.accepted, far.reason, far.figures) == (9, 0, False, "few matches", {"matches": 4.0})
    metres = np.linalg.norm(finished.true_poses[9, :3, 3] - finished.true_poses[0, :3, 3])
    assert far.distance_m == pytest.approx(metres) and not far.revisit
    assert same.accepted and same.revisit and same.distance_m < 1e-9


def test_the_page_shows_figures_of_any_kind_of_number(finished):
    figures = {"inliers": Fraction(7, 2), "matches": np.float32(4.0), "misfit [m]": math.nan}
    loops = EstimatedLoops(np.array([9]), np.array([0]), np.tile(np.eye(4), (1, 1, 1)))
    loops.T_match_query[0, 0, 3] = 99.0
    decisions = (CandidateDecision(9, 0, accepted=True, reason="accepted", figures=figures),)
    estimated = replace(finished, estimate=replace(finished.estimate, decisions=decisions, loops=loops))
    page = render_report(report_data(estimated, evaluate(estimated)))
    false_loops = page.partition("<h2>False loops</h2>")[2].partition("</table>")[0]
    assert ">3.5<" in false_loops and ">4<" in false_loops and "misfit" not in false_loops


def test_decisions_on_frames_that_do_not_exist_are_refused(finished):
    with pytest.raises(EstimateError, match="decisions refer to rows"):
        replace(finished.estimate, decisions=(CandidateDecision(10**6, 0, False, "few matches", {}),))


def test_lexis_estimates_what_became_of_every_candidate():
    lexis_map = corridor_with_offices(np.random.default_rng(1), loops=[(25, 3)], weights=[1.0], refused=[1])
    accepted, refused = estimate_of(lexis_map).decisions
    assert accepted.accepted and accepted.figures["misfit [m]"] == 0.25 and accepted.figures["inliers"] == 20.0
    assert (refused.query, refused.match, refused.accepted, refused.reason) == (25, 1, False, "few matches")
    assert refused.figures == {"matches": 3.0}
