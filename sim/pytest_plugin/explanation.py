"""What pytest shows of a failure: what failed, where it first went wrong, the failure's folder, and how to replay it."""

import shlex
from os.path import relpath
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from _pytest._code.code import ExceptionRepr, ReprEntryNative, ReprExceptionInfo, ReprFileLocation, ReprTraceback

from lexis.errors import one_line
from sim.harness.world_tests import SCENARIO, TEST_REPLAY, StoredWorld
from sim.pytest_plugin.collection import family_of, name_of, parameters_of, replayed_name
from sim.pytest_plugin.execution import Execution, Reason
from sim.pytest_plugin.options import loading_options, out_folder, replayed_file
from sim.wording import error_text

if TYPE_CHECKING:
    from sim.harness.crash import Crash
    from sim.harness.failures.failed_test import FailedPytest
    from sim.harness.failures.search import Search
    from sim.harness.figures import EvaluatedRun
    from sim.harness.scenario import Scenario


def add_text(
    item: pytest.Item,
    execution: Execution,
    report: pytest.TestReport,
    search: "Search | None" = None,
    problem: Exception | None = None,
    further: str = "",
) -> None:
    """Write the folder of a failure, and add to the report what failed, where, in which folder, and how to replay it.

    For a decorated test this text replaces the traceback, unless the user has chosen a style with `--tb`. A test that is not
    decorated keeps its traceback. `search` is the search that found the scenario, if there was one. `problem` is the
    exception that ended the search without a result. `further` is the name of the house in which the test failed, if it is a
    further one within `--lexis-budget` and not that in the test's id.
    """
    failure, scenario = execution.failure, execution.tested
    assert failure is not None and scenario is not None
    lines = [failure.message, f"    {failure.where}: {failure.statement}"]
    rest = [f"house: {further}, a further one within --lexis-budget"] if further else []
    rest += [] if problem is None else [f"not shrunk: {one_line(error_text(problem), 160)}"]
    rest += _lines(item, execution, failure, scenario, search)
    before = search.found if search is not None and search.found != failure.text else ""
    if family_of(item) is not None and item.config.option.tbstyle == "auto":
        original = [f"in the original scenario: {_headline(before)}"] if before else []
        report.longrepr = _without_traceback([*lines, *original, *rest], failure)
    elif isinstance(report.longrepr, ExceptionRepr):  # JUnit reports show sections of this object, too
        smallest = [f"in the smallest scenario: {_headline(failure.message)}"] if before else []
        report.longrepr.addsection("lexis", "\n".join([*smallest, *rest]))
    else:
        report.sections.append(("lexis", "\n".join(rest)))


def _headline(text: str) -> str:
    """Return the first line of what pytest says about a failure, and the assertion if a message of the user precedes it."""
    first, *rest = text.splitlines()
    return f"{first}; {rest[0]}" if rest and rest[0].startswith("assert ") else first


def _without_traceback(lines: list[str], failure: Reason) -> ExceptionRepr:
    """Return a report that consists of these lines.

    It is not a plain string, because pytest's summary repeats the whole of a string in CI, and with `-vv`. The summary
    repeats only the message of an object like this one, which is the first line.
    """
    text = "".join(f"{line}\n" for line in lines)
    crash = ReprFileLocation(failure.file, failure.line, lines[0].splitlines()[0])
    return ReprExceptionInfo(ReprTraceback([ReprEntryNative([text])], None, "native"), crash)


def _lines(
    item: pytest.Item, execution: Execution, failure: Reason, scenario: "Scenario", search: "Search | None"
) -> list[str]:
    """Write the folder of a failure; return lines with the first wrong frame, the folder and the command for a replay."""
    error = failure.error
    lines = [f"SLAM under test: {execution.last.slam_name}"] if execution.last.slam_name else []
    lines += [f"note: {failure.unknown_figure}"] if failure.unknown_figure else []
    if execution.run is not None and failure.uses_none:
        lines.append("note: a figure is None if the SLAM does not estimate what the figure is computed from")
    if isinstance(error, AttributeError | TypeError) and "Percept" in str(error):
        lines.append('note: with fidelity "features", observation.image is a Percept; valid: worlds(fidelity="render")')
    try:
        place = execution.first_wrong
        lines += [f"first wrong: {place}"] if place else []
        lines += _about_reference(execution) + _about_search(search)
        folder = _folder(item, execution, failure, _outcome(execution, error, scenario), search)
    except Exception as problem:  # whatever it is, the failure of the test must not be lost
        return [*lines, f"folder: cannot be written: {one_line(error_text(problem), 160)}"]
    return [*lines, *replay_lines(item, replayed_name(item), shown_folder(item, folder))]


