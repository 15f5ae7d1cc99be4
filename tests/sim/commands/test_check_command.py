"""`lexis-sim check`: exit 0 if nothing failed, 1 with a line for each figure that failed, 2 for bad input."""

import json
import pickle
import re
import runpy
import shlex
import subprocess
import sys
from dataclasses import astuple, replace

import pytest
from helpers.command_line import status_of

from sim.commands.slams import slam_factory
from sim.errors import SimError
from sim.faults import parse_fault
from sim.harness import Scenario
from sim.harness.last_run import last_run
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)
ODOMETRY = ["--slam", "sim.harness.adapters:OdometryOnly"]
GEOMETRIC = ["--slam", "sim.harness.adapters:GeometricRooms"]


def status_with_closed_output(*command: object) -> int:
    """Return the exit status of `lexis-sim` where nobody reads standard output, as after `| head`."""
    code = f"import sys; from sim.cli import main; sys.exit(main({list(map(str, command))}))"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    assert process.stderr.read() == b""
    return process.wait()


def test_a_result_is_written_even_if_nobody_reads_the_output(folder):
    check = ["check", "--scenario", "scenario.json", *ODOMETRY, "-o", "out"]
    assert status_with_closed_output(*check) == 141
    assert json.loads((folder / "out" / "result.json").read_text())["slam"] == "OdometryOnly"


def test_a_scenario_whose_house_breaks_a_rule_is_named_by_its_file(folder, capsys):
    data = json.loads((folder / "scenario.json").read_text())
    data["house"]["storeys"][0]["openings"] = []
    (folder / "apart.json").write_text(json.dumps(data))
    assert status_of(["check", "--scenario", "apart.json", *ODOMETRY]) == 2
    assert capsys.readouterr().err.startswith("lexis-sim: apart.json: not reachable on foot")


