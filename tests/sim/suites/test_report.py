"""Verdicts follow from the findings in the scenarios, and reports show them."""

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.flat_suite import FLAT, PART, Broken, Oracle, outcomes, verdict_on
from helpers.open_flat import OPEN_FLAT
from helpers.results import RESULT

from sim.cli import main
from sim.errors import SimError
from sim.harness import Estimate
from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.claims import Claim
from sim.harness.crash import COMPLETES
from sim.suites.checks import CheckFinding, ClaimCheck, evaluated_run
from sim.suites.examination import Examination, examine, jobs_of
from sim.suites.figure_table import figure_table
from sim.suites.openness_chart import _drawn, openness_chart
from sim.suites.report import SuiteReport, check_slam
from sim.suites.suite import Suite


def test_a_check_that_has_to_hold_always_fails_at_its_first_failure_whenever_that_is():
    assert verdict_on(*[True] * 9, False, rate=None).outcome == "fails"
    assert verdict_on(*[True] * 9, rate=None).outcome == "holds"


def test_a_failure_that_was_certain_once_stays_one():
    assert verdict_on(*[False] * 3).outcome == "fails"
    assert verdict_on(*[False] * 3, *[True] * 17).outcome == "fails"
    assert verdict_on(*[False] * 2, *[True] * 18).outcome == "undecided"


def test_a_part_that_was_not_begun_is_not_examined_rather_than_not_estimated():
    other = replace(PART, name="other")
    not_estimated = {check.name: CheckFinding(None, "") for check in PART.checks} | {COMPLETES: CheckFinding(True, "")}
    report = SuiteReport(replace(FLAT, parts=(PART, other)), 0, (Examination("flat", 0, OPEN_FLAT, None, not_estimated),))
    outcomes = {(verdict.part.name, verdict.outcome) for verdict in report.verdicts}
    assert outcomes == {("flat", "holds"), ("flat", "not applicable"), ("other", "not examined")} and report.ok


def test_a_check_that_a_crash_prevents_is_not_examined_rather_than_not_estimated():
    report = check_slam(Broken, FLAT)
    assert outcomes(report) == dict.fromkeys(outcomes(report), "not examined") | {COMPLETES: "fails"}


def test_an_estimate_that_is_withheld_counts_as_a_failure_if_it_is_not_always_withheld():
    """A SLAM that estimates nothing where it is lost must not be judged by its good runs alone."""
    held, withheld = CheckFinding(True, ""), CheckFinding(None, "", is_withheld=True)
    unsuited = CheckFinding(None, "")
    assert verdict_on(*[held] * 10, *[withheld] * 20, n=30).outcome == "fails"
    assert verdict_on(*[held] * 10, *[unsuited] * 20, n=30).counts == (10.0, 10)
    assert verdict_on(*[withheld] * 20).outcome == "not applicable"
    assert verdict_on(held, withheld, rate=None).outcome == "fails"


def test_a_figure_is_withheld_if_the_slam_does_not_estimate_what_it_needs():
    base = evaluated_run(OPEN_FLAT, GeometricRooms)
    found = {
        name: ClaimCheck(Claim.parse(name + " > 0.5"), 0.9).examine(base, GeometricRooms)
        for name in ("labels.accuracy", "rooms.pq", "loops.recall", "trajectory.ate_m")
    }
    assert {name for name, finding in found.items() if finding.is_withheld} == {"labels.accuracy", "loops.recall"}
    short = evaluated_run(replace(OPEN_FLAT, length_m=10.0), GeometricRooms)
    figure = ClaimCheck(Claim.parse("trajectory.rpe_24m_m > 0.5"), 0.9).examine(short, GeometricRooms)
    assert figure.holds is None and not figure.is_withheld  # the walk is shorter than 24 m


class LabelsAtOnce(GeometricRooms):
    """Labels two frames, without saying what the labels were before refinement."""

    def finish(self):
        return Estimate(np.array([0, 1]), T_W_B=np.tile(np.eye(4), (2, 1, 1)), labels=np.zeros(2, int))


@pytest.mark.parametrize("figure", ["labels.accuracy_baseline", "trajectory.ate_m"])
def test_a_figure_is_withheld_if_the_slam_estimates_too_little_for_it(figure):
    claim = ClaimCheck(Claim.parse(f"{figure} >= 0.0"), 0.9)
    assert claim.examine(evaluated_run(OPEN_FLAT, LabelsAtOnce), LabelsAtOnce).is_withheld


class FloorsFromOne(GeometricRooms):
    """Counts floors from 1."""

    def finish(self):
        estimate = super().finish()
        return replace(estimate, floors=estimate.floors + 1)


def test_a_claim_that_fails_tells_the_mistake_that_explains_it():
    found = ClaimCheck(Claim.parse("floors.accuracy > 0.5"), 0.9).examine(
        evaluated_run(OPEN_FLAT, FloorsFromOne), FloorsFromOne
    )
    assert not found.holds and "; Every floor is 1 too high" in found.measured


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
    assert "missed by 0.015 on average" in str(report) and report.data()["means"][0]["outcome"] == "fails"
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


def test_the_chart_shows_every_slam_once():
    for slam, names in ((Oracle, 3), (GeometricRooms, 2)):
        chart = openness_chart(check_slam(slam, FLAT), workers=1)
        assert chart.count("<svg") == 1 and chart.count('cy="14"') == names
        assert ">OdometryOnly (estimates neither)</text>" in chart and f">{slam.__name__}</text>" in chart


def test_the_chart_explains_its_points_and_bars_and_draws_no_bar_for_a_mean_over_few_houses():
    def results(n):
        return [replace(RESULT, rooms=replace(RESULT.rooms, pq=0.5 + 0.1 * k)) for k in range(n)]

    few, enough = (_drawn([("A", results(n))]) for n in (3, 4))
    for chart in (few, enough):
        assert ">Points are means over houses of similar openness; bars are 95 % confidence intervals" in chart
    assert few.count('stroke-width="1.5"') == 0 and "0.600, 3 houses<" in few
    assert enough.count('stroke-width="1.5"') == 1 and re.search(r"0\.650 \(0\.\d+ to 0\.\d+\), 4 houses<", enough)


def flat_of_mini(rng, number):
    """A short walk for the included encoder, which can be rendered."""
    return replace(OPEN_FLAT, encoder="mini", length_m=None)


def test_baselines_of_the_chart_have_the_figures_of_a_run_on_images():
    part = replace(PART, draw=flat_of_mini, checks=(), n=1)
    (job,) = jobs_of(Suite("flat", "", (part,)).with_images(), seed=0)
    (on_images, bare) = (examine(each, GeometricRooms).result for each in (job, replace(job, is_bare=True)))
    assert on_images.rooms == bare.rooms and on_images.trajectory == bare.trajectory


def test_the_table_shows_the_median_of_each_part_and_what_is_not_estimated():
    other = replace(PART, name="other", checks=(), n=3)
    report = check_slam(OdometryOnly, Suite("two", "", (replace(PART, checks=()), other)))
    head, first, second = (line.split() for line in figure_table(report).splitlines())
    assert (first[:3], second[:3]) == (["flat", "2", "-"], ["other", "3", "-"])
    errors = sorted(each.result["trajectory.ate_m"] for each in report.examined if each.part == "other")
    assert head[-1] == "trajectory.ate_odometry_m" and second[-1] == f"{errors[1]:.3f}"
