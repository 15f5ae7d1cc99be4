"""The smallest scenario in which a check fails is found, written and replayed."""

import json
import runpy
from dataclasses import replace

import numpy as np
import pytest
from helpers.flat_suite import (
    FLAT,
    ORIGIN,
    PART,
    Broken,
    BrokenNow,
    FloorsByHeight,
    NoLabels,
    Oracle,
    verdict_on,
)
from helpers.open_flat import OPEN_FLAT

from sim.bench.planted_bugs import no_bug, planted
from sim.cli import main
from sim.commands.check_suite import _by_cause
from sim.errors import SimError
from sim.harness import Scenario, reduce, run
from sim.harness.adapters import OdometryOnly
from sim.harness.crash import COMPLETES, TRACEBACK
from sim.harness.failures.failure_folder import Replay
from sim.harness.last_run import noted
from sim.harness.shrinking.reductions import STEPS
from sim.harness.shrinking.scenario_size import size
from sim.suites.checks import CheckFinding
from sim.suites.examination import finding
from sim.suites.report import check_slam
from sim.suites.smallest import SlamUnderSearch, _failure_test, finding_of, smallest_failure, write_smallest
from sim.suites.suite import Suite, SuitePart, claims


def test_crashes_in_two_parts_are_searched_separately_and_a_law_is_searched_once():
    law, claim = verdict_on(False, rate=None), verdict_on(False, rate=None)
    two = [replace(each, part=replace(PART, name=name)) for each, name in ((law, "one"), (claim, "two"))]
    crashes = [replace(each, check=COMPLETES) for each in two]
    laws = [replace(each, check="origin") for each in two]
    assert [len(others) for _, others in _by_cause(crashes)] == [0, 0]
    assert [len(others) for _, others in _by_cause(laws)] == [1]


def test_the_smallest_failure_of_a_law_fails_by_it_as_well():
    reduction = smallest_failure(ORIGIN, OPEN_FLAT, FloorsByHeight, deadline_s=1e9)
    old, new = reduction.sizes
    assert new.rooms == 1 < old.rooms and reduction.signature.what == "origin"


class WrongClaims(OdometryOnly):
    """Claims about a frame that does not exist after a long walk, and a room name that does not exist after a short one."""

    def finish(self):
        claims = super().finish()
        n = len(claims.frames)
        if n > 15:
            return replace(claims, frames=np.append(claims.frames[:-1], 100 * n))
        return replace(claims, labels=np.full(n, 100))


def test_the_smallest_failure_of_an_invalid_estimate_is_invalid_in_the_same_way():
    reduction = smallest_failure(None, OPEN_FLAT, WrongClaims, deadline_s=10.0)
    assert reduction.signature.what == "estimate: frames has ... in row ..."
    assert finding(None, reduction.scenario, WrongClaims).measured.startswith("estimate: frames has ")


def test_the_command_keeps_the_smallest_failing_scenario(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: FloorsByHeight)
    assert main(["check", "--suite", "flat", "-x", "--workers", "1", "--out", str(tmp_path / "small")]) == 1
    shown = capsys.readouterr()
    assert (
        "failed: flat: origin: holds in 0 of 1 scenarios (wanted: in all): fails" in shown.err
        and "The estimates do not depend on the origin." in shown.err
    )
    kept = Scenario.load(tmp_path / "small" / "flat-origin" / "scenario.json")
    assert len(kept.house.storeys[0].rooms) == 1 and "flat: origin: 3 rooms, 20 m -> 1 room, " in shown.out
    why = (tmp_path / "small" / "flat-origin" / "why.md").read_text()
    assert "The estimates do not depend on the origin." in why and "agrees on" in why.partition("In the original")[0]
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
    write_smallest(
        verdict,
        SlamUnderSearch(OdometryOnly, lambda scenario, progress: run(scenario, OdometryOnly()), replay, False),
        tmp_path,
    )
    (folder,) = tmp_path.iterdir()
    assert json.loads((folder / "result.json").read_text())["trajectory"]["ate_odometry_m"] > 0.01
    runpy.run_path(str(folder / "test_replay.py"))["test_replay"]()


