"""The pytest plugin in pytest sessions of its own, with a SLAM that takes no time."""

import importlib
import itertools
import json
import re
import shutil
import subprocess
import sys
import tomllib
import types
from dataclasses import replace
from functools import partial

import pytest
from helpers.documentation import ROOT
from helpers.pytest_process import isolate_pytest

import sim.harness.shrinking.reducer
import sim.harness.shrinking.reductions
import sim.pytest_plugin.protocol
from sim.harness import Scenario
from sim.harness.run_settings import with_listed_house
from sim.harness.world_tests import FreshWorld
from sim.pytest_plugin.collection import with_world
from sim.pytest_plugin.execution import Reason
from sim.pytest_plugin.options import SEED, pytest_configure_node
from worlds.errors import WorldsError
from worlds.presets import sample_from_rooms
from worlds.spec import HouseSpec

pytest_plugins = ["pytester"]

HEAVY = {"cv2", "gtsam", "hypothesis", "jaxtyping", "mujoco", "numpy", "open_clip", "scipy", "shapely", "torch"}
SLAM = """
import os

import numpy as np
import pytest
from sim.harness import Estimate, worlds

class Stub:
    def start(self, camera, names):
        self.frames, self.poses, self.label = [], [], names.index("kitchen")
    def process(self, observation):
        self.frames.append(observation.index)
        self.poses.append(observation.T_O_B)
    def finish(self):
        return Estimate(np.array(self.frames), T_W_B=np.array(self.poses), labels=np.full(len(self.frames), self.label))

class Lost(Stub):
    def process(self, observation):
        if observation.index == 20:
            raise RuntimeError("lost")
        super().process(observation)

@pytest.fixture
def slam():
    return Stub()

small = worlds(max_rooms=2, n=1, frame_rate_hz=2.0, encoder="oracle")
"""
FAILS = """
class TestBroken:
    @pytest.fixture
    def slam(self):
        raise RuntimeError("no SLAM")

    @small
    def test_broken(self, run):
        pass

class TestLost:
    @pytest.fixture
    def slam(self):
        return Lost()

    @small
    def test_lost(self, run):
        pass

@small
def test_passes(run):
    assert run.planning.queries == 0

@small
def test_labels(run):
    assert run.labels.accuracy > float(os.environ.get("LIMIT", 0.99))
"""
LAYOUT = """
from sim.harness import worlds

@worlds(presets=("home", "office"), openness=(0.2, 0.4), max_rooms=3, n=3, fidelity="layout")
def test_house(scenario):
    assert scenario.seed < 1_000_000
"""


LIGHT = """
import types
from sim.harness.run_settings import with_listed_house
from sim.harness.world_tests import FreshWorld
FreshWorld.scenario = lambda self: types.SimpleNamespace(seed=self.seed)
"""
"""A conftest for tests in processes of their own that look at names and seeds of houses only."""
PLUGIN = ("-p", "no:lexis", "-p", "sim.pytest_plugin")


@pytest.fixture
def start(pytester, monkeypatch):
    """Run pytest in a folder of its own and a process of its own, with the plugin."""
    isolate_pytest(monkeypatch, ROOT)

    def run(*args, plugin=PLUGIN):
        return pytester.runpytest_subprocess(*plugin, "-p", "no:cacheprovider", "--strict-markers", *args)

    return run


@pytest.fixture(scope="module")
def loaded():
    """Load what cannot be loaded twice, before `pytester` notes which modules are to stay."""
    for module in (
        "sim.harness.failures.failed_test",
        "sim.harness.diagnosis.first_wrong",
        "sim.harness.shrinking.reducer",
        "worlds.strategies",
    ):
        importlib.import_module(module)


@pytest.fixture
def inner(loaded, pytester, start):
    """Run pytest in a folder of its own and in this process."""

    def run(*args):
        return pytester.runpytest_inprocess(*PLUGIN, "-p", "no:cacheprovider", "--strict-markers", *args)

    return run


@pytest.fixture
def light(monkeypatch):
    """Let the scenarios of fresh houses consist of a seed, for tests that look at nothing else."""
    monkeypatch.setattr(FreshWorld, "scenario", lambda self: Scenario(seed=self.seed))


