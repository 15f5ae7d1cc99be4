"""`check_slam` gives verdicts about any SLAM: they follow from the findings, and bugs are found."""

import json
import multiprocessing
import pickle
import re
import runpy
import subprocess
import sys
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from helpers.aborting_slam import AbortingSlam
from helpers.open_flat import OPEN_FLAT
from helpers.planted_commands import program
from helpers.results import RESULT
from helpers.unchecked import unchecked, untyped

from sim.cli import main
from sim.commands.check_suite import _by_cause
from sim.errors import SimError
from sim.harness import Estimate, Lexis, Scenario, run
from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.claims import Claim
from sim.harness.estimate import LoopClaims
from sim.harness.failures.failure_folder import Replay
from sim.programs import Program
from sim.suites.catalogue import OPENNESS, SUITES, suite_named
from sim.suites.checks import AfterChange, CheckFinding, ClaimCheck, NotWorse, SameClaims, examined
from sim.suites.consistency import CONSISTENCY
from sim.suites.examination import COMPLETES, Examination, examinations, jobs_of, scenario_of
from sim.suites.figure_table import figure_table
from sim.suites.frame_changes import MovedOrigin
from sim.suites.laws import LAWS
from sim.suites.openness_chart import openness_chart
from sim.suites.pytest_items import Item, slam_checks
from sim.suites.report import CheckVerdict, SuiteReport, check_slam
from sim.suites.smallest import finding_of, smallest_failure, write_smallest
from sim.suites.stream_changes import NoChange, Slip
from sim.suites.suite import Suite, SuitePart, claims
from sim.verdicts import load_results


def flat(rng: np.random.Generator, number: int) -> Scenario:
    """A walk with the oracle through a flat of two rooms."""
    return replace(OPEN_FLAT, seed=int(rng.integers(1000)))


ORIGIN = SameClaims("origin", "The claims do not depend on the origin.", MovedOrigin())
PART = SuitePart(
    "flat", "A flat.", flat, (*claims(0.95, "labels.accuracy >= 0.8"), *claims(0.95, "floors.accuracy >= 0.9"), ORIGIN), n=2
)
FLAT = Suite("flat", "A flat.", (PART,))


class Oracle(Lexis):
    """LEXIS with the encoder that is told the truth."""

    def __init__(self):
        super().__init__("oracle")


class WrongLabels(Oracle):
    """LEXIS that claims the first label everywhere."""

    def finish(self):
        claims = super().finish()
        return replace(claims, labels=np.zeros_like(claims.labels))


class LoopsWithoutCorrection(Oracle):
    """LEXIS that claims the poses of the odometry, which its loops do not fit."""

    def start(self, camera, room_names):
        super().start(camera, room_names)
        self._odometry = {}

    def process(self, observation):
        self._odometry[observation.index] = observation.T_O_B.copy()
        super().process(observation)

    def finish(self):
        claims = super().finish()
        return replace(claims, T_W_B=np.stack([self._odometry[frame] for frame in claims.frames.tolist()]))


class FloorsByHeight(OdometryOnly):
    """Claims floors by the absolute height in the odometry frame."""

    def finish(self):
        claims = super().finish()
        return replace(claims, floors=np.floor(claims.T_W_B[:, 2, 3] / 3.0).astype(int).clip(0))


class Broken(OdometryOnly):
    """Raises an exception at the 20th observation."""

    def process(self, observation):
        if observation.index == 20:
            raise RuntimeError("lost")
        super().process(observation)


def outcomes(report):
    return {verdict.check: verdict.outcome for verdict in report.verdicts}


def test_a_good_slam_passes():
    report = check_slam(Oracle, FLAT)
    assert report.ok and len(report.results) == 2
    assert outcomes(report) == {
        COMPLETES: "holds",
        "labels.accuracy >= 0.8": "undecided",  # two houses cannot show a rate of 0.9
        "floors.accuracy >= 0.9": "undecided",
        "origin": "holds",
    }


def test_what_a_slam_does_not_claim_is_not_judged():
    report = check_slam(OdometryOnly, FLAT)
    assert outcomes(report)["labels.accuracy >= 0.8"] == "not claimed" and report.ok


def test_a_bug_that_no_figure_shows_is_found_by_a_law():
    report = check_slam(FloorsByHeight, FLAT, stop_at_failure=True)
    assert [verdict.check for verdict in report.failed] == ["origin"]
    assert len(report.examined) == 1
    assert "% of the floors" in str(report)


def test_a_crash_fails_the_suite():
    report = check_slam(Broken, FLAT, stop_at_failure=True)
    assert [verdict.check for verdict in report.failed] == [COMPLETES]
    assert "RuntimeError: lost" in str(report)


class BrokenNow(OdometryOnly):
    """Raises an exception when it is made."""

    def __init__(self):
        raise RuntimeError("not today")


class Named(OdometryOnly):
    """Takes an argument when it is made."""

    def __init__(self, name):
        self.name = name


class Quits(OdometryOnly):
    """Ends the process at the first observation."""

    def process(self, observation):
        raise SystemExit(0)


class Invalid(OdometryOnly):
    """Claims a label that does not exist."""

    def finish(self):
        claims = super().finish()
        return replace(claims, labels=np.full(len(claims.frames), 999))