def test_a_crash_of_compiled_code_shows_the_line_of_the_slam_that_called_it():
    command = [sys.executable, "-m", "sim", "check", "--scenario", "scenario.json", "--slam", "own_slam_here:Fatal"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode < 0 and done.stderr.startswith("Fatal Python error: Aborted")
    assert re.search(r'own_slam_here\.py", line \d+ in finish', done.stderr)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The current folder, with a scenario and modules of users."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    SCENARIO.save(tmp_path / "scenario.json")
    (tmp_path / "own_slam_here.py").write_text(
        "import numpy as np\n"
        "from lexis.errors import LexisError\n"
        "from sim.harness.adapters import OdometryOnly as Mine\n"
        "class Half:\n    def start(self, camera, room_names): pass\n"
        "class Lost(Mine):\n    def finish(self): return 1 / 0\n"
        "class Unreadable(Mine):\n    def finish(self): raise OSError('no file \\udcff')\n"
        "class Third(Mine):\n    def process(self, seen):\n        if seen.index < 10: super().process(seen)\n"
        "class Fatal(Mine):\n    def finish(self):\n        import os\n        os.abort()\n"
        "class Leaving(Mine):\n    def finish(self): raise SystemExit(0)\n"
        "class Unsaved(Mine):\n    def save(self, folder): 1 / 0\n"
        "class Roaming(Mine):\n    def process(self, seen):\n        import os\n        os.chdir('/')\n"
        "        super().process(seen)\n"
        "class Lexical(Mine):\n    def start(self, camera, names): raise LexisError('no floor')\n"
        "class Unlicensed(Mine):\n    def __init__(self): raise OSError('no licence')\n"
        "class Planless(Mine):\n    def plan(self, start, goal): raise KeyError(goal)\n"
        "    def finish(self):\n        from dataclasses import replace\n        found = super().finish()\n"
        "        rooms = [i % 2 for i in range(len(found.frames))]\n"
        "        return replace(found, rooms=np.array(rooms), labels=np.array(rooms))\n"
        "class Greedy:\n    def __init__(self, weights): pass\n"
    )
    (tmp_path / "own_slam_broken.py").write_text("raise OSError('no licence')")
    (tmp_path / "own_slam_exits.py").write_text("raise SystemExit(0)")
    yield tmp_path
    for name in ("own_slam_here", "own_slam_broken", "own_slam_exits"):
        sys.modules.pop(name, None)


def test_a_slam_that_cannot_save_its_files_has_crashed(folder, capsys):
    assert status_of(["check", "--scenario", "scenario.json", "--slam", "own_slam_here:Unsaved", "-o", "out"]) == 1
    printed = capsys.readouterr()
    assert "failed: the SLAM raises ZeroDivisionError: division by zero" in printed.err and "why: out/why.md" in printed.out
    assert "1 / 0" in (folder / "out" / "failure-traceback.txt").read_text()


def test_a_slam_may_change_the_working_directory(folder, capsys):
    assert status_of(["check", "--scenario", "scenario.json", "--slam", "own_slam_here:Roaming", "-o", "out"]) == 0
    assert (folder / "out" / "result.json").is_file()


def test_a_check_in_which_nothing_fails(capsys):
    assert status_of(["check", "--scenario", "scenario.json", *GEOMETRIC, "--fails", "floors.accuracy < 0.5"]) == 0
    printed = capsys.readouterr()
    assert re.search(r"^ *rooms\.pq +panoptic quality +0\.\d+", printed.out, re.MULTILINE)
    assert printed.err == ""


def test_each_figure_that_fails_costs_one_line(capsys):
    fails = ["floors.accuracy >= 0.5", "rooms.pq < 2", "trajectory.ate_m > 1e6", "labels.accuracy < 0.7"]
    words = [word for text in fails for word in ("--fails", text)]
    assert status_of(["check", "--scenario", "scenario.json", *GEOMETRIC, *words]) == 1
    *lines, hint = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert lines[0] == "failed: floors.accuracy is 1, and fails if floors.accuracy >= 0.5"
    assert lines[1].startswith("failed: rooms.pq is 0.")
    assert lines[2].startswith("failed: labels.accuracy is null")
    assert hint.startswith("--out DIR keeps the run")


def test_a_kept_run_that_fails_names_the_command_that_shrinks_it(folder, capsys):
    words = ["check", "--scenario", "scenario.json", *GEOMETRIC, "--fails", "rooms.pq >= 2", "--fails", "rooms.pq < 2"]
    assert status_of([*words, "--out", "my run"]) == 1
    _, command = capsys.readouterr().err.splitlines()[-1].split(": ", 1)
    assert shlex.split(command) == ["lexis-sim", "shrink", "my run", *GEOMETRIC, "--fails", "rooms.pq < 2", "-o", "failure"]


def test_a_copy_in_another_process_imports_the_module_of_the_slam(folder):
    """A module may declare furniture, which has to exist before the other process draws a house."""
    pickled = pickle.dumps(slam_factory("own_slam_here:Mine"))
    del sys.modules["own_slam_here"]
    pickle.loads(pickled)
    assert "own_slam_here" in sys.modules


def test_a_replay_imports_the_module_of_the_slam_before_it_reads_the_scenario(folder, monkeypatch):
    """A module may declare furniture, without which the scenario is refused."""
    assert status_of(["check", "--scenario", "scenario.json", "--slam", "own_slam_here:Lost", "--out", "out"]) == 1
    del sys.modules["own_slam_here"]
    monkeypatch.setattr(Scenario, "load", lambda path: SCENARIO if "own_slam_here" in sys.modules else None)
    with pytest.raises(ZeroDivisionError):
        runpy.run_path(str(folder / "out" / "test_replay.py"))["test_replay"]()


def test_a_fault_without_effect_and_a_part_of_the_walk_are_warned_of(folder, capsys):
    assert status_of(["check", "--scenario", "scenario.json", "--slam", "own_slam_here:Third"]) == 0
    assert "warning: The map covers " in capsys.readouterr().out
    replace(SCENARIO, faults=(parse_fault("kidnap:999"),)).save(folder / "idle.json")
    assert status_of(["check", "--scenario", "idle.json", *ODOMETRY]) == 0
    assert "warning: The fault kidnap changed no frame; " in capsys.readouterr().out


def test_a_slam_that_raises_fails_the_check_and_leaves_a_folder(folder, capsys):
    words = ["check", "--scenario", "scenario.json", "--slam", "own_slam_here:Lost", "--fails", "labels.accuracy < 0.7"]
    assert status_of(words) == 1
    told = capsys.readouterr().err.splitlines()
    assert told[0].startswith("Traceback") and told[-1] == "failed: the SLAM raises ZeroDivisionError: division by zero"
    for _ in range(2):  # the second folder replaces the first
        assert status_of([*words, "--out", "out"]) == 1
    assert "why: out/why.md" in capsys.readouterr().out
    assert "SLAM under test: `own_slam_here:Lost`" in (folder / "out" / "why.md").read_text()
    assert Scenario.load(folder / "out" / "scenario.json") == SCENARIO
    with pytest.raises(ZeroDivisionError):
        runpy.run_path(str(folder / "out" / "test_replay.py"))["test_replay"]()
    assert status_of(["check", "--scenario", "scenario.json", *ODOMETRY, "--out", "out"]) == 0
    assert not (folder / "out" / "failure-traceback.txt").exists()


def test_an_exception_with_a_name_that_is_not_utf_8_is_written(folder, capsys):
    words = ["check", "--scenario", "scenario.json", "--slam", "own_slam_here:Unreadable", "--out", "out"]
    assert status_of(words) == 1
    assert capsys.readouterr().err.splitlines()[-1] == r"failed: the SLAM raises OSError: no file \udcff"
    for name in ("why.md", "failure-traceback.txt"):
        assert r"no file \udcff" in (folder / "out" / name).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Leaving", "failed: the SLAM raises SystemExit: 0"),
        ("Lexical", "failed: the SLAM raises LexisError: no floor"),
        ("Unlicensed", "failed: the SLAM raises OSError: no licence"),
    ],
)
def test_whatever_ends_a_method_of_the_slam_is_a_crash(name, message, capsys):
    assert status_of(["check", "--scenario", "scenario.json", "--slam", f"own_slam_here:{name}"]) == 1
    assert capsys.readouterr().err.splitlines()[-1].startswith(message)


