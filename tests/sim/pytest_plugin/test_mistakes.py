"""Mistakes in decorated tests: each is told in a line, without a traceback, and is no failure of the SLAM."""

import pytest
from helpers.plugin_sessions import LAYOUT, LIGHT, SLAM

from sim.harness.world_tests import FreshWorld
from worlds.errors import WorldsError

pytest_plugins = ["pytester"]


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


def test_wrong_options_and_tests_are_told_in_one_line(pytester, inner):
    pytester.makepyfile(test_houses=LAYOUT)
    for option, value, message in (
        ("--lexis-budget", "5 m", "'5 m'; valid: a time such as 90s, 3m or 1h"),
        (
            "--lexis-replay",
            "gone",
            "--lexis-replay: *gone does not exist; valid: a scenario file or the folder of a failure",
        ),
        ("--lexis-out", "test_houses.py", "--lexis-out: *test_houses.py is no folder; valid: the name of a folder*"),
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
