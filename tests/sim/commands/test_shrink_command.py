"""`lexis-sim shrink` with the user's own SLAM: the test in the folder of a failure runs the same class or program."""

import runpy
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest

from sim.cli import main
from sim.errors import ProgramError
from sim.harness import Scenario
from sim.harness.shrinking.reductions import STEPS
from sim.render.rig import RigConfig, build_rig
from sim.world_states import FrameRenderer
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21),
    seed=5,
    length_m=14.0,
    frame_rate_hz=4.0,
    fidelity="features",
    rig=RigConfig("wide", 160, 120),
)
OWN_SLAM = """
from dataclasses import replace
from pathlib import Path

import numpy as np
from sim.harness.adapters import OdometryOnly

class Mine(OdometryOnly):
    def finish(self):
        claims = super().finish()
        return replace(claims, floors=np.full(len(claims.frames), int(Path("floor.txt").read_text())))

class Lost(OdometryOnly):
    def process(self, observation):
        super().process(observation)
        if observation.index == 10 and Path("floor.txt").read_text() == "3":
            raise RuntimeError("lost")
"""
PROGRAM = """
import csv, json, sys
from pathlib import Path

dataset, out = map(Path, sys.argv[1:])
rows = [row[:8] for row in list(csv.reader(open(dataset / "mav0" / "odom0" / "data.csv")))[1:]]
poses = [(int(ns) / 1e9, x, y, z, qx, qy, qz, qw) for ns, x, y, z, qw, qx, qy, qz in rows]
(out / "trajectory.tum").write_text("".join(" ".join(map(str, pose)) + "\\n" for pose in poses))
frames = [{"stamp": pose[0], "floor": int(Path("floor.txt").read_text())} for pose in poses]
(out / "rooms.json").write_text(json.dumps({"version": 1, "frames": frames}))
"""
FAILS = ["--fails", "floors.accuracy < 0.5"]
DROP_ROOMS = ["--deadline", "1h", *(word for step in STEPS if step != "drop rooms" for word in ("--keep", step))]
"""Options for a search that only drops rooms, and that takes as long as it needs."""


@pytest.fixture(autouse=True)
def project(tmp_path, monkeypatch):
    """The folder of a user's project: a SLAM and a program that claim the floor in floor.txt, which is wrong."""
    folder = tmp_path / "project"
    folder.mkdir()
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    for name, content in (("own_slam_to_shrink.py", OWN_SLAM), ("program.py", PROGRAM), ("floor.txt", "3")):
        (folder / name).write_text(content)
    SCENARIO.save(folder / "scenario.json")
    replace(SCENARIO, fidelity="render").save(folder / "images.json")
    yield folder
    sys.modules.pop("own_slam_to_shrink", None)


@pytest.fixture
def unlit(monkeypatch):
    """Replaces rendering: frames are black and cost nothing."""
    size = build_rig(SCENARIO.rig).size_px[::-1]
    monkeypatch.setattr(FrameRenderer, "rgb", lambda *_: np.zeros((*size, 3), np.uint8))


def shrink(*words):
    """Exit status of the command."""
    return main(["shrink", *words, "-o", "failure"])


def replay(folder):
    """Run the test of a failure's folder in the current folder."""
    runpy.run_path(str(folder / "test_replay.py"))["test_replay"]()


def check_the_replay(project):
    """A moved folder replays with the SLAM of the project: the test fails now, and passes once floor.txt is mended."""
    moved = shutil.move(project / "failure", project.parent / "elsewhere")
    with pytest.raises(AssertionError, match=r"floors.accuracy is 0.0; wanted: floors.accuracy >= 0.5"):
        replay(moved)
    (project / "floor.txt").write_text("0")
    replay(moved)


def test_a_class_is_shrunk_and_replayed(project, capsys):
    assert shrink("scenario.json", "--slam", "own_slam_to_shrink:Mine", *FAILS, *DROP_ROOMS) == 0
    assert " -> 1 room, " in capsys.readouterr().out
    why = (project / "failure" / "why.md").read_text()
    assert why.splitlines()[2] == "SLAM under test: `own_slam_to_shrink:Mine`"
    assert "| perfect odometry |" in why and "oracle encoder" not in why
    check_the_replay(project)