def shown_folder(item: pytest.Item, folder: Path) -> Path:
    """Return the folder of a failure as it is shown: from the current folder, unless `--lexis-out` is absolute."""
    return folder if item.config.option.lexis_out.is_absolute() else Path(relpath(folder, item.config.invocation_params.dir))


def replay_lines(item: pytest.Item, name: str, shown: Path) -> list[str]:
    """Return lines with the folder of a failure and the command that replays it.

    `name` is the name by which pytest finds the test in a replay, and `shown` the folder, as `shown_folder` returns it.
    """
    test = relpath(item.path, item.config.invocation_params.dir) + "".join(name.partition("::")[1:])
    command = shlex.join(["pytest", *loading_options(item.config), test, "--lexis-replay", str(shown)])
    return [f"folder: {shown}", f"replay: {command}"]


def _about_reference(execution: Execution) -> list[str]:
    """Return a line on the SLAM of the fixture `reference_slam`; none without one."""
    from sim.harness.slam_under_test import full_name_of

    reference = execution.reference
    if reference is None:
        return []
    if reference.run is not None:
        return [f"reference: {full_name_of(reference.run.slam)} passes in this scenario"]
    return [f"note: {reference.left_out}"] if reference.left_out else []


def _about_search(search: "Search | None") -> list[str]:
    """Return a line on how much smaller the scenario has become; none if it has not."""
    if search is None or not search.reduction.accepted:
        return []
    old, new = search.reduction.sizes
    return [f"shrunk: {old} -> {new}"]


def _folder(
    item: pytest.Item, execution: Execution, failure: Reason, outcome: "EvaluatedRun | Crash", search: "Search | None"
) -> Path:
    """Write the folder of a failure, and return its path.

    Nothing is written if this folder is being replayed, or if the test itself is in it.
    """
    from sim.harness.failures.failed_test import folder_of, holds_failure, write_failed_test
    from sim.harness.failures.search import NO_REFERENCE

    if _is_in_its_folder(item, outcome.scenario):
        return item.path.parent
    test, replayed = _failed_test(item, failure), _replayed(item, execution)
    if replayed is not None and holds_failure(replayed.parent, test, outcome.scenario):
        return replayed.parent
    folder = folder_of(out_folder(item.config), name_of(item), outcome.scenario, parameters_of(item))
    write_failed_test(folder, test, outcome, search, execution.reference or NO_REFERENCE)
    return folder


def _failed_test(item: pytest.Item, failure: Reason) -> "FailedPytest":
    from sim.harness.failures.failed_test import FailedPytest

    options = tuple(loading_options(item.config))
    return FailedPytest(name_of(item), replayed_name(item), options, failure.figure, failure.text)


def _is_in_its_folder(item: pytest.Item, scenario: "Scenario") -> bool:
    """Return whether the test is test_replay.py in the folder of a failure, with its scenario beside it.

    `lexis-sim shrink` and `lexis-sim check` write these folders.
    """
    from sim.errors import SimError
    from sim.harness.scenario import Scenario
    from worlds.errors import WorldsError

    beside = item.path.with_name(SCENARIO)
    try:
        return item.path.name == TEST_REPLAY and beside.is_file() and Scenario.load(beside) == scenario
    except (SimError, WorldsError):
        return False


def _replayed(item: pytest.Item, execution: Execution) -> Path | None:
    """Return the scenario file that this execution replays; None if it is no replay."""
    if execution.world is None:
        return replayed_file(item.config)
    return execution.world.file if isinstance(execution.world, StoredWorld) else None


def _outcome(execution: Execution, error: BaseException, scenario: "Scenario") -> "EvaluatedRun | Crash":
    """Return the finished run with its figures, which are computed if need be, or the crash if no run was finished."""
    from sim.harness.crash import Crash
    from sim.harness.figures import EvaluatedRun, evaluate

    if execution.run is None:
        return Crash(scenario, error, execution.crashed_at, execution.last.slam_name)
    result, trials = execution.last.result, execution.last.trials
    return EvaluatedRun(execution.run, result or evaluate(execution.run, trials), trials)
