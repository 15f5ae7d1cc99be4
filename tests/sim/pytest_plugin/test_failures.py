"""Failures of decorated tests: what pytest shows of them, what it stores, and how they are replayed."""

import json
import re
import shutil
from contextlib import nullcontext
from functools import partial

import pytest
from helpers.plugin_sessions import DRIFTS, LAYOUT, SLAM, ids

import sim.harness.shrinking.reducer
import sim.harness.shrinking.reductions
from sim.harness import Scenario
from sim.pytest_plugin.collection import with_world
from sim.pytest_plugin.execution import Reason
from sim.pytest_plugin.replay import replay

pytest_plugins = ["pytester"]


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


def test_failures_without_python_source_end_no_session(pytester, inner):
    """Templates rewrite tracebacks to their own files; the plugin is loaded in projects that never use LEXIS-sim, too."""
    pytester.path.joinpath("page.html").write_text("<p>\n{{ 1 / 0 }}\n")
    code = "def test_{}():\n    exec(compile('\\n1 / 0', '{}', 'exec'))\n\n"
    pytester.makepyfile(test_page=code.format("template", "page.html") + code.format("text", "<string>"))
    inner().assert_outcomes(failed=2)


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


@pytest.mark.parametrize(
    ("body", "outcome"),
    [("pytest.skip('no GPU')", pytest.skip.Exception), ("pass", None), ("if number: pytest.skip('no GPU')", None)],
)
def test_a_replay_in_which_the_test_is_skipped_does_not_count_as_passed(pytester, body, outcome):
    pytester.makepyfile(
        test_own=f"import pytest\n\n@pytest.mark.parametrize('number', [0, 1])\ndef test_own(number):\n    {body}\n"
    )
    failure = pytester.mkdir("failure")
    Scenario().save(failure / "scenario.json")
    with nullcontext() if outcome is None else pytest.raises(outcome, match=r"nothing was replayed: .*no GPU"):
        replay(failure, "test_own.py::test_own", ("-p", "no:lexis", "-p", "sim.pytest_plugin"))


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