@pytest.mark.parametrize(
    ("slam", "said"),
    [(BrokenNow, "RuntimeError: not today"), (Quits, "SystemExit"), (Invalid, "labels has 999")],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_whatever_the_slam_does_wrong_fails_the_suite(slam, said):
    report = check_slam(slam, FLAT)
    assert outcomes(report)[COMPLETES] == "fails" and said in str(report)


@pytest.mark.parametrize(
    ("slam", "message"),
    [
        (OdometryOnly(), "new_slam is an instance of OdometryOnly; valid: the class of a SLAM"),
        (lambda: None, "NoneType has no method start"),
    ],
)
def test_what_makes_no_slam_is_refused(slam, message):
    with pytest.raises(SimError, match=message):
        check_slam(slam, FLAT)


@pytest.mark.parametrize(
    ("function", "arguments", "message"),
    [
        (check_slam, ("stairs", OdometryOnly), "check_slam: new_slam is an instance of str; valid: the class of a SLAM"),
        (check_slam, (OdometryOnly, OdometryOnly), "suite is the class OdometryOnly; valid: a Suite, or the name"),
        (check_slam, (OdometryOnly, FLAT, "7"), "suite: seed is '7'; valid: a whole number from 0"),
        (check_slam, (OdometryOnly, FLAT, 7, "2"), "suite: workers is '2'; valid: a whole number from 1"),
        (check_slam, (OdometryOnly, FLAT, 7, 1, False, None, "12m"), "budget_s is '12m'; valid: a number of seconds, such"),
        (check_slam, (OdometryOnly, FLAT, 7, 1, False, None, np.nan), "budget_s is nan; valid: a number of seconds, such"),
        (check_slam, (Named, FLAT), "check_slam: new_slam is the class Named, which cannot be called without arguments: "),
        (slam_checks, (Named, FLAT), "slam_checks: new_slam is the class Named, which cannot be called without arguments: "),
        (slam_checks, ("stairs", OdometryOnly), "slam_checks: new_slam is an instance of str; valid: the class"),
        (slam_checks, (OdometryOnly, FLAT, ["flat: origin"]), "expected_failures is an instance of list; valid: a mapping"),
        (Suite.with_size, (FLAT, "small"), "suite flat: the share is 'small'; valid: a positive number"),
        (Suite.with_limits, (FLAT, {"labels.accuracy": "0.7"}), "the limit of labels.accuracy is '0.7'; valid: a finite"),
        (Suite.with_limits, (FLAT, "labels.accuracy=0.7"), "suite flat: limits is an instance of str; valid: a mapping"),
        (SUITES.__getitem__, ("stair",), r"unknown suite 'stair' \(did you mean 'stairs'\?\); valid: pr, "),
    ],
)
def test_arguments_of_the_wrong_kind_or_in_the_wrong_order_are_named(function, arguments, message):
    with pytest.raises(SimError, match=message):
        untyped(function)(*arguments)


def test_a_slam_that_takes_arguments_is_checked_with_all_of_them_given():
    assert check_slam(partial(Named, "mine"), FLAT).ok


def verdict_on(*held, rate=0.9, group=1, n=20):
    """The verdict about a check that holds in these scenarios."""
    part = replace(PART, n=n, group=group)
    found = tuple(
        Examination("flat", k, OPEN_FLAT, None, {"check": CheckFinding(holds, "")}) for k, holds in enumerate(held)
    )
    return CheckVerdict(part, "check", "", rate, found)


def test_a_check_that_has_to_hold_always_fails_at_its_first_failure_whenever_that_is():
    assert verdict_on(*[True] * 9, False, rate=None).outcome == "fails"
    assert verdict_on(*[True] * 9, rate=None).outcome == "holds"


def test_a_failure_that_was_certain_once_stays_one():
    assert verdict_on(*[False] * 3).outcome == "fails"
    assert verdict_on(*[False] * 3, *[True] * 17).outcome == "fails"
    assert verdict_on(*[False] * 2, *[True] * 18).outcome == "undecided"


def test_a_part_that_was_not_begun_is_not_examined_rather_than_not_claimed():
    other = replace(PART, name="other")
    unclaimed = {check.name: CheckFinding(None, "") for check in PART.checks} | {COMPLETES: CheckFinding(True, "")}
    report = SuiteReport(replace(FLAT, parts=(PART, other)), 0, (Examination("flat", 0, OPEN_FLAT, None, unclaimed),))
    outcomes = {(verdict.part.name, verdict.outcome) for verdict in report.verdicts}
    assert outcomes == {("flat", "holds"), ("flat", "not claimed"), ("other", "not examined")} and report.ok


def test_a_check_that_a_crash_prevents_is_not_examined_rather_than_not_claimed():
    report = check_slam(Broken, FLAT)
    assert outcomes(report) == dict.fromkeys(outcomes(report), "not examined") | {COMPLETES: "fails"}


class LoopsOnce(OdometryOnly):
    """Claims one loop closure in every second run, and none in the others."""

    runs = 0

    def finish(self):
        type(self).runs += 1
        claims = super().finish()
        many = self.runs % 2
        rows = np.arange(many), np.arange(many)
        return replace(claims, loops=LoopClaims(rows[0] + len(claims.frames) - 1, rows[1], np.tile(np.eye(4), (many, 1, 1))))


def test_a_run_without_loop_closures_still_claims_them():
    law = SameClaims("again", "Twice the same.", NoChange(), compares=("frames",))
    assert law.examine(examined(OPEN_FLAT, LoopsOnce), LoopsOnce).holds
    needing = replace(law, needs=("loops",))
    LoopsOnce.runs = 1
    assert needing.examine(examined(OPEN_FLAT, LoopsOnce), LoopsOnce).measured == "the SLAM claims no loops"


test_a_crash = slam_checks(Broken, suite=FLAT, expected_failures={f"flat: {COMPLETES}": "it crashes"})


def test_crashes_in_two_parts_are_searched_separately_and_a_law_is_searched_once():
    law, claim = verdict_on(False, rate=None), verdict_on(False, rate=None)
    two = [replace(each, part=replace(PART, name=name)) for each, name in ((law, "one"), (claim, "two"))]
    crashes = [replace(each, check=COMPLETES) for each in two]
    laws = [replace(each, check="origin") for each in two]
    assert [len(others) for _, others in _by_cause(crashes)] == [0, 0]
    assert [len(others) for _, others in _by_cause(laws)] == [1]


def test_loose_limits_are_looser_than_tight_ones():
    for part in SUITES["pr"].parts:
        limits = {}
        for check in part.checks:
            if isinstance(check, ClaimCheck) and check.claim.quantity in limits:
                loose, tight = limits[check.claim.quantity], check.claim
                assert (tight.limit - loose.limit) * (1 if ">" in tight.comparison else -1) > 0, f"{part.name}: {tight}"
            elif isinstance(check, ClaimCheck):
                limits[check.claim.quantity] = check.claim


def test_a_failure_that_becomes_certain_after_a_success_counts():
    assert verdict_on(*[True] * 8, rate=0.5, n=80).outcome == "holds"
    assert verdict_on(*[True] * 8, *[False] * 60, rate=0.5, n=80).outcome == "fails"


def test_a_group_of_scenarios_counts_once():
    assert verdict_on(*[False] * 5, group=5).verdict.houses == 1
    assert verdict_on(*[False] * 9, group=5).verdict.houses == 1  # the second group is not complete
    assert verdict_on(*[False] * 2, *[True] * 3, *[False] * 3, *[True] * 2, group=5).verdict.held == pytest.approx(1.0)


def test_a_group_counts_by_the_share_of_its_scenarios_in_which_the_check_holds():
    fails_where_it_is_open = [True, True, True, False, False] * 30
    assert verdict_on(*fails_where_it_is_open, group=5, n=150).outcome == "fails"


def test_a_group_counts_though_its_last_scenario_decides_nothing():
    assert verdict_on(True, True, None, group=3).verdict.houses == 1


def test_a_check_could_fail_if_it_would_fail_by_holding_nowhere():
    assert [verdict_on(*[True] * n).could_fail for n in (1, 2, 3, 9)] == [False, False, True, True]
    assert [verdict_on(*[False] * n).could_fail for n in (2, 3)] == [False, True]
    assert [verdict_on(*[True] * n, group=5).could_fail for n in (10, 15)] == [False, True]
    assert verdict_on(True, rate=None).could_fail and not verdict_on(rate=None).could_fail


def test_a_check_is_not_examined_before_the_first_house_is_complete():
    assert [verdict_on(*[False] * n, group=5).outcome for n in (0, 4, 5)] == ["not examined", "not examined", "undecided"]
    assert str(verdict_on(*[False] * 4, group=5)) == "flat: check: not examined"


def test_a_report_counts_the_checks_that_could_not_fail(capsys, monkeypatch):
    one, two = (replace(FLAT, parts=(replace(PART, n=n),)) for n in (1, 2))
    line = "2 of 4 checks could not fail: too few scenarios were examined"
    assert str(check_slam(Oracle, one)).endswith(f"\n{line}") and "could not fail" not in str(check_slam(Oracle, two))
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": one})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: Oracle)
    assert main(["check", "--suite", "flat", "--workers", "1"]) == 0
    assert line in capsys.readouterr().out.splitlines()


def test_failures_are_told_house_by_house():
    told = str(verdict_on(*[True, False, False] * 5, group=3, n=15, rate=0.95)).splitlines()[2:]
    assert [line.partition(":")[0].strip() for line in told] == [
        f"scenario {first} of flat, seed {OPEN_FLAT.seed} (and 1 more of this house)" for first in (1, 4, 7)
    ]
    verdict = verdict_on(False, rate=None)  # a law over several parts names the part of each scenario
    told = str(replace(verdict, part=replace(PART, name="all parts"))).splitlines()[2:]
    assert told == [f"  scenario 0 of flat, seed {OPEN_FLAT.seed}: "]


def with_accuracies(*accuracies, suite=FLAT, group=1):
    """The report of a suite in whose scenarios the labels have these accuracies."""
    scenarios = tuple(
        Examination("flat", k, OPEN_FLAT, replace(RESULT, labels=replace(RESULT.labels, accuracy=each)), {})
        for k, each in enumerate(accuracies)
    )
    part = replace(PART, n=len(accuracies), group=group, checks=())
    return SuiteReport(replace(suite, parts=(part,), means=(Claim.parse("labels.accuracy >= 0.9"),)), 0, scenarios)


def test_a_mean_that_is_too_low_fails_the_suite_though_every_check_holds():
    report = with_accuracies(*[0.89, 0.88] * 5)
    assert not report.ok and not report.failed
    assert [each.name for each in report.failed_means] == ["all parts: mean labels.accuracy >= 0.9"]
    assert "fulfilled by -0.015 on average" in str(report) and report.data()["means"][0]["outcome"] == "fails"
    assert with_accuracies(*[0.91, 0.92] * 5).ok


def test_a_mean_is_judged_once_all_scenarios_are_examined():
    report = with_accuracies(*[0.89, 0.88] * 5)
    unfinished = replace(report, examined=report.examined[:-1])
    assert unfinished.ok and unfinished.means[0].outcome == "not examined"


def test_a_group_of_scenarios_counts_once_in_a_mean():
    assert with_accuracies(*[0.7, 0.9] * 8, group=2).means[0].verdict.margins == pytest.approx((-0.1,) * 8)


def test_the_limit_of_a_mean_can_be_changed():
    suite = with_accuracies(0.5).suite
    assert str(suite.with_limits({"mean labels.accuracy": 0.4}).means[0]) == "labels.accuracy >= 0.4"
    with pytest.raises(SimError, match=r"did you mean 'mean labels\.accuracy'"):
        suite.with_limits({"mean labels.acuracy": 0.4})
    with pytest.raises(SimError, match="has no margin"):
        replace(suite, means=(Claim.parse("labels.accuracy == 1"),))


class Forgetful(GeometricRooms):
    """Claims rooms in every second run only, and turns its poses by a right angle in these runs."""

    runs = 0

    def finish(self):
        claims = super().finish()
        type(self).runs += 1
        if type(self).runs % 2:
            return claims
        turn = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
        return replace(claims, rooms=claims.rooms if self.keeps_rooms else None, T_W_B=claims.T_W_B @ turn)

    keeps_rooms = False


class Turning(Forgetful):
    """Turns its poses by a right angle in every second run."""

    keeps_rooms = True


@pytest.mark.parametrize(("slam", "said"), [(Forgetful, "only one of the two runs claims rooms"), (Turning, "and 1.6 rad")])
def test_a_law_sees_lost_claims_and_turned_poses(slam, said):
    again = replace(FLAT, parts=(replace(PART, checks=(SameClaims("again", "Twice the same.", NoChange()),), n=1),))
    report = check_slam(slam, again)
    assert outcomes(report)["again"] == "fails" and said in str(report)


@pytest.mark.parametrize(("share", "n"), [(0.01, 5), (0.5, 30), (0.1, 5), (2.0, 120)])
def test_a_suite_of_another_size_has_whole_groups(share, n):
    assert SUITES["open-plan"].with_size(share).parts[0].n == n


@pytest.mark.parametrize("share", [0.0, -1.0, np.inf, np.nan])
def test_a_share_that_is_no_size_is_refused(share):
    with pytest.raises(SimError, match=r"suite open-plan: the share is .*valid: a positive number"):
        SUITES["open-plan"].with_size(share)


class OnlyLoops(Oracle):
    """LEXIS that claims its loop closures and nothing else."""

    def finish(self):
        claims = super().finish()
        return Estimate(claims.frames, loops=claims.loops)


def test_a_law_holds_only_if_something_was_compared():
    law = SameClaims("slip", "", MovedOrigin(), compares=("labels", "rooms"))
    assert law.examine(examined(OPEN_FLAT, OnlyLoops), OnlyLoops).holds is None
    assert ORIGIN.examine(examined(OPEN_FLAT, Oracle), Oracle).holds


@dataclass
class Changeable:
    """A check that can change, and therefore has no hash."""

    name: str = "mine"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"checks": [Changeable()]},
            "part flat: check 'mine' cannot be hashed: .*; valid: a check such as a frozen dataclass",
        ),
        ({"n": 0}, "part flat: n is 0; valid: a whole number from 1"),
        ({"group": 0}, "part flat: group is 0; valid: a whole number from 1"),
    ],
)
def test_a_part_that_cannot_be_examined_is_refused(change, message):
    with pytest.raises(SimError, match=message):
        unchecked(SuitePart, **vars(PART) | change)