def test_an_exception_of_plan_is_a_crash(monkeypatch, capsys):
    def lost(finished):
        with last_run().calling_slam():
            raise KeyError("kitchen")

    monkeypatch.setattr("sim.harness.crash.try_plans", lost)
    assert status_of(["check", "--scenario", "scenario.json", *ODOMETRY]) == 1
    assert capsys.readouterr().err.splitlines()[-1] == "failed: the SLAM raises KeyError: 'kitchen'"


def test_a_crash_of_plan_is_replayed_and_made_smaller(folder):
    words = ["--slam", "own_slam_here:Planless"]
    assert status_of(["check", "--scenario", "scenario.json", *words, "--out", "out"]) == 1
    with pytest.raises(KeyError):
        runpy.run_path(str(folder / "out" / "test_replay.py"))["test_replay"]()
    assert status_of(["shrink", "out", *words, "--fails", "crash", "--deadline", "1", "-o", "smaller"]) == 0
    with pytest.raises(KeyError):
        runpy.run_path(str(folder / "smaller" / "test_replay.py"))["test_replay"]()


@pytest.mark.parametrize("place", ["sim.harness.runner.walk", "sim.harness.crash.try_plans"])
def test_what_the_slam_did_not_raise_is_no_crash(place, monkeypatch):
    def broken(*_):
        raise RuntimeError("no disk")

    monkeypatch.setattr(place, broken)
    with pytest.raises(RuntimeError, match="no disk"):
        status_of(["check", "--scenario", "scenario.json", *ODOMETRY])


def test_a_class_of_the_current_folder_writes_a_run_that_can_be_repeated(folder, capsys):
    words = ["--slam", "own_slam_here:Mine", "--out", "first"]
    assert status_of(["check", "--scenario", "scenario.json", *words]) == 0
    assert "report: first/report.html" in capsys.readouterr().out
    assert status_of(["check", "--scenario", "first/scenario.json", *ODOMETRY, "--out", "second"]) == 0
    first, second = (json.loads((folder / name / "result.json").read_text()) for name in ("first", "second"))
    assert first["trajectory"] == second["trajectory"] and first["scenario"] == SCENARIO.content_hash
    assert first["labels"]["accuracy"] is None


