"""`lexis-sim check --suite` prints and writes verdicts, and refuses options that cannot be used."""

import json
import re
from contextlib import suppress
from dataclasses import replace

import pytest
from helpers.flat_suite import (
    FLAT,
    PART,
    Oracle,
    WrongLabels,
    outcomes,
)
from helpers.open_flat import OPEN_FLAT
from helpers.planted_commands import program

from sim.cli import main
from sim.commands.check_suite import SUITE_HELP
from sim.errors import SimError
from sim.harness.adapters import OdometryOnly
from sim.harness.crash import COMPLETES
from sim.programs import Program
from sim.render.rig import RigConfig
from sim.suites.catalogue import SUITES
from sim.suites.consistency import CONSISTENCY
from sim.suites.examination import examine
from sim.suites.laws import LAWS
from sim.suites.report import check_slam
from sim.suites.suite import claims
from sim.verdicts import load_results

ODOMETRY = ("--slam", "sim.harness.adapters:OdometryOnly")


def test_the_help_names_every_suite():
    named = SUITE_HELP.partition(": ")[2].replace(" or ", " ").split(", ")
    assert " ".join(named).split() == list(SUITES)


def test_the_command_writes_verdicts_and_results(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    slam = ["--slam", "sim.harness.adapters:GeometricRooms", "--workers", "1"]
    assert main(["check", "--suite", "flat", *slam, "--json", str(tmp_path / "all.json")]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^holds +2 of 2 +100%  flat: the run completes$", shown, re.MULTILINE)
    assert re.search(r"^undecided +2 of 2 +95%  flat: floors.accuracy >= 0.9$", shown, re.MULTILINE)
    assert "\nundecided: so few scenarios give no answer with 99% confidence; this is no failure\n" in shown
    assert len(load_results(tmp_path / "all.json")) == 2
    assert json.loads((tmp_path / "all.json").read_text())["ok"] is True
    assert main(["check", "--suite", "flat", *slam, "-x", "--limit", "floors.accuracy=1.1"]) == 1
    assert "failed: flat: floors.accuracy >= 1.1: holds in 0 of 2 houses (wanted: in 95%;" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--suite", "flats"], "unknown suite 'flats'"),
        (["--suite", "homes", "--preset", "ori"], "--preset is given beside --suite"),
        (["--suite", "homes", "--preset", "home"], "--preset is given beside --suite"),
        (["--suite", "homes", "--fidelity", "render"], "--fidelity is given beside --suite"),
        (["--suite", "homes", "--fails", "rooms.pq < 1"], "--fails is given beside --suite"),
        (["--suite", "homes", "--command", "x {dataset}"], "has no {out}; valid: such as"),
        (["--suite", "homes", "--timeout", "9"], "--timeout is for programs; valid: with --command"),
        (["--budget", "9s"], "--budget is for suites; valid: with --suite"),
        (["--reference", "sim.harness.adapters:Lexis"], "--reference is for suites; valid: with --suite"),
        (["--suite", "homes", "--reference", "sim.harness.adapters:Lexis"], "--reference is for the search of smallest"),
        (["--suite", "homes", "--out", "out", "--reference", "nowhere"], "--reference 'nowhere': is no MODULE:CLASS"),
        (["--suite", "homes", "--limit", "rooms.qp=1"], "has no claim about 'rooms.qp'"),
        (["-x"], "--exitfirst is for suites; valid: with --suite"),
        (
            ["--suite", "homes", "--limit", "floors.count_error=1"],
            "floors.count_error == 0 has no limit; valid: ",
        ),
        (["--suite", "homes", "--limit", "rooms.pq=nan"], "the limit of rooms.pq is nan; valid: a finite number"),
        (["--suite", "homes", "--json", "no/such/folder.json"], "its folder does not exist"),
        (["--suite", "homes", "--json", "."], ".: is a folder; valid: the name of a file"),
        (["--suite", "homes", "--picture", "."], ".: is a folder; valid: the name of a file"),
        (["--suite", "homes", "--json", "/dev/null"], "/dev/null: is a device or a pipe; valid: the name of a file"),
        (["--suite", "homes", "--json", "/proc/x.json"], "/proc/x.json: cannot be written"),
        (["--suite", "homes", "--out", "/proc/small"], "/proc/small: cannot be written"),
        (
            ["--suite", "homes", "--picture", "x.png"],
            "x.png: cannot be written in this format; valid: a name that ends in .svg",
        ),
        (["--suite", "homes", "--picture", "x.svg", "--json", "./x.svg"], "--json and --picture are both x.svg; valid: two"),
    ],
)
def test_options_that_cannot_be_used_are_refused_before_the_run(options, message, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.report.check_slam", None)
    assert main(["check", *options]) == 2
    assert message in capsys.readouterr().err


def test_the_command_compares_with_the_results_of_an_earlier_version(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": replace(FLAT, parts=(replace(PART, checks=(), n=10),))})
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: Oracle)
    options = ["check", "--suite", "flat", "--workers", "1"]
    before, same = tmp_path / "before.json", tmp_path / "same.json"
    assert main([*options, "--json", str(before)]) == 0
    assert main([*options, "--json", str(same), "--against", str(before)]) == 0
    assert json.loads(same.read_text())["worse"] == []
    assert re.search(
        rf"^a: \S*Oracle \({re.escape(str(before))}\), b: \S*Oracle \(this check\); ", capsys.readouterr().out, re.M
    )
    monkeypatch.setattr("sim.commands.check_suite._new_slam", lambda arguments: WrongLabels)
    assert main([*options, "--against", str(before)]) == 1
    assert "failed: labels.accuracy" in capsys.readouterr().err
    assert main([*options, "--seed", "8", "--against", str(before)]) == 2
    assert "has no results of the suite flat with seed 8; valid:" in capsys.readouterr().err


def test_results_are_written_even_if_the_reader_of_the_output_goes_away(tmp_path, monkeypatch):
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    monkeypatch.setattr("sim.commands.check_suite.suite_lines", broken_pipe)
    with suppress(BrokenPipeError, SystemExit):
        main(["check", "--suite", "flat", "--workers", "1", *ODOMETRY, "--json", str(tmp_path / "all.json")])
    assert len(load_results(tmp_path / "all.json")) == 2


def end_at_second_scenario(monkeypatch, error):
    """Let a suite of two scenarios end by an exception in the second one."""

    def ending(job, new_slam):
        if job.number == 1:
            raise error
        return examine(job, new_slam)

    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    monkeypatch.setattr("sim.suites.examination.examine", ending)


def test_results_before_ctrl_c_are_written_and_told(tmp_path, capsys, monkeypatch):
    end_at_second_scenario(monkeypatch, KeyboardInterrupt())
    assert main(["check", "--suite", "flat", "--workers", "1", *ODOMETRY, "--json", str(tmp_path / "all.json")]) == 130
    printed = capsys.readouterr()
    assert "1 of 2 scenarios were examined" in printed.out
    assert printed.err == "interrupted: the results are those of the scenarios before Ctrl-C\n"
    assert len(load_results(tmp_path / "all.json")) == 1
    written = json.loads((tmp_path / "all.json").read_text())
    assert written["interrupted"] is True and written["ok"] is False


def test_results_before_an_error_are_written_and_told(tmp_path, capsys, monkeypatch):
    end_at_second_scenario(monkeypatch, SimError("recording: cannot be written: No space left on device"))
    assert main(["check", "--suite", "flat", "--workers", "1", *ODOMETRY, "--json", str(tmp_path / "all.json")]) == 2
    printed = capsys.readouterr()
    assert "1 of 2 scenarios were examined" in printed.out
    assert printed.err.startswith("lexis-sim: recording: cannot be written") and "before this error" in printed.err
    assert len(load_results(tmp_path / "all.json")) == 1
    written = json.loads((tmp_path / "all.json").read_text())
    assert written["error"].endswith("No space left on device") and written["ok"] is False


def broken_pipe(*_, **__):
    raise BrokenPipeError


def test_a_program_is_checked_on_images_by_what_needs_no_change_of_its_input(capsys, monkeypatch):
    checks = (*claims(0.9, "trajectory.ate_m <= 1.0"), LAWS["same run twice"], *CONSISTENCY)
    small = replace(OPEN_FLAT, encoder="mini", length_m=8.0, rig=RigConfig(width=160, height=120))
    part = replace(PART, draw=lambda rng, number: small, checks=checks, n=1)
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": replace(FLAT, parts=(part,))})
    assert main(["check", "--suite", "flat", "--workers", "1", "--command", program("drift")]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^holds +1 of 1 +100%  flat: steps follow the odometry$", shown, re.MULTILINE)
    assert re.search(r"^not applicable +0 of 0 +100%  flat: same run twice$", shown, re.MULTILINE)
    assert main(["check", "--suite", "flat", "--workers", "1", "--command", "false {dataset} {out}"]) == 1
    assert "the SLAM ends with exit status 1" in capsys.readouterr().err
    report = check_slam(Program("true {dataset} {out}"), "flat")
    assert outcomes(report)[COMPLETES] == "fails" and "trajectory.tum" in str(report)


def test_a_suite_ends_when_its_time_is_over(capsys, monkeypatch):
    for workers in (1, 2):
        assert [each.number for each in check_slam(OdometryOnly, FLAT, workers=workers, budget_s=1e-9).examined] == [0]
    monkeypatch.setattr("sim.suites.catalogue.SUITES", {"flat": FLAT})
    slam = "sim.harness.adapters:OdometryOnly"
    assert main(["check", "--suite", "flat", "--workers", "1", "--slam", slam, "--budget", "0.001s"]) == 0
    assert "1 of 2 scenarios were examined" in capsys.readouterr().out


@pytest.mark.parametrize("option", ["--against", "--known-failures"])
def test_results_that_are_read_are_not_replaced(option, tmp_path, capsys):
    earlier = tmp_path / "earlier.json"
    earlier.write_text("{}")
    suite = ["check", "--suite", "homes", "--slam", "sim.harness.adapters:OdometryOnly"]
    assert main([*suite, option, str(earlier), "--json", str(earlier)]) == 2
    assert "would be replaced by the new results; valid: another file" in capsys.readouterr().err
    assert earlier.read_text() == "{}"