def test_a_list_of_checks_is_as_good_as_a_tuple():
    assert unchecked(SuitePart, **vars(PART) | {"checks": list(PART.checks)}) == PART


def test_a_claim_that_has_to_hold_in_all_scenarios_is_refused_before_any_run():
    with pytest.raises(SimError, match=r"rate is 1\.0; valid: a number above 0 and below 1, such as 0\.99"):
        claims(1.0, "rooms.pq >= 0.5")


@pytest.mark.parametrize("law", SUITES["language"].parts[0].checks, ids=lambda law: law.name)
def test_laws_about_room_names_say_nothing_of_a_slam_without_labels(law):
    part = replace(PART, checks=(law,), n=1)
    assert outcomes(check_slam(OdometryOnly, replace(FLAT, parts=(part,))))[law.name] == "not claimed"


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
        "impossible": "not claimed",
        "stayed": "not claimed",
    }


def _slipped(finished):
    """Whether the last claimed position is half a metre from where the unchanged odometry would put it."""
    away = np.linalg.norm(finished.estimate.T_W_B[-1, :3, 3] - finished.odometry_poses[-1, :3, 3])
    return CheckFinding(bool(abs(away - 0.5) < 0.01), f"{away:.2f} m away")


def test_a_law_about_the_run_on_changed_input_examines_that_run_alone():
    slip = AfterChange("slip", "The odometry slips by 0.5 m.", Slip(first=1, shift_m=(0.4, -0.3, 0.0)), _slipped)
    laws = replace(FLAT, parts=(replace(PART, checks=(slip, replace(slip, name="none", change=NoChange())), n=1),))
    assert outcomes(check_slam(OdometryOnly, laws)) == {COMPLETES: "holds", "slip": "holds", "none": "fails"}