def test_options_and_a_scenario_file_describe_the_same_run(folder, monkeypatch):
    seen = []

    def stop(scenario, *_):
        seen.append(scenario)
        raise SimError("so far")

    monkeypatch.setattr("sim.harness.run", stop)
    (folder / "house.json").write_text(SCENARIO.house.to_json())
    options = ["--house", "house.json", "--seed", "5", "--length", "15", "--rate", "4", "--fidelity", "features"]
    for command in ("run", "check"):
        assert status_of([command, *options]) == status_of([command, "--scenario", "scenario.json"]) == 2
    assert {scenario.content_hash for scenario in seen} == {SCENARIO.content_hash} and len(seen) == 4


def test_the_options_of_a_program_reach_it(monkeypatch):
    seen = []

    def stop(self, scenario, progress=None):
        seen.append(astuple(self))
        raise SimError("so far")

    monkeypatch.setattr("sim.programs.program.Program.__call__", stop)
    command = ["check", "--command", "./slam {dataset} {out}"]
    assert status_of(command) == 2
    assert status_of([*command, "--format", "tum", "--timeout", "5", "--memory", "100", "--image-format", "jpg"]) == 2
    assert seen == [
        ("./slam {dataset} {out}", "euroc", 600.0, 8192.0, "png"),
        ("./slam {dataset} {out}", "tum", 5.0, 100.0, "jpg"),
    ]


def test_a_program_fails_a_check_by_name(folder, capsys):
    """The program claims the odometry, as its recording holds it."""
    small = Scenario(**{**vars(SCENARIO), "fidelity": "render", "length_m": 10.0, "rig": RigConfig("wide", 160, 120)})
    small.save(folder / "small.json")
    (folder / "slam.py").write_text(
        "import shutil, sys\nshutil.copy(sys.argv[1] + '/odometry.tum', sys.argv[2] + '/trajectory.tum')"
    )
    command = f"'{sys.executable}' slam.py {{dataset}} {{out}}"
    words = ["--command", command, "--format", "tum", "--fails", "trajectory.ate_m > 1e-6"]
    assert status_of(["check", "--scenario", "small.json", *words]) == 1
    assert capsys.readouterr().err.startswith("failed: trajectory.ate_m is 0.")


def test_a_program_that_fails_is_told_once(folder, capsys):
    small = Scenario(**{**vars(SCENARIO), "fidelity": "render", "rig": RigConfig("wide", 16, 16)})
    small.save(folder / "small.json")
    (folder / "slam.py").write_text("import sys\nprint('no vocabulary', file=sys.stderr)\nsys.exit(3)")
    command = f"'{sys.executable}' slam.py {{dataset}} {{out}}"
    assert status_of(["check", "--scenario", "small.json", "--command", command]) == 1
    told = f"no vocabulary\nfailed: command: {sys.executable} ended with exit status 3: no vocabulary\n"
    assert capsys.readouterr().err == told
    assert status_of(["check", "--scenario", "small.json", "--command", command, "-o", "out"]) == 1
    assert f"SLAM under test: `{command}`" in (folder / "out" / "why.md").read_text()