def ids(result):
    """The ids that `--collect-only -q` prints."""
    return re.findall(r"^.*::(?:\w+)\[(.*)\]$", result.stdout.str(), re.MULTILINE)


def test_importing_the_plugin_and_decorating_a_test_load_nothing_heavy():
    code = "import sys, sim.pytest_plugin\nfrom sim.harness import worlds\nworlds()(lambda run: None)\nprint(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert HEAVY.isdisjoint(loaded)


def test_failures_are_shown_stored_and_replayed(pytester, inner, monkeypatch):
    pytester.makepyfile(test_slam=SLAM + FAILS)
    result = inner("--no-lexis-shrink", "--junitxml=junit.xml", "--lexis-out", "kept")
    result.assert_outcomes(passed=1, failed=2, errors=1)
    result.stdout.fnmatch_lines(
        [
            "RuntimeError: lost",
            '    test_slam.py:*: raise RuntimeError("lost")',
            "SLAM under test: test_slam:Lost",
            "first wrong: in * at 10.0 s: the SLAM raised in process()",
            "folder: kept/test_slam-TestLost-test_lost-*",
            "replay: pytest -p sim.pytest_plugin test_slam.py::TestLost::test_lost --lexis-replay kept/test_slam-*",
        ],
        consecutive=True,
    )
    result.stdout.fnmatch_lines(
        [
            "AssertionError: assert 0.* > 0.99",
            "    test_slam.py:*: assert run.labels.accuracy > float(*",
            "SLAM under test: test_slam:Stub",
            "first wrong: in * at * s: labelled kitchen, is *",
            "folder: kept/test_slam-test_labels-*",
            "replay: pytest -p sim.pytest_plugin test_slam.py::test_labels --lexis-replay kept/test_slam-test_labels-*",
        ],
        consecutive=True,
    )
    result.stdout.no_fnmatch_line("*def test_labels*")
    assert 'errors="1" failures="2"' in (pytester.path / "junit.xml").read_text()

    folder, lost = sorted(pytester.path.glob("kept/*"), key=lambda path: "Lost" in path.name)
    assert {"scenario.json", "result.json", "report.html", "test_replay.py"} <= {path.name for path in folder.iterdir()}
    assert {"scenario.json", "test_replay.py", "first-wrong-plan.png"} <= {path.name for path in lost.iterdir()}
    assert "RuntimeError: lost" in (lost / "failure-traceback.txt").read_text()
    assert "the SLAM raised in process()" in (lost / "why.md").read_text()
    for page, slam in ((folder, "Stub"), (lost, "Lost")):
        assert (page / "why.md").read_text().splitlines()[2] == f"SLAM under test: `test_slam:{slam}`"
    estimated = json.loads((folder / "result.json").read_text())
    assert estimated["labels"]["accuracy"] < 0.99 and estimated["scenario"] == folder.name[-16:]

    replayed = inner(str(folder / "test_replay.py"))
    replayed.stdout.fnmatch_lines(
        [
            "*_ test_replay _*",
            f"AssertionError: assert {estimated['labels']['accuracy']} > 0.99",
            "    test_slam.py:*: assert run.labels.accuracy > float(*",
            "SLAM under test: test_slam:Stub",
            "first wrong: in * at * s: labelled kitchen, is *",
            f"folder: *kept/{folder.name}",
            "replay: pytest -p sim.pytest_plugin test_slam.py::test_labels --lexis-replay *",
            "=*",
        ],
        consecutive=True,
    )
    monkeypatch.setenv("LIMIT", "0.0")
    moved = (pytester.path / "a folder").joinpath("moved")
    shutil.copytree(folder, moved)
    inner("test_slam.py::test_labels", "--lexis-replay", str(moved)).assert_outcomes(passed=1)
    assert len(list(pytester.path.glob("kept/*"))) == 2 and not (pytester.path / ".lexis-failures").exists()

    pytester.makepyfile(test_slam=(SLAM + FAILS).replace("test_labels", "test_names"))
    told = f"test_slam.py::test_labels does not exist any more; if it was renamed, delete the folder *{folder.name}"
    inner(str(folder / "test_replay.py")).stdout.fnmatch_lines([told])


