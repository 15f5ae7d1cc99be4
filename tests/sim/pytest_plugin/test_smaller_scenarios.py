"""The search for the smallest scenario in which a decorated test fails."""

import json
import re
import shlex
import shutil
from dataclasses import replace
from functools import partial

import pytest
from helpers.plugin_sessions import DRIFTS, LAYOUT, SLAM

import sim.harness.shrinking.reducer
import sim.harness.shrinking.reductions
from sim.cli import main
from sim.harness import Scenario
from sim.harness.run_settings import with_listed_house
from worlds.presets import sample_from_rooms
from worlds.spec import HouseSpec

pytest_plugins = ["pytester"]


@pytest.fixture
def search_by(monkeypatch):
    """Returns a function after which the search for smaller scenarios takes the steps of these names only."""

    def search_by(*names):
        steps = {name: sim.harness.shrinking.reductions.STEPS[name] for name in names}
        reduce = partial(sim.harness.shrinking.reducer.reduce, steps=steps)
        monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", reduce)

    return search_by


def test_a_scenario_that_cannot_run_is_not_one_that_passes(pytester, inner, monkeypatch):
    room = {"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [1.2, 0], [1.2, 1.2], [0, 1.2]]}
    cupboard = HouseSpec.from_json(json.dumps({"storeys": [{"rooms": [room]}]}))  # valid, but there is nowhere to walk to
    steps = {"a cupboard": lambda scenario: [with_listed_house(replace(scenario, house=cupboard))]}
    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", partial(sim.harness.shrinking.reducer.reduce, steps=steps))
    pytester.makepyfile(test_slam=SLAM + DRIFTS)
    inner().assert_outcomes(failed=1)
    (why,) = (page.read_text() for page in pytester.path.glob(".lexis-failures/*/why.md"))
    assert "None of the smaller scenarios that were run passes." in why
    assert "1 candidate, 0 steps" in why


def test_a_failure_is_stored_in_the_smallest_scenario_with_what_mends_it(pytester, inner, search_by):
    search_by("drop drift", "shorten the tour")
    pytester.makepyfile(test_slam=SLAM + DRIFTS)
    result = inner()
    result.assert_outcomes(failed=1)
    assert result.stdout.str().count("ran\n") == 1
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    small, original = (json.loads((folder / f"{name}.json").read_text()) for name in ("scenario", "original"))
    assert small["length_m"] < 20.0 and small["odometry"] == original["odometry"] != "perfect"
    assert json.loads((folder / "result.json").read_text())["scenario"] == folder.name[-16:]
    why = (folder / "why.md").read_text()
    assert "test_slam.py:33: assert run.labels.accuracy > 2.0" in why and "AssertionError: assert 0." in why
    assert "Mended by: nothing. Not mended by: no clutter" in why
    assert "| perfect odometry | unknown: it fails differently: raises ValueError" in why
    assert "| length of the tour [m] |" in why and "(first-wrong-plan.png)" in why
    small_said, original_said = re.findall(r"AssertionError: assert (0\.\d+) > 2\.0", why)
    assert re.search(r"The original run first went wrong in .* at [\d.]+ s: labelled kitchen, is ", why)
    assert small_said != original_said and "kept their ids" not in why
    result.stdout.fnmatch_lines([f"in the original scenario: AssertionError: assert {original_said} > 2.0"])


def test_a_search_that_removes_all_furniture_says_how_to_keep_it(pytester, inner, search_by):
    search_by("drop furniture")
    pytester.makepyfile(test_slam=SLAM + DRIFTS)
    inner().assert_outcomes(failed=1)
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    why = (folder / "why.md").read_text()
    assert "No furniture is left by which an encoder could recognise a room." in why
    (command,) = re.findall("`lexis-sim (shrink .* -o furnished)`", why)
    assert " --slam test_slam:Stub " in command
    words = shlex.split(command.replace("PATH", str(folder)).replace("CONDITION", "'labels.accuracy < 2'"))
    assert main([*words, "--deadline", "1s"]) == 0
    furniture = {name: furniture_of(pytester.path / name) for name in ("furnished", folder)}
    assert furniture["furnished"] and not furniture[folder]


def furniture_of(folder):
    """All furniture in the house of the smallest scenario."""
    return [piece for storey in Scenario.load(folder / "scenario.json").house.storeys for piece in storey.furniture]


RELATIVE = """
from sim.harness import Lexis

class TestLoops:
    @pytest.fixture
    def slam(self, scenario):
        return Lexis(scenario.encoder) if os.environ.get("MENDED") else Stub()

    @small
    def test_loops_help(self, run):
        error, before = run.trajectory.ate_m, run.trajectory.ate_odometry_m
        assert error < before
"""


def test_a_test_relative_to_the_odometry_is_shrunk_to_a_scenario_that_a_mended_slam_passes(
    pytester, inner, search_by, monkeypatch
):
    search_by("drop rooms", "drop drift", "shorten the tour")
    pytester.makepyfile(test_slam=SLAM + RELATIVE)
    inner().assert_outcomes(failed=1)
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    small, original = (json.loads((folder / f"{name}.json").read_text()) for name in ("scenario", "original"))
    assert small["length_m"] < 20.0 and small["odometry"] == original["odometry"] != "perfect"
    why = (folder / "why.md").read_text()
    assert "| perfect odometry | unknown: a good SLAM fails there, too |" in why
    assert "candidates did not count, because a good SLAM fails there, too." in why
    inner("--lexis-replay", str(folder), "--no-lexis-shrink").assert_outcomes(failed=1)
    monkeypatch.setenv("MENDED", "1")
    inner("--lexis-replay", str(folder)).assert_outcomes(passed=1)


REFERENCE = """
class Silent(Stub):
    def finish(self):
        return Estimate(np.array(self.frames), T_W_B=np.array(self.poses))

@pytest.fixture
def reference_slam():
    return Silent() if not os.environ.get("LABELS") else Stub()

@small
def test_walk(run):
    assert run.run.path_m > 10 and run.labels.accuracy is None

@small
def test_house(scenario, slam):
    assert scenario is None
"""


def test_the_test_passes_with_the_reference_in_the_smallest_scenario(pytester, inner, search_by, monkeypatch):
    search_by("drop rooms", "shorten the tour")
    pytester.makepyfile(test_slam=SLAM + REFERENCE)
    told, left_out = (
        "reference: test_slam:Silent passes in this scenario",
        "note: reference_slam is not used, because the test ",
    )

    def path_m():
        (folder,) = (pytester.path / ".lexis-failures").iterdir()
        return json.loads((folder / "result.json").read_text())["run"]["path_m"], (folder / "why.md").read_text()

    result = inner("-k", "walk")
    result.stdout.fnmatch_lines(["SLAM under test: test_slam:Stub", told])
    walked_m, why = path_m()
    assert walked_m > 10.0
    result.stdout.fnmatch_lines(["shrunk: * rooms, * -> * room, *"])
    assert "The test passes with the reference, `test_slam:Silent`." in why and "and the reference did not" in why
    assert "did not count, because the reference fails there, too." in why
    place = re.findall("first wrong: .*", result.stdout.str())
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    replayed = inner("-k", "walk", "--lexis-replay", str(folder))
    replayed.stdout.fnmatch_lines([told])
    assert re.findall("first wrong: .*", replayed.stdout.str()) == place

    shutil.rmtree(pytester.path / ".lexis-failures")
    monkeypatch.setenv("LABELS", "1")
    result = inner("-k", "walk")
    result.stdout.fnmatch_lines([f"{left_out}fails with it, too: AssertionError: *"])
    walked_m, why = path_m()
    assert walked_m < 10.0 and "reference_slam is not used" in why
    inner("-k", "house").stdout.fnmatch_lines([f"{left_out}does not take run."])


SKIPPED = """
@worlds(max_rooms=3, n=1, frame_rate_hz=2.0, encoder="oracle")
def test_rooms(run, house):
    if len(house.rooms) < 3:
        pytest.skip("too small")
    assert run.labels.accuracy > 2.0
"""


def test_a_test_that_is_skipped_in_a_smaller_scenario_does_not_pass_there(pytester, inner, search_by):
    search_by("drop rooms")
    pytester.makepyfile(test_slam=SLAM + SKIPPED)
    inner().assert_outcomes(failed=1)
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    assert "goes away" not in (folder / "why.md").read_text()


INTERRUPTED = """
executions = []

@worlds(max_rooms=2, n=2, fidelity="layout")
def test_interrupted(scenario):
    executions.append(scenario)
    if len(executions) == INTERRUPTED_AT:
        raise KeyboardInterrupt
    assert len(executions) > 5
"""


@pytest.mark.parametrize("at", [2, 3])
def test_after_ctrl_c_in_shrinking_the_failure_is_shown_and_pytest_stops(pytester, inner, at):
    pytester.makepyfile(test_slam=LAYOUT.partition("@")[0] + INTERRUPTED.replace("INTERRUPTED_AT", str(at)))
    result = inner()
    assert result.ret == pytest.ExitCode.INTERRUPTED
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([f"AssertionError: assert {at - 1} > 5"])


def test_a_failure_that_does_not_come_back_is_shown_as_it_was_found(pytester, inner):
    once = "\n@small\ndef test_once(run, done=[]):\n    done.append(run)\n    assert len(done) > 1\n"
    pytester.makepyfile(test_slam=SLAM + once)
    result = inner()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["AssertionError: assert 1 > 1", "folder: .lexis-failures/test_slam-test_once-*"])


def test_a_search_that_breaks_does_not_lose_the_failure(pytester, inner, monkeypatch):
    def broken(*_):
        raise RuntimeError("no smaller house")

    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", broken)
    pytester.makepyfile(test_slam=SLAM + DRIFTS)
    result = inner()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "AssertionError: assert 0.* > 2.0",
            "not shrunk: RuntimeError: no smaller house",
            "folder: .lexis-failures/test_slam-test_drift-*",
        ]
    )


def test_the_replay_in_a_folder_of_shrink_leaves_no_other_folder(pytester, inner):
    pytester.makepyfile(test_replay=SLAM + REPLAY)
    scenario = Scenario(house=sample_from_rooms(("kitchen",), seed=3), length_m=5.0, fidelity="features", encoder="oracle")
    scenario.save(pytester.path / "scenario.json")
    result = inner()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["folder: .", "replay: pytest -p sim.pytest_plugin test_replay.py::test_replay *"])
    assert not (pytester.path / ".lexis-failures").exists()


REPLAY = """
from pathlib import Path
from sim.harness import Scenario, run

def test_replay():
    run(Scenario.load(Path(__file__).with_name("scenario.json")), Lost())
"""
