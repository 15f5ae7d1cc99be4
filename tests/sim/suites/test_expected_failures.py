"""Checks that are expected to fail do not fail a suite, and have to fail."""

import json
import re
from dataclasses import replace
from functools import cache

import pytest
from helpers.flat_suite import FLAT, PART, FloorsByHeight, Oracle
from helpers.open_flat import OPEN_FLAT

from sim.cli import main
from sim.errors import SimError
from sim.harness.claims import Claim
from sim.suites.report import check_slam

ORIGIN = "flat: origin"
REASON = "the floors are those of the odometry"
MEAN = "all parts: mean floors.accuracy >= 0.9"


@cache
def report(slam, expected, stop_at_failure=False):
    """The report of a suite with a mean on a SLAM; `expected` are the names of the checks that are expected to fail."""
    suite = replace(FLAT, means=(Claim.parse("floors.accuracy >= 0.9"),))
    return check_slam(slam, suite, stop_at_failure=stop_at_failure, expected_failures=dict.fromkeys(expected, REASON))


def test_a_failure_that_is_expected_does_not_fail_the_suite():
    found = report(FloorsByHeight, (ORIGIN,))
    assert found.ok and not found.failed and not found.unmet_expectations
    assert {check["check"]: (check["outcome"], check["expected_failure"]) for check in found.data()["checks"]}["origin"] == (
        "fails",
        REASON,
    )


def test_a_failure_that_is_expected_does_not_stop_the_suite():
    assert len(report(FloorsByHeight, (), stop_at_failure=True).examined) == 1
    assert len(report(FloorsByHeight, (ORIGIN,), stop_at_failure=True).examined) == FLAT.parts[0].n


@pytest.mark.parametrize("expected", [ORIGIN, "flat: or*", MEAN])
def test_an_expected_failure_that_does_not_occur_fails_the_suite(expected):
    found = report(Oracle, (expected,))
    (line,) = found.unmet_expectations
    assert not found.ok and not found.failed and line in str(found)
    assert f"expected to fail ({REASON}), but it " in line


def test_expectations_are_not_judged_before_all_scenarios_are_done():
    found = report(Oracle, (ORIGIN,))
    assert replace(found, examined=found.examined[:1]).ok


def test_the_name_of_an_expected_failure_is_that_of_a_check():
    with pytest.raises(SimError, match=r"no check 'origin' \(did you mean 'flat: origin'\?\)"):
        report(Oracle, ("origin",))


def test_the_command_expects_failures(tmp_path, capsys, monkeypatch):
    part = replace(PART, draw=lambda rng, number: OPEN_FLAT, n=1)
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": replace(FLAT, parts=(part,))})
    command = "check", "--suite", "flat", "--workers", "1", "--slam", "helpers.flat_suite:FloorsByHeight"
    assert main([*command, "--expect-failure", ORIGIN, "--json", str(tmp_path / "all.json")]) == 0
    assert "expected           0 of 1     100%  flat: origin" in capsys.readouterr().out
    assert json.loads((tmp_path / "all.json").read_text())["ok"] is True
    assert main([*command, "--json", str(tmp_path / "before.json")]) == 1
    assert main([*command, "--known-failures", str(tmp_path / "before.json")]) == 0
    for wrong in (
        ["--known-failures", str(tmp_path / "none.json")],
        ["--known-failures", str(tmp_path / "before.json"), "--seed", "8"],
    ):
        assert main([*command, *wrong, "--out", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()
    assert main([*command, "--expect-failure", ORIGIN, "--expect-failure", "flat: the run completes"]) == 1
    said = "failed: flat: the run completes: expected to fail (as --expect-failure says), but it holds now: remove "
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("pattern", "guess"),
    [
        ("origin", "flat: origin"),
        ("labels.accuracy", "flat: labels.accuracy*"),
        ("flat: labels.accuracy", "flat: labels.accuracy*"),
        ("flt: origin", "flat"),
        ("flat:origin", "flat: origin"),
    ],
)
def test_a_wrong_name_is_refused_with_the_name_that_was_probably_meant(pattern, guess):
    with pytest.raises(SimError, match=rf"^expected failures: no check '{pattern}' \(did you mean {re.escape(repr(guess))}"):
        report(Oracle, (pattern,))