@pytest.mark.parametrize(
    ("ids", "world", "renamed"),
    [
        ("home-4", "home-4", "chosen"),
        ("home-47-home-4", "home-4", "home-47-chosen"),
        ("home-4-left", "home-4", "chosen-left"),
        ("a-replay-b", "replay", "a-chosen-b"),
        ("my replay-replay", "replay", "my replay-chosen"),
    ],
)
def test_the_id_of_the_world_is_replaced_among_those_of_other_parameters(ids, world, renamed):
    assert with_world(ids, world, "chosen") == renamed


PARAMETERS = """
@pytest.fixture(params=["left", "right"])
def slam(request):
    return Lost() if request.param in os.environ["BROKEN"] else Stub()

@small
def test_eye(run):
    pass
"""


def test_folders_are_replayed_in_one_session_each_with_the_parameters_of_its_failure(pytester, inner, start, monkeypatch):
    pytester.makepyfile(test_slam=SLAM + PARAMETERS)
    monkeypatch.setenv("BROKEN", "left, right")
    inner("--no-lexis-shrink").assert_outcomes(failed=2)
    left, right = sorted((pytester.path / ".lexis-failures").iterdir())
    left.rename(renamed := left.with_name("renamed"))
    replays = [str(renamed / "test_replay.py"), str(right / "test_replay.py")]
    start(*replays).assert_outcomes(failed=2)
    monkeypatch.setenv("BROKEN", "left")
    result = start(*replays)
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["RuntimeError: lost"])
    start(str(right)).assert_outcomes(passed=1)
    (pytester.path / "test_slam.py").unlink()
    result = start(str(right))
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["test_slam.py is not found from *; valid: a place below the folder that holds the file"])
    pytester.makepyfile(test_slam="")
    start(str(right)).stdout.fnmatch_lines(["ERROR: not found: *test_slam.py::test_eye*"])
    assert sorted(path.name for path in left.parent.iterdir()) == ["renamed", right.name]


FLOORS = """
from dataclasses import replace

class OnFloorNine(Stub):
    def finish(self):
        return replace(super().finish(), floors=np.full(len(self.frames), 9))

@pytest.fixture
def slam():
    return OnFloorNine()

@small
def test_floors(run):
    assert run.floors.accuracy > 2.0

@small
def test_positions(run):
    assert run.trajectory.ate_m < 0.0
"""


def test_the_first_wrong_frame_is_wrong_for_the_figure_in_the_assertion(pytester, inner):
    pytester.makepyfile(test_slam=SLAM + FLOORS)
    result = inner("--no-lexis-shrink", "--lexis-out", "kept")
    result.assert_outcomes(failed=2)
    result.stdout.fnmatch_lines(["first wrong: in * at * s: estimated on floor 9, is on floor 0"])
    result.stdout.fnmatch_lines(["first wrong: in * at * s: the position is * m off*"])
    for name in ("why.md", "report.html"):
        pages = [page.read_text() for page in sorted(pytester.path.glob(f"kept/*/{name}"))]
        assert "estimated on floor 9" in pages[0] and "m off" in pages[1]


def test_the_page_of_a_failure_of_floors_counts_the_kinds_of_errors(pytester, inner, monkeypatch):
    steps = {"shorten the tour": sim.harness.shrinking.reductions.STEPS["shorten the tour"]}
    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", partial(sim.harness.shrinking.reducer.reduce, steps=steps))
    pytester.makepyfile(test_slam=SLAM + FLOORS)
    inner("--lexis-out", "kept", "-k", "test_floors").assert_outcomes(failed=1)
    (page,) = (page.read_text() for page in pytester.path.glob("kept/*/why.md"))
    (here,) = re.findall(r"Here, (\d+) of \1 wrong frames are placed on a floor too high; in the original scenario, ", page)
    assert int(here) > 0 and "may fail for another reason" not in page


BEYOND = """
class Beyond(Stub):
    def finish(self):
        estimate = super().finish()
        return Estimate(estimate.frames + 10**6)

@pytest.fixture
def slam():
    return Beyond()

@small
def test_beyond(run):
    pass
"""


