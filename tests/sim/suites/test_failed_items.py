"""A failed item of `slam_checks` leaves a folder that replays its failure."""

import shlex

import pytest
from helpers.documentation import ROOT
from helpers.flat_suite import ORIGIN, Broken
from helpers.open_flat import OPEN_FLAT
from helpers.pytest_process import isolate_pytest

from sim.harness import Scenario
from sim.suites.examination import finding, replayed_finding

pytest_plugins = ["pytester"]

CHECKS = """
    from dataclasses import replace

    from helpers.flat_suite import FLAT, PART, Broken, FloorsByHeight, NoLabels
    from sim import slam_checks
    from sim.suites.suite import claims

    test_floors = slam_checks(FloorsByHeight, suite=FLAT)
    test_expected = slam_checks(FloorsByHeight, suite=FLAT, expected_failures={"flat: origin": "heights"})
    test_broken = slam_checks(Broken, suite=FLAT)
    test_invalid = slam_checks(NoLabels, suite=FLAT)
    exact = replace(PART, checks=claims(0.95, "trajectory.ate_m < 0"))
    test_exact = slam_checks(FloorsByHeight, suite=replace(FLAT, parts=(exact,)))
"""
SHRINK = "smallest scenario: lexis-sim shrink "
ITEM = "test_mine.py::test_floors[flat: origin]"


@pytest.fixture
def start(pytester, monkeypatch):
    """Run pytest in a folder of its own and a process of its own; returns its output."""
    isolate_pytest(monkeypatch, ROOT, ROOT / "tests")
    plugin = ("-p", "no:lexis", "-p", "sim.pytest_plugin", "-p", "no:cacheprovider")
    return lambda *options: pytester.runpytest_subprocess(*plugin, *options).stdout.str()


def test_a_failed_item_is_stored_and_replayed(pytester, start):
    pytester.makepyfile(test_mine=CHECKS)
    shown = start("-k", "origin")
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    kept = f".lexis-failures/{folder.name}"
    assert "1 failed" in shown and SHRINK not in shown  # shrink searches no law
    assert "1 xfailed" in shown and f"\nfolder: {kept}\n" in shown
    assert f"\nreplay: pytest -p sim.pytest_plugin {shlex.quote(ITEM)} --lexis-replay {kept}\n" in shown
    assert folder.name.endswith(Scenario.load(folder / "scenario.json").content_hash)
    assert "The estimates do not depend on the origin." in (folder / "why.md").read_text()
    replayed = start(folder)
    assert "1 failed" in replayed and "% of the floors" in replayed and "in 0 of 2 scenarios" not in replayed


def test_a_claim_and_a_crash_name_the_command_that_makes_them_smaller(pytester, start):
    pytester.makepyfile(test_mine=CHECKS)
    shown = start("-k", "broken or invalid or exact")
    found = [line.partition(" --slam ")[2] for line in shown.splitlines() if line.startswith(SHRINK)]
    assert found == [
        "helpers.flat_suite:Broken --fails crash -o failure",
        "helpers.flat_suite:FloorsByHeight --fails 'trajectory.ate_m >= 0' -o failure",
    ]
    assert shown.count("\nfolder: ") == 3  # that of estimates that are not valid, too


def test_a_replay_in_which_the_run_does_not_complete_fails():
    """Otherwise, a SLAM would count as mended as soon as it crashes."""
    assert finding(ORIGIN, OPEN_FLAT, Broken).holds is None
    found = replayed_finding(ORIGIN, OPEN_FLAT, Broken)
    assert found.holds is False and "RuntimeError: lost" in found.measured
