"""The folder of a failed test: the scenario, the figures and report of the run, why.md, and a test that replays it."""

from dataclasses import dataclass
from pathlib import Path

from lexis.files.replace import replaced_folder
from sim.harness.crash import Crash
from sim.harness.diagnosis.first_wrong import shown_failure
from sim.harness.failures.search import Reference, Search
from sim.harness.failures.why_page import Page, crash_page, failed_test_page
from sim.harness.figures import EvaluatedRun
from sim.harness.outputs import fill_crash_folder, fill_run_folder
from sim.harness.scenario import Scenario
from sim.harness.world_tests import SCENARIO, TEST_REPLAY, WITH_PARAMETERS, slug_of

_REPLAY = '''"""Replays the failure of a test: run pytest on this file, anywhere below the folder that holds the test."""

from pathlib import Path

from sim.pytest_plugin.replay import replay


def test_replay():
    replay(Path(__file__).parent, {test!r}, {options!r})
'''


@dataclass(frozen=True)
class FailedPytest:
    """A pytest test of the user that failed, and how to run it again."""

    name: str
    """File and function as pytest names them, such as "tests/test_slam.py::test_rooms"."""
    replayed_name: str
    """The name by which pytest finds the test in a replay: also with the id of parameters other than the world."""
    options: tuple[str, ...]
    """Options of pytest that a replay needs besides the scenario."""
    figure: str | None = None
    """The figure that the failing assertion is about, such as "floors.accuracy"; None if it is not known."""
    message: str = ""
    """What pytest says about the failure."""

    @property
    def replay(self) -> str:
        """Text of the file test_replay.py."""
        return _REPLAY.format(test=self.replayed_name, options=list(self.options))


def folder_of(out: Path, name: str, scenario: Scenario, parameters: str = "") -> Path:
    """Return the folder for a failure of a test on a scenario; the same failure always gets the same folder.

    `parameters` is the id of the parameters that the test has besides its world. It is part of the folder's name, because
    the test may fail with several parameters in one scenario.
    """
    variant = f"{WITH_PARAMETERS}{slug_of(parameters)}" if parameters else ""
    return out / f"{slug_of(name)}{variant}-{scenario.content_hash}"


def holds_failure(folder: Path, test: FailedPytest, scenario: Scenario) -> bool:
    """Return whether a folder, which the user may have renamed, holds the failure of the test in this scenario."""
    replay = folder / TEST_REPLAY
    return (
        replay.is_file()
        and replay.read_text(encoding="utf-8") == test.replay
        and Scenario.load(folder / SCENARIO) == scenario
    )


def write_failed_test(
    folder: Path,
    test: FailedPytest,
    outcome: EvaluatedRun | Crash,
    search: Search | None,
    reference: Reference,
) -> None:
    """Write scenario.json, why.md and test_replay.py, and either the files of `write_run` or the traceback of a crash.

    `search` is the search that found the scenario, if there was one. An earlier folder of the same failure is replaced.

    Raises `LexisError` where `folder` holds anything else or cannot be written.
    """
    with replaced_folder(folder, SCENARIO) as new:
        for each, content in _page(test, outcome, search, reference).files.items():
            (new / each).write_bytes(content)
        if search is not None:
            search.original.save(new / "original.json")
        (new / TEST_REPLAY).write_text(test.replay, encoding="utf-8")
        if isinstance(outcome, Crash):
            fill_crash_folder(outcome, new)
        else:
            failure = shown_failure(outcome.run, f"{test.name} fails\n{test.message}", test.figure, reference.run)
            fill_run_folder(outcome.run, outcome.result, outcome.trials, new, failure)


def _page(test: FailedPytest, outcome: EvaluatedRun | Crash, search: Search | None, reference: Reference) -> Page:
    if isinstance(outcome, Crash):
        reduction, blamed = (None, None) if search is None else (search.reduction, search.blamed)
        return crash_page(f"{test.name} fails", outcome, reduction, blamed)
    return failed_test_page(test.name, outcome.run, test.figure, test.message, search, reference)