def wrong_alone(run):
    """A SLAM that labels nothing in houses of one room."""
    labels = np.full_like(run.true_labels, -1) if len(run.house.rooms) < 2 else run.true_labels
    return replace(no_bug(run), labels=labels)


def always_wrong(run):
    return replace(no_bug(run), labels=np.full_like(run.true_labels, -1))


@pytest.mark.parametrize("reference", [None, wrong_alone, always_wrong])
def test_a_reference_that_passes_has_to_pass_in_the_smallest_scenario(reference, tmp_path):
    slam, other = planted(always_wrong), None if reference is None else planted(reference)
    (check,) = claims(0.95, "labels.accuracy >= 0.9")
    test, note = _failure_test(check, OPEN_FLAT, slam, other)
    assert ("the reference is not used, because it fails, too: labels.accuracy is 0" in note) == (reference is always_wrong)
    assert test.reference is (other if reference is wrong_alone else None)
    steps = {"drop rooms": STEPS["drop rooms"]}
    assert size(reduce(OPEN_FLAT, test, 1e9, steps=steps).scenario).rooms == (2 if reference is wrong_alone else 1)


def test_the_folder_of_a_crash_has_its_traceback(tmp_path):
    (verdict,) = (each for each in check_slam(Broken, FLAT).verdicts if each.check == COMPLETES)
    replay = Replay("from helpers.flat_suite import Broken\nfrom sim.harness import run", "run(scenario, Broken())")
    write_smallest(
        verdict, SlamUnderSearch(Broken, lambda scenario, progress: run(scenario, Broken()), replay, False), tmp_path
    )
    (folder,) = tmp_path.iterdir()
    assert "RuntimeError: lost" in (folder / TRACEBACK).read_text()
    with pytest.raises(RuntimeError, match="lost"):
        runpy.run_path(str(folder / "test_replay.py"))["test_replay"]()


@pytest.mark.parametrize(("slam", "says"), [(NoLabels, "labels"), (BrokenNow, "not today")])
def test_invalid_estimates_and_slams_that_cannot_be_made_are_replayed(slam, says, tmp_path, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    (verdict,) = (each for each in check_slam(slam, FLAT).verdicts if each.check == COMPLETES)
    replay = Replay(f"from helpers.flat_suite import {slam.__name__}", "", slam.__name__)
    write_smallest(verdict, SlamUnderSearch(slam, lambda scenario, progress: run(scenario, slam()), replay, False), tmp_path)
    (folder,) = tmp_path.iterdir()
    assert says in (folder / "why.md").read_text()
    with pytest.raises(AssertionError, match=says):
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
    told, _ = write_smallest(replace(verdict, examined=found), SlamUnderSearch(OdometryOnly, run, Replay(), False), tmp_path)
    assert told == (
        "flat: once: no smallest scenario: the failure (once) did not come back in the smallest scenario; "
        "valid: a SLAM that does the same in the same scenario"
    )
    assert not list(tmp_path.iterdir())


def test_the_runs_of_a_replayed_check_are_no_run_of_the_test(monkeypatch):
    """The plugin would otherwise say where the last of them first went wrong, which has nothing to do with the law."""
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    with noted() as last:
        assert finding_of("flat", "origin", OPEN_FLAT, OdometryOnly).holds
        assert last.run is None and last.scenario is None


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
    monkeypatch.setattr(
        "sim.suites.smallest.write_smallest", lambda verdict, *_: (found.append(verdict.name) or "found", False)
    )
    assert main(["check", "--suite", "flat", "--workers", "1", "--out", str(tmp_path), *options]) == 1
    assert len(found) == searched and capsys.readouterr().out.splitlines()[-searched:] == ["found"] * searched