def test_a_slam_that_ends_the_process_fails_its_test(pytester, inner):
    leaves = "@pytest.fixture\ndef slam():\n    return Lost(SystemExit)\n\n@small\ndef test_left(run):\n    pass\n"
    lost = SLAM.replace("class Lost(Stub):", "class Lost(Stub):\n    def __init__(self, error):\n        self.error = error")
    pytester.makepyfile(test_slam=lost.replace('raise RuntimeError("lost")', "raise self.error(0)") + leaves)
    result = inner("--no-lexis-shrink", "--lexis-out", "kept")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["SystemExit: 0", "first wrong: in * at 10.0 s: the SLAM raised in process()"])


def test_estimates_that_the_harness_refuses_are_shown_at_the_method_that_returned_them(pytester, inner):
    pytester.makepyfile(test_slam=SLAM + BEYOND)
    inner("--no-lexis-shrink").stdout.fnmatch_lines(
        [
            "sim.errors.EstimateError: estimate: frames has 1000000 in row 0; valid: 0 to *",
            "    test_slam.py:*: def finish(self):",
            "SLAM under test: test_slam:Beyond",
        ],
        consecutive=True,
    )


DRIFTS = """
@small
def test_drift(run):
    print("ran")
    if run.odometry == "perfect":
        raise ValueError("another failure")
    assert run.labels.accuracy > 2.0
"""


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


def test_a_failure_is_stored_in_the_smallest_scenario_with_what_mends_it(pytester, inner, monkeypatch):
    steps = {name: sim.harness.shrinking.reductions.STEPS[name] for name in ("drop drift", "shorten the tour")}
    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", partial(sim.harness.shrinking.reducer.reduce, steps=steps))
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


def test_a_failure_is_shown_even_if_it_cannot_be_found_where_the_original_run_went_wrong(pytester, inner, monkeypatch):
    def unknown(*_):
        raise RuntimeError("no idea")

    steps = {"shorten the tour": sim.harness.shrinking.reductions.STEPS["shorten the tour"]}
    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", partial(sim.harness.shrinking.reducer.reduce, steps=steps))
    monkeypatch.setattr("sim.harness.diagnosis.first_wrong.first_wrong", unknown)
    pytester.makepyfile(test_slam=SLAM + DRIFTS)
    result = inner()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*AssertionError: assert * > 2.0*", "*folder: cannot be written: RuntimeError: no idea"])


def test_the_report_of_a_failure_points_to_the_failing_line(pytester, inner):
    file = pytester.makepyfile(test_slam=SLAM + DRIFTS)
    (failed,) = inner("--no-lexis-shrink").reprec.getfailures()
    crash = failed.longrepr.reprcrash
    line = 1 + file.read_text().splitlines().index("    assert run.labels.accuracy > 2.0")
    assert (crash.path, crash.lineno) == (str(file), line)


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


def test_a_test_relative_to_the_odometry_is_shrunk_to_a_scenario_that_a_mended_slam_passes(pytester, inner, monkeypatch):
    steps = {name: sim.harness.shrinking.reductions.STEPS[name] for name in ("drop rooms", "drop drift", "shorten the tour")}
    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", partial(sim.harness.shrinking.reducer.reduce, steps=steps))
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


def test_the_test_passes_with_the_reference_in_the_smallest_scenario(pytester, inner, monkeypatch):
    steps = {name: sim.harness.shrinking.reductions.STEPS[name] for name in ("drop rooms", "shorten the tour")}
    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", partial(sim.harness.shrinking.reducer.reduce, steps=steps))
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


def test_a_test_that_is_skipped_in_a_smaller_scenario_does_not_pass_there(pytester, inner, monkeypatch):
    steps = {"drop rooms": sim.harness.shrinking.reductions.STEPS["drop rooms"]}
    monkeypatch.setattr(sim.harness.shrinking.reducer, "reduce", partial(sim.harness.shrinking.reducer.reduce, steps=steps))
    pytester.makepyfile(test_slam=SLAM + SKIPPED)
    inner().assert_outcomes(failed=1)
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    assert "goes away" not in (folder / "why.md").read_text()