def test_slips_are_mended_to_the_end_by_lexis_and_not_by_odometry_alone():
    law = LAWS["slips are mended to the end"]
    base = examined(replace(OPEN_FLAT, length_m=60.0, tour_kind="both ways"), Oracle)
    assert law.examine(base, Oracle).holds
    assert law.examine(base, LoopsWithoutCorrection).holds is False
    assert law.examine(base, OdometryOnly).holds is None


def test_the_findings_do_not_depend_on_the_number_of_processes():
    one, two = (check_slam(GeometricRooms, FLAT, workers=workers) for workers in (1, 2))
    assert one.data() == two.data()


def test_parts_take_turns_and_draws_do_not_depend_on_other_parts():
    other = replace(PART, name="other", n=2)
    jobs = jobs_of(Suite("two", "", (PART, other)), seed=3)
    assert [(job.part.name, job.number) for job in jobs[:4]] == [("flat", 0), ("other", 0), ("flat", 1), ("other", 1)]
    alone = jobs_of(FLAT, seed=3)
    assert [scenario_of(job) for job in jobs if job.part is PART] == [scenario_of(job) for job in alone]


def test_limits_can_be_set_by_figure():
    strict = FLAT.with_limits({"labels.accuracy": 1.1})
    assert outcomes(check_slam(Oracle, strict, stop_at_failure=True))["labels.accuracy >= 1.1"] == "fails"
    with pytest.raises(SimError, match=r"suite flat: has no claim about 'labels.acuracy' \(did you mean .*valid: floors"):
        FLAT.with_limits({"labels.acuracy": 0.5})


