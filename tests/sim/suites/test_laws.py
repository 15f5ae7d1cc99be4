"""Laws hold for LEXIS, fail for a SLAM that breaks them, and say nothing where nothing can be compared."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.flat_suite import FLAT, ORIGIN, PART, Oracle, flat, outcomes
from helpers.open_flat import OPEN_FLAT

from lexis.config import Config, VerificationConfig
from sim.harness import Estimate, Lexis, Scenario
from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.crash import COMPLETES
from sim.harness.estimate import EstimatedLoops
from sim.suites.catalogue import SUITES
from sim.suites.checks import AfterChange, CheckFinding, NotWorse, SameEstimates, evaluated_run
from sim.suites.examination import Examination, jobs_of
from sim.suites.frame_changes import MovedOrigin
from sim.suites.laws import LAWS
from sim.suites.report import SuiteReport, check_slam
from sim.suites.stream_changes import NoChange, Slip
from sim.suites.suite import Suite, SuitePart


class LoopsWithoutCorrection(Oracle):
    """LEXIS that estimates the poses of the odometry, which its loops do not fit."""

    def start(self, camera, room_names):
        super().start(camera, room_names)
        self._odometry = {}

    def process(self, observation):
        self._odometry[observation.index] = observation.T_O_B.copy()
        super().process(observation)

    def finish(self):
        estimates = super().finish()
        return replace(estimates, T_W_B=np.stack([self._odometry[frame] for frame in estimates.frames.tolist()]))


class LoopsOnce(OdometryOnly):
    """Estimates one loop closure in every second run, and none in the others."""

    runs = 0

    def finish(self):
        type(self).runs += 1
        estimates = super().finish()
        many = self.runs % 2
        rows = np.arange(many), np.arange(many)
        return replace(
            estimates, loops=EstimatedLoops(rows[0] + len(estimates.frames) - 1, rows[1], np.tile(np.eye(4), (many, 1, 1)))
        )


def test_a_run_without_loop_closures_still_estimates_them():
    law = SameEstimates("again", "Twice the same.", NoChange(), compares=("frames",))
    assert law.examine(evaluated_run(OPEN_FLAT, LoopsOnce), LoopsOnce).holds
    needing = replace(law, needs=("loops",))
    LoopsOnce.runs = 1
    assert needing.examine(evaluated_run(OPEN_FLAT, LoopsOnce), LoopsOnce).measured == "the SLAM estimates no loops"


class Forgetful(GeometricRooms):
    """Estimates rooms in every second run only, and turns its poses by a right angle in these runs."""

    runs = 0

    def finish(self):
        estimates = super().finish()
        type(self).runs += 1
        if type(self).runs % 2:
            return estimates
        turn = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
        return replace(estimates, rooms=estimates.rooms if self.keeps_rooms else None, T_W_B=estimates.T_W_B @ turn)

    keeps_rooms = False


class Turning(Forgetful):
    """Turns its poses by a right angle in every second run."""

    keeps_rooms = True


@pytest.mark.parametrize(
    ("slam", "said"), [(Forgetful, "only one of the two runs estimates rooms"), (Turning, "and 1.6 rad")]
)
def test_a_law_sees_lost_estimates_and_turned_poses(slam, said):
    again = replace(FLAT, parts=(replace(PART, checks=(SameEstimates("again", "Twice the same.", NoChange()),), n=1),))
    report = check_slam(slam, again)
    assert outcomes(report)["again"] == "fails" and said in str(report)


def test_a_law_about_frames_holds_for_a_verifier_that_compares_the_loops_of_one_keyframe():
    """The setting `max_contradiction` reads more of the pose graph than the defaults do."""

    def comparing():
        return Lexis("oracle", Config(verification=VerificationConfig(max_contradiction=16.8)))

    revisits = Scenario(preset="home", seed=7, length_m=70.0, frame_rate_hz=2.0, fidelity="features", encoder="oracle")
    base = evaluated_run(revisits, comparing)
    assert np.unique(base.run.estimate.loops.query, return_counts=True)[1].max() > 1
    assert LAWS["moved and rotated house"].examine(base, comparing).holds


class OnlyLoops(Oracle):
    """LEXIS that estimates its loop closures and nothing else."""

    def finish(self):
        estimates = super().finish()
        return Estimate(estimates.frames, loops=estimates.loops)


def test_a_law_holds_only_if_something_was_compared():
    law = SameEstimates("slip", "", MovedOrigin(), compares=("labels", "rooms"))
    assert law.examine(evaluated_run(OPEN_FLAT, OnlyLoops), OnlyLoops).holds is None
    assert ORIGIN.examine(evaluated_run(OPEN_FLAT, Oracle), Oracle).holds


@pytest.mark.parametrize("law", SUITES["language"].parts[0].checks, ids=lambda law: law.name)
def test_laws_about_room_names_say_nothing_of_a_slam_without_labels(law):
    part = replace(PART, checks=(law,), n=1)
    assert outcomes(check_slam(OdometryOnly, replace(FLAT, parts=(part,))))[law.name] == "not applicable"


def _impossible(scenario):
    return replace(scenario, length_m=0.5)


def _stayed(scenario):
    return scenario


def _long(scenario):
    return replace(scenario, length_m=40.0)


def test_a_law_about_the_scenario_compares_figures():
    worse = NotWorse("long", "The walk is 100 m longer.", _long, (("run.path_m", -100.0),), rate=None)
    fine = replace(worse, name="fine", tolerances=(("run.path_m", 0.0),))
    impossible, stayed = replace(worse, name="impossible", change=_impossible), replace(worse, name="stayed", change=_stayed)
    laws = replace(FLAT, parts=(replace(PART, checks=(worse, fine, impossible, stayed), n=1),))
    assert outcomes(check_slam(OdometryOnly, laws)) == {
        COMPLETES: "holds",
        "long": "fails",
        "fine": "holds",
        "impossible": "not applicable",
        "stayed": "not applicable",
    }


def _slipped(finished):
    """Whether the last estimated position is half a metre from where the unchanged odometry would put it."""
    away = np.linalg.norm(finished.estimate.T_W_B[-1, :3, 3] - finished.odometry_poses[-1, :3, 3])
    return CheckFinding(bool(abs(away - 0.5) < 0.01), f"{away:.2f} m away")


def test_a_law_about_the_run_on_changed_input_examines_that_run_alone():
    slip = AfterChange("slip", "The odometry slips by 0.5 m.", Slip(first_s=0.5, shift_m=(0.4, -0.3, 0.0)), _slipped)
    laws = replace(FLAT, parts=(replace(PART, checks=(slip, replace(slip, name="none", change=NoChange())), n=1),))
    assert outcomes(check_slam(OdometryOnly, laws)) == {COMPLETES: "holds", "slip": "holds", "none": "fails"}


def test_slips_are_mended_to_the_end_by_lexis_and_not_by_odometry_alone():
    law = LAWS["slips are mended to the end"]
    base = evaluated_run(replace(OPEN_FLAT, length_m=60.0, tour_kind="both ways"), Oracle)
    assert law.examine(base, Oracle).holds
    assert law.examine(base, LoopsWithoutCorrection).holds is False
    assert law.examine(base, OdometryOnly).holds is None


def test_every_law_says_what_it_demands():
    for law in LAWS.values():
        assert law.says.endswith(".") and (law.rate is None or 0.5 < law.rate < 1.0)


def test_a_law_that_is_broken_now_and_then_shows_in_all_parts_together():
    law = replace(ORIGIN, rate=0.95)
    parts = tuple(SuitePart(name, "", flat, (law,), n=20) for name in ("first", "second", "third"))
    suite = Suite("three", "", parts)

    def report(broken):
        """One scenario in `broken` breaks the law, in each part; the parts take turns."""
        jobs = jobs_of(suite, seed=0)
        held = {job: job.number % broken != broken - 1 for job in jobs}
        found = (Examination(j.part.name, j.number, OPEN_FLAT, None, {law.name: CheckFinding(held[j], "")}) for j in jobs)
        return SuiteReport(suite, 0, tuple(found))

    assert [each.name for each in report(5).failed] == ["all parts: origin"]
    assert not report(20).failed
    alone = SuiteReport(replace(suite, parts=parts[:1]), 0, ())
    assert [each.name for each in alone.verdicts if each.check == law.name] == ["first: origin"]


def test_a_law_about_floors_says_nothing_about_a_slam_without_floors():
    law = replace(FLAT, parts=(replace(PART, checks=(LAWS["a drift in height"],), n=1),))
    assert outcomes(check_slam(OdometryOnly, law))["a drift in height"] == "not applicable"


def test_false_loops_reach_only_a_slam_that_uses_the_verifier():
    law = replace(FLAT, parts=(replace(PART, checks=(LAWS["false loop closures"],), n=1),))
    assert outcomes(check_slam(OdometryOnly, law))["false loop closures"] == "not applicable"
    assert outcomes(check_slam(Oracle, law))["false loop closures"] in ("holds", "undecided")


def test_lexis_is_not_blamed_for_false_loops_between_frames_that_also_have_a_true_one():
    base = evaluated_run(replace(OPEN_FLAT, length_m=60.0), Oracle)
    found = LAWS["false loop closures"].examine(base, Oracle)
    assert len(base.run.estimate.loops.query) > 20 and found.holds, found.measured