MISUSED = """
import unittest
from sim.harness import worlds

@worlds(n=1, fidelity="layout")
def test_parts(scenario, subtests):
    with subtests.test("a part"):
        assert scenario is None

class TestWithUnittest(unittest.TestCase):
    @worlds(n=1, fidelity="layout")
    def test_method(self):
        pass

def test_other():
    pass
"""


def test_subtests_and_methods_of_unittest_end_no_session(pytester, start):
    pytester.makeconftest(LIGHT)
    pytester.makepyfile(test_slam=MISUSED)
    result = start()
    result.assert_outcomes(failed=2, passed=1, errors=1)  # the subtest and the test around it fail
    told = "is decorated with @worlds in a TestCase of unittest; valid: a function, or a method of any other class"
    result.stdout.fnmatch_lines([f"test_slam.py::TestWithUnittest::test_method {told}", "E*assert * is None"])


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


@pytest.mark.parametrize("in_ci", [False, True])
def test_common_mistakes_cost_a_line_and_no_traceback(pytester, start, monkeypatch, in_ci):
    mistakes = """
class Endless(Stub):
    finish = None

class TestEndless:
    @pytest.fixture
    def slam(self):
        return Endless()

    @small
    def test_endless(self, run):
        pass

class TestForgets:
    @pytest.fixture
    def slam(self):
        Stub()

    @small
    def test_forgets(self, run):
        pass

@small
def test_no_claim(run):
    assert run.rooms.pq > 0.5

@small
def test_misspelt(run):
    assert run.floors.acuracy > 0.5

@small
def test_group_forgotten(run):
    assert run.ate_m < 0.5

class Looks(Stub):
    def process(self, observation):
        observation.image.mean()

class TestLooks:
    @pytest.fixture
    def slam(self):
        return Looks()

    @small
    def test_looks(self, run):
        pass
"""
    pytester.makepyfile(test_slam=SLAM + mistakes)
    if in_ci:
        monkeypatch.setenv("CI", "true")
    result = start("--no-lexis-shrink")  # in a process without type checks, which refuse such a SLAM before the harness does
    result.assert_outcomes(errors=2, failed=4)
    result.stdout.no_fnmatch_line("*During handling of the above exception*")
    result.stdout.fnmatch_lines(
        [
            "SLAM under test: Endless has no method finish(); valid: *",
            "the fixture slam returned None; valid: a SLAM under test (is `return` missing?)",
            "note: a figure is None if the SLAM does not estimate what *",
            "note: no figure 'acuracy' (did you mean 'accuracy'?); valid: accuracy, count_error",
            "note: no figure 'ate_m' (did you mean 'trajectory.ate_m'?); valid: seed, *",
            'note: with fidelity "features", observation.image is a Percept; valid: worlds(fidelity="render")',
        ]
    )
    assert len(result.outlines) < 60


@pytest.mark.parametrize(
    ("module", "conftest", "place"),
    [
        ("slam = Stub()", "", "test_slam.py"),
        ("def slam():\n    return Stub()", "", "test_slam.py"),
        ("", "def slam():\n    return 3", "*conftest.py"),
        ("from lexis import slam", "", None),
        ("slam = Stub()", "import pytest\n\n@pytest.fixture\ndef slam():\n    return 3", None),
        ("@pytest.fixture(name='other')\ndef slam():\n    return Stub()", "", None),
    ],
)
def test_a_slam_that_is_no_fixture_is_an_error_of_collection(pytester, inner, module, conftest, place):
    imports = SLAM.partition("@pytest.fixture")[0]
    test = "@worlds(n=1)\ndef test_run(run):\n    pass"
    pytester.makepyfile(test_slam=f"{imports}\n{module}\n\n{test}\n")
    pytester.makeconftest(conftest)
    result = inner("--collect-only")
    result.assert_outcomes(errors=0 if place is None else 1)
    if place is not None:
        told = f"test_slam.py::test_run would test LEXIS: the name slam in {place} is no fixture; valid: @pytest.fixture *"
        result.stdout.fnmatch_lines([told])
        assert len(result.outlines) < 15


