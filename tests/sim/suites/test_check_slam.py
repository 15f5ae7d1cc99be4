"""`check_slam` finds bugs of a SLAM, whatever goes wrong and however many processes run it."""

import multiprocessing
import re
import subprocess
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from helpers.aborting_slam import AbortingSlam
from helpers.flat_suite import (
    FLAT,
    PART,
    Broken,
    BrokenNow,
    FloorsByHeight,
    Oracle,
    outcomes,
)
from helpers.unchecked import untyped

from sim.errors import SimError
from sim.harness import run
from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.crash import COMPLETES
from sim.harness.failures.failure_folder import Replay
from sim.harness.last_run import LastRun, watched
from sim.suites.catalogue import SUITES
from sim.suites.examination import examinations, jobs_of
from sim.suites.pytest_items import slam_checks
from sim.suites.report import check_slam
from sim.suites.smallest import SlamUnderSearch, write_smallest
from sim.suites.suite import Suite


def test_a_good_slam_passes():
    report = check_slam(Oracle, FLAT)
    assert report.ok and len(report.results) == 2
    assert outcomes(report) == {
        COMPLETES: "holds",
        "labels.accuracy >= 0.8": "undecided",  # two houses cannot show a rate of 0.9
        "floors.accuracy >= 0.9": "undecided",
        "origin": "holds",
    }


def test_what_a_slam_does_not_estimate_is_not_judged():
    report = check_slam(OdometryOnly, FLAT)
    assert outcomes(report)["labels.accuracy >= 0.8"] == "not applicable" and report.ok


def test_a_bug_that_no_figure_shows_is_found_by_a_law():
    report = check_slam(FloorsByHeight, FLAT, stop_at_failure=True)
    assert [verdict.check for verdict in report.failed] == ["origin"]
    assert len(report.examined) == 1
    assert "% of the floors" in str(report)


def test_a_crash_fails_the_suite():
    report = check_slam(Broken, FLAT, stop_at_failure=True)
    assert [verdict.check for verdict in report.failed] == [COMPLETES]
    assert "RuntimeError: lost" in str(report)


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


class Unspeakable(OdometryOnly):
    """Raises an exception that fails to make its own text."""

    class Error(Exception):
        def __str__(self):
            return self.missing

    def finish(self):
        raise self.Error


@pytest.mark.parametrize(
    ("slam", "said"),
    [
        (Unspeakable, "Error, whose text cannot be made: AttributeError"),
        (BrokenNow, "RuntimeError: not today"),
        (Quits, "SystemExit"),
        (Invalid, "labels has 999"),
    ],
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
        untyped(check_slam)(slam, FLAT)


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


def test_the_runs_of_a_suite_are_not_taken_for_the_run_of_a_test():
    last = LastRun()
    with watched(last):
        check_slam(OdometryOnly, FLAT)
    assert last.scenario is None


def test_the_findings_do_not_depend_on_the_number_of_processes():
    suite = replace(FLAT, parts=(replace(PART, name="flat/by night"),))
    one, two = (check_slam(GeometricRooms, suite, workers=workers) for workers in (1, 2))
    assert one.data() == two.data()


def test_an_iterator_that_is_closed_early_stops_its_processes():
    found = examinations(jobs_of(FLAT, seed=0), OdometryOnly, workers=2)
    assert next(found).number == 0
    found.close()
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("scenarios", [1, 2])
def test_a_slam_that_cannot_be_sent_to_another_process_is_refused_at_once(scenarios):
    suite = replace(FLAT, parts=(replace(PART, n=scenarios),))
    with pytest.raises(SimError, match=r"cannot be sent to other processes: .* valid: classes and functions at the top"):
        check_slam(lambda: OdometryOnly(), suite, workers=2)


def test_an_exception_is_reported_with_the_line_of_the_slam_that_raises_it():
    (found,) = check_slam(Broken, FLAT, stop_at_failure=True).failed[0].failures
    assert re.search(r"the SLAM raises RuntimeError: .*, in flat_suite\.py:\d+$", found.findings[COMPLETES].measured)


def test_a_slam_that_ends_its_process_in_one_scenario_is_checked_in_all_others(tmp_path):
    flat = replace(FLAT, parts=(replace(PART, n=6),))
    fatal = run(check_slam(OdometryOnly, flat, seed=3).examined[3].scenario, OdometryOnly()).estimate.T_W_B[1]
    aborting = partial(AbortingSlam, fatal)
    report = check_slam(aborting, flat, seed=3, workers=2)
    assert [each.number for each in report.examined] == list(range(6))
    assert [each.findings[COMPLETES].holds for each in report.examined] == [True] * 3 + [False] + [True] * 2
    assert "the SLAM ends its process" in str(report)
    (verdict,) = (each for each in report.failed if each.check == COMPLETES)
    told, _ = write_smallest(verdict, SlamUnderSearch(aborting, run, Replay(), False), tmp_path)
    assert told.startswith("flat: the run completes: no smallest scenario: the SLAM ends its process")


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