def test_files_of_a_program_that_are_not_valid_are_kept(folder, capsys):
    small = Scenario(**{**vars(SCENARIO), "fidelity": "render", "rig": RigConfig("wide", 16, 16)})
    small.save(folder / "small.json")
    (folder / "slam.py").write_text(
        "import os, sys\nprint('done')\n"
        "open(sys.argv[2] + '/trajectory.tum', 'w').write('1 2 3')\nos.mkfifo(sys.argv[2] + '/rooms.json')"
    )
    command = f"'{sys.executable}' slam.py {{dataset}} {{out}}"
    assert status_of(["check", "--scenario", "small.json", "--command", command, "--out", "kept"]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("lexis-sim: {out}/trajectory.tum:1: '1 2 3'; valid: ") and printed.err.count("\n") == 1
    assert printed.out == "why: kept/why.md\n"
    kept = folder / "kept"
    assert (kept / "trajectory.tum").read_text() == "1 2 3" and (kept / "program.out").read_text() == "done\n"
    assert not (kept / "rooms.json").exists()
    assert Scenario.load(kept / "scenario.json") == small and "trajectory.tum:1: '1 2 3'" in (kept / "why.md").read_text()
    assert "(scenario)" in (kept / "test_replay.py").read_text()
    assert status_of(["check", "--scenario", "small.json", "--command", command, "--out", "kept"]) == 2  # it is replaced


def test_the_scenario_of_an_estimate_that_is_not_valid_is_kept(folder, capsys):
    (folder / "own_slam_wild.py").write_text(
        "import numpy as np\nfrom sim.harness import Estimate\n\n\nclass Wild:\n"
        "    def start(self, camera, room_names): ...\n\n    def process(self, observation): ...\n\n"
        "    def finish(self):\n        return Estimate(np.array([0]), labels=np.array([99]))\n"
    )
    SCENARIO.save(folder / "small.json")
    assert status_of(["check", "--scenario", "small.json", "--slam", "own_slam_wild:Wild", "--out", "kept"]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("lexis-sim: estimate: labels has 99 in row 0; valid: ") and printed.err.count("\n") == 1
    assert Scenario.load(folder / "kept" / "scenario.json") == SCENARIO
    assert "own_slam_wild:Wild" in (folder / "kept" / "why.md").read_text()


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["--fails", "labels.accuracy"], "is not understood; valid: a figure"),
        (["--fails", "labels.acc < 0.7"], "no figure 'acc' (did you mean 'accuracy'?); valid: accuracy, accuracy_baseline"),
        (["--fails", "crash"], "--fails crash: a crash always fails check; valid: without it, or lexis-sim shrink"),
        (["--slam", "own_slam_here.py:Mine"], "names a file; leave out .py: own_slam_here:Mine"),
        (["--slam", "./slams/own.py:Mine"], "names a file; leave out .py: slams.own:Mine"),
        (["--slam", "own_slam_here"], "is no MODULE:CLASS; valid: such as my_slam:MySlam"),
        (["--slam", "no_such_module:Slam"], "cannot be imported: ModuleNotFoundError: No module named 'no_such_module'"),
        (["--slam", "own_slam_broken:Slam"], "cannot be imported: OSError: no licence"),
        (["--slam", "own_slam_exits:Slam"], "cannot be imported: SystemExit: 0"),
        (["--slam", "own_slam_here:Missing"], "the module has no class Missing"),
        (["--slam", "own_slam_here:Half"], "Half has no method process()"),
        (["--slam", "own_slam_here:Greedy"], "is the class Greedy, which cannot be called without arguments: "),
        (["--slam", "x:Y", "--command", "z"], "not allowed with argument --slam"),
        (["--command", "./slam"], "has no {dataset}"),
        (["--command", "./slam {dataset} {out}", "--fidelity", "features"], "a program needs images"),
        (["--command", "./slam {dataset} {out}", "--format", "kitti"], "--format"),
        (["--format", "tum"], "--format is for programs; valid: with --command"),
        (["--timeout", "0"], "--timeout: '0'; valid: a number from 0.1"),
        (["--scenario", "missing.json"], "missing.json"),
        (["--scenario", "own_slam_here.py"], "is not JSON"),
        (["--scenario", "scenario.json", "--seed", "3"], "--seed is given beside --scenario"),
        (["--scenario", "scenario.json", "--seed", "7"], "--seed is given beside --scenario"),
        (["--odometry", "multicam", "--scenario", "scenario.json"], "--odometry is given beside --scenario"),
        (["--scenario", "scenario.json", "--feature-model", "x"], "--feature-model is given beside --scenario"),
        (["--scenario", "scenario.json", "--preset", "ori"], "not allowed with argument"),
        (["--out", "scenario.json"], "is a file; valid: the name of a folder"),
    ],
)
def test_bad_input_costs_one_line(words, hint, folder, capsys):
    before = sorted(folder.rglob("*"))
    assert status_of(["check", *words]) == 2
    printed = capsys.readouterr()
    assert hint in printed.err and printed.err.count("\n") == 1 and printed.out == ""
    assert sorted(folder.rglob("*")) == before