MEAN = Claim.parse("labels.accuracy >= 0.9")
UNEVEN = Suite("uneven", "Two parts.", (replace(PART, n=4), replace(PART, name="laws", checks=(ORIGIN,), n=6)), (MEAN,))


@pytest.mark.parametrize(("share", "sizes", "means"), [
    (0.5, (2, 3), (MEAN,)), (5.0, (20, 30), (MEAN,)), (0.3, (1, 2), ()), (0.01, (1, 1), ()),
])  # fmt: skip
def test_a_suite_of_another_size_claims_means_if_its_parts_keep_their_proportions(share, sizes, means):
    resized = UNEVEN.with_size(share)
    assert tuple(part.n for part in resized.parts) == sizes and resized.means == means


def test_without_laws_the_means_are_still_over_the_scenarios_of_all_parts():
    without = UNEVEN.without_laws()
    assert [(part.name, len(part.checks), part.n) for part in without.parts] == [("flat", 2, 4), ("laws", 0, 6)]
    assert without.means == (MEAN,)
    assert [part.name for part in replace(UNEVEN, means=()).without_laws().parts] == ["flat"]


def test_without_laws_a_suite_makes_its_claims_only():
    assert outcomes(check_slam(FloorsByHeight, FLAT.without_laws())).keys() == {
        COMPLETES, "labels.accuracy >= 0.8", "floors.accuracy >= 0.9",
    }  # fmt: skip
    with pytest.raises(SimError, match="suite language: has laws only; valid: with laws"):
        SUITES["language"].without_laws()


def test_the_smallest_failure_of_a_law_fails_by_it_as_well():
    reduction = smallest_failure(ORIGIN, OPEN_FLAT, FloorsByHeight, deadline_s=30.0)
    old, new = reduction.sizes
    assert new.rooms == 1 < old.rooms and reduction.signature.what == "origin"


def test_an_unknown_suite_is_refused():
    with pytest.raises(SimError, match=r"unknown suite 'open-plane' \(did you mean 'open-plan'\?\)"):
        suite_named("open-plane")


@pytest.mark.parametrize("name", [name for name in SUITES if name != "pr"])
def test_every_suite_can_draw_its_first_scenarios(name):
    for part in SUITES[name].parts:
        first = jobs_of(Suite(name, "", (part,)), seed=0)[:1]
        assert all(isinstance(scenario_of(job), Scenario) for job in first)


def test_the_open_plan_suite_opens_the_same_house_step_by_step():
    jobs = jobs_of(SUITES["open-plan"], seed=0)[: len(OPENNESS)]
    specs = [scenario_of(job).house for job in jobs]
    assert len({tuple(room.id for room in spec.storeys[0].rooms) for spec in specs}) == 1
    assert len({spec.to_json() for spec in specs}) == len(OPENNESS)


def test_all_checks_of_a_suite_have_different_names():
    for suite in SUITES.values():
        for part in suite.parts:
            names = [check.name for check in part.checks]
            assert len(names) == len(set(names)), part.name


def test_every_law_says_what_it_demands():
    for law in LAWS.values():
        assert law.says.endswith(".") and (law.rate is None or 0.5 < law.rate < 1.0)


def test_an_iterator_that_is_closed_early_stops_its_processes():
    found = examinations(jobs_of(FLAT, seed=0), OdometryOnly, workers=2)
    assert next(found).number == 0
    found.close()
    assert multiprocessing.active_children() == []


def test_slam_checks_makes_an_item_for_every_check():
    test = slam_checks(OdometryOnly, suite=FLAT, expected_failures={"flat: origin": "for the test"})
    (mark,) = test.pytestmark
    names = [parameter.id for parameter in mark.args[1]]
    assert names == [
        "flat: the run completes",
        "flat: labels.accuracy >= 0.8",
        "flat: floors.accuracy >= 0.9",
        "flat: origin",
    ]
    with pytest.raises(SimError, match=r"no check 'flat: orign' \(did you mean 'flat: origin'\?\)"):
        slam_checks(OdometryOnly, suite=FLAT, expected_failures={"flat: orign": "a typing error"})


def outcome_of(test, name):
    """What pytest reports for one item of `slam_checks`, with its text."""
    item = next(parameter.values[0] for parameter in test.pytestmark[0].args[1] if parameter.id == name)
    try:
        test(item)
    except (pytest.fail.Exception, pytest.skip.Exception, pytest.xfail.Exception) as raised:
        return type(raised).__name__, str(raised)
    return "Passed", ""


@pytest.mark.parametrize(
    ("slam", "check", "reported", "text"),
    [
        (FloorsByHeight, "origin", "XFailed", "^a reason$"),
        (Oracle, "origin", "Failed", r"^expected to fail \(a reason\), but it holds now: remove .*\nflat: origin: kept"),
        (
            WrongLabels,
            "labels.accuracy >= 0.8",
            "Failed",
            r"but it is undecided: more scenarios .*\n.*kept in 0 of 1 house",
        ),
        (
            OdometryOnly,
            "labels.accuracy >= 0.8",
            "Failed",
            r"but it could not be decided in any scenario: remove .*\n.*: not claimed \(labels\.accuracy is null\)$",
        ),
        (Broken, "origin", "Failed", "but no scenario reaches it"),
    ],
)
def test_an_expected_failure_that_does_not_fail_says_why(slam, check, reported, text):
    suite = replace(FLAT, parts=(replace(PART, n=1),))
    test = slam_checks(slam, suite, expected_failures={f"flat: {check}": "a reason"})
    outcome, said = outcome_of(test, f"flat: {check}")
    assert outcome == reported and re.search(text, said)


def test_an_item_that_is_skipped_says_why():
    law = replace(FLAT, parts=(replace(PART, checks=(LAWS["false loop closures"],), n=1),))
    skipped = outcome_of(slam_checks(OdometryOnly, law), "flat: false loop closures")
    assert skipped == ("Skipped", "flat: false loop closures: not claimed (the change does not reach this SLAM)")