def test_a_reference_that_is_no_fixture_is_an_error_of_collection(pytester, inner):
    pytester.makepyfile(test_slam=SLAM + "reference_slam = Stub()\n@small\ndef test_run(run):\n    pass\n")
    result = inner("--collect-only")
    result.assert_outcomes(errors=1)
    told = "test_run would be shrunk without a reference: the name reference_slam in test_slam.py is no fixture; valid: *"
    result.stdout.fnmatch_lines([f"test_slam.py::{told}"])


def test_a_house_that_cannot_be_made_costs_a_line_and_no_traceback(pytester, inner, monkeypatch):
    def refuse(self):
        raise WorldsError("no house")

    monkeypatch.setattr(FreshWorld, "scenario", refuse)
    pytester.makepyfile(test_slam=LAYOUT)
    result = inner()
    result.assert_outcomes(errors=3)
    result.stdout.fnmatch_lines(["no house"])
    assert len(result.outlines) < 25


@pytest.mark.parametrize("figure", ["floors.acuracy", "rooms.pq"])
def test_a_figure_that_is_misspelt_or_not_estimated_is_no_failure_to_shrink(pytester, inner, figure):
    pytester.makepyfile(test_slam=SLAM + f"\n@small\ndef test_none(run):\n    assert run.{figure} > 0.5\n")
    inner().assert_outcomes(failed=1)
    assert not list(pytester.path.glob(".lexis-failures/*/original.json"))


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
PLAIN = """
from hypothesis import given, settings, strategies as st
from sim import Scenario, check
from worlds import sample_from_rooms

HOUSES = [sample_from_rooms(("kitchen", "bedroom"), seed=seed) for seed in (21, 22)]

def accuracy(house):
    scenario = Scenario(house=house, length_m=15.0, frame_rate_hz=2.0, fidelity="features", encoder="oracle")
    return check(scenario, Stub()).labels.accuracy

def test_plain():
    assert accuracy(HOUSES[int(os.environ.get("HOUSE", 1))]) > float(os.environ.get("LIMIT", 0.99))

@settings(deadline=None, max_examples=5, database=None)
@given(house=st.sampled_from(HOUSES))
def test_drawn(house):
    assert accuracy(house) > 0.99 or house is HOUSES[0]
    print("ran")
"""


def test_a_run_that_a_test_starts_by_itself_is_stored_and_replayed(pytester, inner, monkeypatch):
    pytester.makepyfile(test_slam=SLAM + PLAIN)
    result = inner("--lexis-out=kept", "--junitxml=junit.xml")
    result.assert_outcomes(failed=2)
    assert (pytester.path / "junit.xml").read_text().count("replay: pytest -p sim.pytest_plugin test_slam.py::test_") == 2
    folders = {path.name.split("-")[1]: path for path in pytester.path.glob("kept/*")}
    for name in ("test_plain", "test_drawn"):
        assert {"scenario.json", "result.json", "report.html", "test_replay.py"} <= {p.name for p in folders[name].iterdir()}
        assert json.loads((folders[name] / "scenario.json").read_text())["house"]["name"] == "rooms-22"

    monkeypatch.setenv("HOUSE", "0")
    replayed = inner("--lexis-out=kept", f"--lexis-replay={folders['test_plain']}")
    replayed.assert_outcomes(failed=2)
    assert "Failing test case" in result.stdout.str() and "Failing test case" not in replayed.stdout.str()
    assert len({path.name[-16:] for path in pytester.path.glob("kept/*")}) == 1


IDLE = """
@worlds(max_rooms=2, n=1, frame_rate_hz=2.0, encoder="oracle", length_m=15, faults=("kidnap:5", "stamp-jump:at_s=999"))
def test_faults(run):
    pass

@worlds(max_rooms=2, n=1, frame_rate_hz=2.0, encoder="oracle", length_m=15, faults="kidnap:5")
def test_kidnap(run):
    pass
"""


def test_a_fault_without_effect_is_a_warning(pytester, inner):
    pytester.makepyfile(test_slam=SLAM + IDLE)
    result = inner()
    result.assert_outcomes(passed=2, warnings=1)
    result.stdout.fnmatch_lines(["*The fault stamp-jump changed no frame; a fault that begins after the end of the walk *"])