def test_a_program_is_shrunk_on_images_and_replayed(project, unlit, capsys):
    command = f"'{sys.executable}' program.py {{dataset}} {{out}}"
    assert shrink("images.json", "--command", command, "--timeout", "30", *FAILS, *DROP_ROOMS) == 0
    said = capsys.readouterr().out
    assert "on rendered images, because the SLAM cannot run on feature fidelity" in said and "mended by: nothing." in said
    assert "30.0, 8192.0, 'png')" in (project / "failure" / "test_replay.py").read_text()
    check_the_replay(project)


def test_a_slam_that_raises_is_shrunk_and_replayed(project, capsys):
    assert shrink("scenario.json", "--slam", "own_slam_to_shrink:Lost", "--fails", "crash", *DROP_ROOMS) == 0
    assert " -> 1 room, " in capsys.readouterr().out
    why = (project / "failure" / "why.md").read_text()
    assert "# The SLAM raises RuntimeError" in why and "at 2.5 s: the SLAM raised in process()" in why
    assert "| perfect odometry | still there |" in why
    assert 'raise RuntimeError("lost")' in (project / "failure" / "failure-traceback.txt").read_text()
    assert shrink("failure", "--slam", "own_slam_to_shrink:Lost", "--fails", "crash", *DROP_ROOMS) == 0
    with pytest.raises(RuntimeError, match="lost"):
        replay(project / "failure")
    (project / "floor.txt").write_text("0")
    replay(project / "failure")


def test_a_program_that_fails_is_shrunk_and_replayed(project, unlit, capsys):
    (project / "program.py").write_text("import sys; print('begun'); sys.exit(open('floor.txt').read() + ' floors')")
    command = f"'{sys.executable}' program.py {{dataset}} {{out}}"
    assert shrink("images.json", "--command", command, "--fails", "crash", *DROP_ROOMS) == 0
    why = (project / "failure" / "why.md").read_text()
    assert "# The SLAM ends with exit status 1" in why and "first-wrong" not in why
    assert (project / "failure" / "failure-traceback.txt").read_text() == "3 floors\n"
    printed = [(project / "failure" / f"program.{name}").read_text() for name in ("out", "err")]
    assert printed == ["begun\n", "3 floors\n"]
    with pytest.raises(ProgramError, match="ended with exit status 1: 3 floors"):
        replay(project / "failure")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["images.json", "--command", "x {dataset} {out}", "--fails", "planning.success < 1"],
            "makes no plans, so planning",
        ),
        (["images.json", "--command", "x {dataset}", *FAILS], "has no {out}; valid: such as"),
        (
            ["scenario.json", "--command", "x {dataset} {out}", *FAILS],
            "a program needs images, but the fidelity is 'features'",
        ),
        (
            ["scenario.json", "--slam", "sim.harness.adapters:OdometryOnly", *FAILS],
            "condition 'floors.accuracy < 0.5': floors.accuracy is null; valid: a figure of what the SLAM estimates",
        ),
        (
            ["scenario.json", "--slam", "own_slam_to_shrink:Lost", *FAILS],
            "the SLAM raises RuntimeError: lost; valid: 'crash' in place of this condition",
        ),
        (
            ["scenario.json", "--slam", "own_slam_to_shrink:Mine", "--fails", "crash"],
            "crash: the SLAM does not crash on the scenario; valid: a scenario on which it does",
        ),
        (
            ["scenario.json", "--slam", "own_slam_to_shrink:Mine", "--fails", "floors.accuracy > 0.5"],
            "condition 'floors.accuracy > 0.5': floors.accuracy is 0; valid: a condition that is true of the scenario",
        ),
        (["scenario.json", "--timeout", "3", *FAILS], "--timeout is for programs; valid: with --command"),
    ],
)
def test_what_cannot_be_shrunk_is_named_in_one_line(words, message, project, capsys):
    assert shrink(*words) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1 and not (project / "failure").exists()


def test_the_folder_of_the_scenario_is_not_replaced(tmp_path, capsys):
    run = tmp_path / "run"
    run.mkdir()
    SCENARIO.save(run / "scenario.json")
    for scenario in (run, run / "scenario.json"):
        assert main(["shrink", str(scenario), *FAILS, "-o", str(run)]) == 2
        assert "is the folder of the scenario that is read; valid: another folder" in capsys.readouterr().err
    assert Scenario.load(run / "scenario.json") == SCENARIO