def test_a_part_that_cannot_be_drawn_is_tried_once_and_fails_every_item():
    drawn = []

    def impossible(rng, number):
        drawn.append(number)
        raise SimError("there is no house")

    test = slam_checks(OdometryOnly, replace(FLAT, parts=(replace(PART, draw=impossible),)))
    drawn.clear()  # the marks of the items need a scenario, too
    items = [parameter.values[0] for parameter in test.pytestmark[0].args[1]]
    depths = []
    for item in items:
        with pytest.raises(SimError, match="part flat has no possible scenarios from number 0: there is no house") as raised:
            test(item)
        depths.append(len(raised.traceback))
    assert len(drawn) == 20  # the draws for one scenario
    assert len(depths) == 4 and len(set(depths)) == 1


def _rendered(rng, number):
    return replace(flat(rng, number), encoder="mini", fidelity="render")


def test_items_are_marked_by_the_fidelity_of_the_scenarios():
    parts = PART, replace(PART, name="drawn", draw=_rendered), replace(PART, name="images", on_images=True)
    test = slam_checks(OdometryOnly, replace(FLAT, parts=parts))
    marks = {parameter.values[0].part.name: parameter.marks[0].name for parameter in test.pytestmark[0].args[1]}
    assert marks == {"flat": "features", "drawn": "render", "images": "render"}


def test_an_item_that_fails_shows_the_verdict_and_nothing_else():
    with pytest.raises(pytest.fail.Exception) as raised:
        slam_checks(FloorsByHeight, suite=FLAT)(Item(PART, "origin"))
    assert not raised.value.pytrace and str(raised.value).startswith(
        "flat: origin: kept in 0 of 2 scenarios (wanted: in all)"
    )


def test_an_expected_failure_without_its_part_is_refused_with_the_name_that_was_meant():
    many = replace(FLAT, parts=(replace(PART, checks=claims(0.9, *(f"rooms.pq >= {k}" for k in range(99)))),))
    with pytest.raises(
        SimError, match=r"no check 'rooms\.\*' \(did you mean 'flat: rooms\.\*'\?\); valid: flat: .* and 90 more"
    ):
        slam_checks(OdometryOnly, suite=many, expected_failures={"rooms.*": "no rooms"})


test_oracle = slam_checks(Oracle, suite=replace(FLAT, parts=(replace(PART, n=1),)))
"""The ready test, used as a user would."""

test_floors_by_height = slam_checks(
    FloorsByHeight, suite=replace(FLAT, parts=(replace(PART, n=1),)), expected_failures={"flat: orig*": "absolute heights"}
)