COUNTED = """
import os
from pathlib import Path
import pytest

@pytest.fixture
def slam(scenario):
    with Path("seeds").open("a") as file:
        file.write(f"{scenario.seed}\\n")

@worlds(max_rooms=2, n=2)
def test_counted(scenario, slam):
    print("ran")
    assert scenario.seed != int(os.environ.get("BAD", -1))
"""


SKIPS_LATER = """
import pytest

houses = []

@worlds(n=1, fidelity="layout")
def test_skips(house):
    houses.append(house)
    if len(houses) == 2:
        pytest.skip("not here")
"""


def test_failures_without_python_source_end_no_session(pytester, inner):
    """Templates rewrite tracebacks to their own files; the plugin is loaded in projects that never use LEXIS-sim, too."""
    pytester.path.joinpath("page.html").write_text("<p>\n{{ 1 / 0 }}\n")
    code = "def test_{}():\n    exec(compile('\\n1 / 0', '{}', 'exec'))\n\n"
    pytester.makepyfile(test_page=code.format("template", "page.html") + code.format("text", "<string>"))
    inner().assert_outcomes(failed=2)


def test_a_budget_is_spent_on_further_houses_until_one_fails(pytester, inner, light, monkeypatch):
    clock = itertools.count()
    monkeypatch.setattr(sim.pytest_plugin.protocol, "time", types.SimpleNamespace(monotonic=lambda: next(clock)))
    pytester.makepyfile(test_slam=LAYOUT.partition("@")[0] + COUNTED)
    inner("--lexis-budget", "8s").assert_outcomes(passed=2)
    seeds = (pytester.path / "seeds").read_text().split()
    assert len(seeds) == len(set(seeds)) == 2 * 4

    monkeypatch.setenv("BAD", seeds[2])
    result = inner("--lexis-budget", "8s", "--no-lexis-shrink")
    result.assert_outcomes(passed=1, failed=1)
    assert result.stdout.str().count("ran\n") == 1
    assert f"assert {seeds[2]} != {seeds[2]}" in result.stdout.str()
    result.stdout.fnmatch_lines([f"house: *-{seeds[2]}, a further one within --lexis-budget"])


def test_a_test_that_is_skipped_in_a_further_house_has_passed(pytester, inner, light, monkeypatch):
    clock = itertools.count()
    monkeypatch.setattr(sim.pytest_plugin.protocol, "time", types.SimpleNamespace(monotonic=lambda: next(clock)))
    pytester.makepyfile(test_slam=LAYOUT.partition("@")[0] + SKIPS_LATER)
    inner("--lexis-budget", "8s").assert_outcomes(passed=1)


@pytest.mark.parametrize(
    ("dist", "workers"), [("load", 2), ("worksteal", 2), ("loadfile", 1), ("loadgroup", 1), ("each", 1)]
)
def test_the_budget_is_multiplied_only_for_workers_that_share_the_tests(dist, workers):
    config = types.SimpleNamespace(option=types.SimpleNamespace(dist=dist), stash={SEED: 7})
    node = types.SimpleNamespace(config=config, workerinput={"workercount": 2})
    pytest_configure_node(node)
    assert node.workerinput == {"workercount": 2, "lexis_seed": 7, "lexis_workers": workers}


def test_workers_of_xdist_collect_the_same_fresh_houses(pytester, start, inner):
    conftest = pytester.makeconftest(LIGHT)
    pytester.makepyfile(test_houses=LAYOUT)
    result = start("-p", "xdist", "-n", "2", "--lexis-profile", "lexis-nightly", "-v")
    result.assert_outcomes(passed=3)
    seed = re.search(r"--lexis-seed (\d+) \(lexis-nightly\)", result.stdout.str())[1]
    conftest.unlink()  # sessions in this process would replace `FreshWorld.scenario` for good
    ran = set(re.findall(r"PASSED test_houses.py::test_house\[(.*?)\]", result.stdout.str()))
    assert ran == set(ids(inner("--collect-only", "-q", "--lexis-seed", seed)))