def test_the_command_writes_verdicts_and_results(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    slam = ["--slam", "sim.harness.adapters:GeometricRooms", "--workers", "1"]
    assert main(["check", "--suite", "flat", *slam, "--json", str(tmp_path / "all.json")]) == 0
    assert re.search(r"^holds +2 of 2 +wanted: 100%  flat: the run completes$", capsys.readouterr().out, re.MULTILINE)
    assert len(load_results(tmp_path / "all.json")) == 2
    assert json.loads((tmp_path / "all.json").read_text())["ok"] is True
    assert main(["check", "--suite", "flat", *slam, "-x", "--limit", "floors.accuracy=1.1"]) == 1
    assert "failed: flat: floors.accuracy >= 1.1: kept in 0 of 2 houses (wanted: in 95%;" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--suite", "flats"], "unknown suite 'flats'"),
        (["--suite", "homes", "--preset", "ori"], "--preset is given beside --suite"),
        (["--suite", "homes", "--fails", "rooms.pq < 1"], "--fails is given beside --suite"),
        (["--suite", "homes", "--command", "x {dataset}"], "has no {out}; valid: such as"),
        (["--suite", "homes", "--timeout", "9"], "--timeout is for programs; valid: with --command"),
        (["--budget", "9s"], "--budget is for suites; valid: with --suite"),
        (["--suite", "homes", "--limit", "rooms.qp=1"], "has no claim about 'rooms.qp'"),
        (["-x"], "--exitfirst is for suites; valid: with --suite"),
        (["--suite", "homes", "--limit", "rooms.pq=nan"], "the limit of rooms.pq is nan; valid: a finite number"),
        (["--suite", "homes", "--json", "no/such/folder.json"], "its folder does not exist"),
        (["--suite", "homes", "--json", "."], ".: is a folder; valid: the name of a file"),
        (["--suite", "homes", "--picture", "."], ".: is a folder; valid: the name of a file"),
        (["--suite", "homes", "--json", "/dev/null"], "/dev/null: is a device or a pipe; valid: the name of a file"),
    ],
)
def test_options_that_cannot_be_used_are_refused_before_the_run(options, message, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.report.check_slam", None)
    assert main(["check", *options]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("name", SUITES)
def test_every_scenario_of_a_suite_can_be_sent_to_another_process(name):
    for job in jobs_of(SUITES[name].with_size(0.01), seed=0):
        assert pickle.loads(pickle.dumps(job)) == job


def test_a_slam_that_cannot_be_sent_to_another_process_is_refused_at_once():
    with pytest.raises(SimError, match=r"cannot be sent to other processes: .* valid: classes and functions at the top"):
        check_slam(lambda: OdometryOnly(), FLAT, workers=2)


def test_the_command_keeps_the_smallest_failing_scenario(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: FloorsByHeight)
    assert main(["check", "--suite", "flat", "-x", "--workers", "1", "--out", str(tmp_path / "small")]) == 1
    shown = capsys.readouterr()
    assert (
        "failed: flat: origin: kept in 0 of 1 scenarios (wanted: in all): fails" in shown.err
        and "The claims do not depend on the origin." in shown.err
    )
    kept = Scenario.load(tmp_path / "small" / "flat-origin" / "scenario.json")
    assert len(kept.house.storeys[0].rooms) == 1 and "flat: origin: 3 rooms, 20 m -> 1 room, " in shown.out
    why = (tmp_path / "small" / "flat-origin" / "why.md").read_text()
    assert "The claims do not depend on the origin." in why and "agrees on" in why.partition("In the original")[0]
    replay = tmp_path / "small" / "flat-origin" / "test_replay.py"
    assert f"replay: pytest {replay}" in shown.out
    code = {"__file__": str(replay), "FloorsByHeight": FloorsByHeight}
    exec(replay.read_text().replace("scenario, None)", "scenario, FloorsByHeight)"), code)
    with pytest.raises(AssertionError):
        code["test_replay"]()
    code["FloorsByHeight"] = BrokenNow
    with pytest.raises(AssertionError):  # a SLAM that crashes has not been mended
        code["test_replay"]()


RELATIVE = "trajectory.ate_m <= 0.66 * trajectory.ate_odometry_m"


def test_the_smallest_failure_of_a_claim_relative_to_the_odometry_is_one_that_a_mended_slam_passes(tmp_path):
    part = SuitePart("long", "A flat.", lambda *_: replace(OPEN_FLAT, length_m=40.0), claims(0.95, RELATIVE), n=1)
    suite = Suite("long", "A flat.", (part,))
    (verdict,) = (each for each in check_slam(OdometryOnly, suite).verdicts if each.check == RELATIVE)
    replay = Replay("from sim.harness import Lexis, run", "run(scenario, Lexis('oracle'))")
    write_smallest(verdict, OdometryOnly, lambda scenario, progress: run(scenario, OdometryOnly()), replay, False, tmp_path)
    (folder,) = tmp_path.iterdir()
    assert json.loads((folder / "result.json").read_text())["trajectory"]["ate_odometry_m"] > 0.01
    runpy.run_path(str(folder / "test_replay.py"))["test_replay"]()


class FailsOnce:
    """A law that fails when it is examined for the first time, and holds ever after."""

    name, says, rate, examinations = "once", "It holds the second time.", None, 0

    def examine(self, base, new_slam):
        self.examinations += 1
        return CheckFinding(self.examinations > 1, f"examination {self.examinations}")


def test_a_failure_of_a_law_that_does_not_come_back_is_told_and_not_written(tmp_path):
    verdict = replace(verdict_on(False, rate=None), part=replace(PART, checks=(FailsOnce(),)), check="once")
    found = (replace(verdict.examined[0], findings={"once": CheckFinding(False, "examination 0")}),)
    told = write_smallest(replace(verdict, examined=found), OdometryOnly, run, Replay(), False, tmp_path)
    assert told == (
        "flat: once: no smallest scenario: the failure (once) did not come back in the smallest scenario; "
        "valid: a SLAM that does the same in the same scenario"
    )
    assert not list(tmp_path.iterdir())


def test_a_replayed_check_that_no_suite_has_is_refused():
    with pytest.raises(SimError, match="no suite has the check homes: nonsense"):
        finding_of("homes", "nonsense", OPEN_FLAT)


def test_the_command_says_why_a_claim_fails(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: Oracle)
    monkeypatch.setattr("sim.commands.check_suite.runner_of", lambda _: lambda scenario, progress: run(scenario, Oracle()))
    options = ["--limit", "labels.accuracy=1.1", "--workers", "1", "--out", str(tmp_path)]
    assert main(["check", "--suite", "flat", "-x", *options]) == 1
    shown = capsys.readouterr()
    folder = tmp_path / "flat-labels.accuracy-1.1"
    assert (
        "flat: labels.accuracy >= 1.1: 3 rooms, 20 m -> 1 room, " in shown.out and f"why: {folder / 'why.md'}" in shown.out
    )
    assert {"scenario.json", "original.json", "why.md", "test_replay.py", "report.html"} <= {
        f.name for f in folder.iterdir()
    }


def test_one_of_several_failed_claims_about_a_figure_is_searched(tmp_path, capsys, monkeypatch):
    checks = (*claims(0.95, "labels.accuracy >= 1.1"), *claims(0.5, "labels.accuracy >= 1.2"))
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": Suite("flat", "", (replace(PART, checks=checks, n=12),))})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: Oracle)
    monkeypatch.setattr("sim.commands.check_suite.runner_of", lambda _: lambda scenario, progress: run(scenario, Oracle()))
    assert main(["check", "--suite", "flat", "--workers", "1", "--out", str(tmp_path)]) == 1
    assert "flat: labels.accuracy >= 1.2: not searched, because it is about the same figure" in capsys.readouterr().out
    assert [folder.name for folder in tmp_path.iterdir()] == ["flat-labels.accuracy-1.1"]


@pytest.mark.parametrize(("options", "searched"), [(["-x"], 1), ([], 2)], ids=["first failure", "whole suite"])
def test_with_the_first_failure_a_single_check_is_searched(options, searched, tmp_path, capsys, monkeypatch):
    checks = (*claims(0.95, "labels.accuracy >= 1.1"), *claims(0.95, "coverage.path_covered >= 1.1"))
    found = []
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": Suite("flat", "", (replace(PART, checks=checks, n=6),))})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: Oracle)
    monkeypatch.setattr("sim.suites.smallest.write_smallest", lambda verdict, *_: found.append(verdict.name) or "found")
    assert main(["check", "--suite", "flat", "--workers", "1", "--out", str(tmp_path), *options]) == 1
    assert len(found) == searched and capsys.readouterr().out.splitlines()[-searched:] == ["found"] * searched


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


def test_an_exception_is_reported_with_the_line_of_the_slam_that_raises_it():
    (found,) = check_slam(Broken, FLAT, stop_at_failure=True).failed[0].failures
    assert re.search(r"the SLAM raises RuntimeError: .*, in test_check_slam\.py:\d+$", found.findings[COMPLETES].measured)


def test_the_chart_shows_every_slam_once():
    for slam, names in ((Oracle, 3), (GeometricRooms, 2)):
        chart = openness_chart(check_slam(slam, FLAT), workers=1)
        assert chart.count("<svg") == 1 and chart.count('cy="14"') == names


def test_a_suite_can_be_rendered_for_a_slam_that_needs_images():
    scenario = scenario_of(jobs_of(SUITES["homes"].with_images(), seed=0)[0])
    assert (scenario.fidelity, scenario.frame_rate_hz) == ("render", 10.0)


def test_checks_of_equal_names_and_parts_of_equal_names_are_refused():
    with pytest.raises(SimError, match="part flat: the check 'origin' occurs twice"):
        replace(PART, checks=(ORIGIN, ORIGIN))
    with pytest.raises(SimError, match="suite twice: the part 'flat' occurs twice"):
        Suite("twice", "", (PART, PART))
    assert [c.name for c in SUITES["homes"].with_limits({"rooms.pq": 0.5}).parts[0].checks if "pq" in c.name] == [
        "rooms.pq >= 0.5"
    ]


def test_a_law_about_floors_says_nothing_about_a_slam_without_floors():
    law = replace(FLAT, parts=(replace(PART, checks=(LAWS["a drift in height"],), n=1),))
    assert outcomes(check_slam(OdometryOnly, law))["a drift in height"] == "not claimed"


def test_false_loops_reach_only_a_slam_that_uses_the_verifier():
    law = replace(FLAT, parts=(replace(PART, checks=(LAWS["false loop closures"],), n=1),))
    assert outcomes(check_slam(OdometryOnly, law))["false loop closures"] == "not claimed"
    assert outcomes(check_slam(Oracle, law))["false loop closures"] in ("holds", "undecided")


def test_the_command_compares_with_the_results_of_an_earlier_version(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": replace(FLAT, parts=(replace(PART, checks=(), n=10),))})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: Oracle)
    options = ["check", "--suite", "flat", "--workers", "1"]
    before, same = tmp_path / "before.json", tmp_path / "same.json"
    assert main([*options, "--json", str(before)]) == 0
    assert main([*options, "--json", str(same), "--against", str(before)]) == 0
    assert json.loads(same.read_text())["worse"] == []
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: WrongLabels)
    assert main([*options, "--against", str(before)]) == 1
    assert "failed: labels.accuracy" in capsys.readouterr().err
    assert main([*options, "--seed", "8", "--against", str(before)]) == 2
    assert "has no results of the suite flat with seed 8; valid:" in capsys.readouterr().err


def test_a_slam_that_kills_its_process_is_reported_with_the_scenario():
    with pytest.raises(SimError, match=r"a process died while it ran the SLAM on scenario [01] of part flat, seed 3"):
        check_slam(AbortingSlam, FLAT, seed=3, workers=2)


def test_a_script_that_runs_again_in_its_worker_processes_is_told_what_it_lacks(tmp_path):
    script = tmp_path / "check_mine.py"
    script.write_text(
        "from sim import check_slam\nfrom sim.harness.adapters import OdometryOnly\n"
        "check_slam(OdometryOnly, 'homes', workers=2)\n"
    )
    ended = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
    assert ended.stderr.splitlines()[-1] == (
        "sim.errors.SimError: suite: a process died before it began a scenario; valid: in a script, a call of check_slam "
        "below 'if __name__ == \"__main__\":', or one process (workers=1)"
    )


def test_a_program_is_checked_on_images_by_what_needs_no_change_of_its_input(capsys, monkeypatch):
    checks = (*claims(0.9, "trajectory.ate_m <= 1.0"), LAWS["same run twice"], *CONSISTENCY)
    part = replace(PART, draw=lambda rng, number: replace(OPEN_FLAT, encoder="mini", length_m=8.0), checks=checks, n=1)
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": replace(FLAT, parts=(part,))})
    assert main(["check", "--suite", "flat", "--workers", "1", "--command", program("drift")]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^holds +1 of 1 +wanted: 100%  flat: steps follow the odometry$", shown, re.MULTILINE)
    assert re.search(r"^not claimed +0 of 0 +wanted: 100%  flat: same run twice$", shown, re.MULTILINE)
    assert main(["check", "--suite", "flat", "--workers", "1", "--command", "false {dataset} {out}"]) == 1
    assert "the SLAM ends with exit status 1" in capsys.readouterr().err
    report = check_slam(Program("true {dataset} {out}"), "flat")
    assert outcomes(report)[COMPLETES] == "fails" and "trajectory.tum" in str(report)


def test_the_table_shows_the_median_of_each_part_and_what_is_not_claimed():
    other = replace(PART, name="other", checks=(), n=3)
    report = check_slam(OdometryOnly, Suite("two", "", (replace(PART, checks=()), other)))
    head, first, second = (line.split() for line in figure_table(report).splitlines())
    assert (first[:3], second[:3]) == (["flat", "2", "-"], ["other", "3", "-"])
    errors = sorted(each.result["trajectory.ate_m"] for each in report.examined if each.part == "other")
    assert head[-1] == "trajectory.ate_odometry_m" and second[-1] == f"{errors[1]:.3f}"


def test_a_suite_ends_when_its_time_is_over(capsys, monkeypatch):
    for workers in (1, 2):
        assert [each.number for each in check_slam(OdometryOnly, FLAT, workers=workers, budget_s=1e-9).examined] == [0]
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    slam = "sim.harness.adapters:OdometryOnly"
    assert main(["check", "--suite", "flat", "--workers", "1", "--slam", slam, "--budget", "0.001s"]) == 0
    assert "1 of 2 scenarios were examined" in capsys.readouterr().out