@pytest.mark.parametrize("out", ["kept", "../{}/kept", "linked"])
def test_tests_in_folders_of_failures_are_collected_only_by_name(pytester, inner, out):
    pytester.makepyfile(test_own="def test_own(): pass")
    stored = pytester.path / "kept" / "failure"
    stored.mkdir(parents=True)
    (stored / "test_replay.py").write_text("def test_replay(): pass")
    (pytester.path / "linked").symlink_to("kept")
    out = out.format(pytester.path.name)
    inner("--lexis-out", out).assert_outcomes(passed=1)
    inner("--lexis-out", out, "kept/failure").assert_outcomes(passed=1)


def test_the_nightly_profile_replays_stored_failures_of_the_same_test_first(pytester, inner):
    pytester.makepyfile(test_houses=LAYOUT)
    for name in ("test_houses-test_house", "test_houses-test_house_2", "other-test_house"):
        folder = pytester.path / ".lexis-failures" / f"{name}-0123456789abcdef"
        folder.mkdir(parents=True)
        (folder / "scenario.json").write_text("{}")
    nightly = ids(inner("--collect-only", "-q", "--lexis-profile", "lexis-nightly", "--lexis-seed", "3"))
    usual = ids(inner("--collect-only", "-q", "--lexis-seed", "3"))
    assert nightly == ["failed-01234567", *usual] and len(usual) == 3
    assert ids(inner("--collect-only", "-q", "-m", "not layout")) == []


def test_wrong_options_and_tests_are_told_in_one_line(pytester, inner):
    pytester.makepyfile(test_houses=LAYOUT)
    for option, value, message in (
        ("--lexis-budget", "5 m", "'5 m'; valid: a time such as 90s, 3m or 1h"),
        (
            "--lexis-replay",
            "gone",
            "--lexis-replay: *gone does not exist; valid: a scenario file or the folder of a failure",
        ),
    ):
        result = inner(f"{option}={value}")
        assert result.ret == pytest.ExitCode.USAGE_ERROR
        result.stderr.fnmatch_lines([f"*{message}"])
    pytester.makepyfile(test_houses=LAYOUT.replace("(scenario)", "()"))
    result = inner()
    result.stdout.fnmatch_lines(["test_houses.py::test_house is decorated with @worlds and takes no house; valid: *"])
    assert len(result.outlines) < 15
    pytester.makepyfile(test_houses=LAYOUT.replace("(scenario)", "(run)"))
    inner().stdout.fnmatch_lines(["test_houses.py::test_house takes run, but no SLAM runs with fidelity 'layout'; valid: *"])
    pytester.makepyfile(test_houses="def test_plain(run):\n    pass\n")
    result = inner()
    result.stdout.fnmatch_lines(["*test_plain: the test has no houses; valid: a test that is decorated with @worlds*"])
    assert len(result.outlines) < 15


def test_the_entry_point_loads_the_plugin_and_no_lexis_switches_it_off(pytester, start, monkeypatch):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    ((name, module),) = project["entry-points"]["pytest11"].items()
    folder = pytester.path / "trial-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: trial\nVersion: 1.0\n")
    (folder / "entry_points.txt").write_text(f"[pytest11]\n{name} = {module}\n")
    pytester.syspathinsert()
    pytester.makepyfile(test_houses=LAYOUT)
    monkeypatch.delenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD")
    assert len(ids(start("--collect-only", "-q", plugin=()))) == 3
    pytester.makepyfile(test_houses="def test_plain():\n    pass\n")
    result = start("-p", "no:lexis", plugin=())
    result.assert_outcomes(passed=1)
    result.stdout.no_fnmatch_line("*lexis-seed*")


@pytest.mark.parametrize(
    ("statement", "figure"),
    [
        ("assert run.floors.accuracy > 0.9", "floors.accuracy"),
        ("assert result.coverage.path_covered > 0.9", "coverage.path_covered"),
        ("assert run.planning.success == 1.0", "planning.success"),
        ('assert run.place_recognition["1"].tp > 9', "place_recognition"),
        ("assert len(rooms) == 3", None),
    ],
)
def test_a_figure_is_found_in_the_failing_statement(statement, figure):
    assert Reason("", "", 0, "", statement, "", AssertionError()).figure == figure
