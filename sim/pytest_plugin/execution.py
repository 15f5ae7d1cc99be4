"""Executes a test once, and records its runs and the reason for its failure."""

import inspect
import re
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from os.path import relpath
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import pytest
from _pytest._code.code import TracebackEntry
from _pytest.runner import runtestprotocol

from sim.errors import USER_ERRORS, EstimateError
from sim.harness.last_run import LastRun, watched
from sim.harness.world_tests import World
from sim.pytest_plugin.collection import is_without_worlds
from sim.pytest_plugin.drawn_tests import replay_of_draws
from sim.pytest_plugin.options import replayed_file

if TYPE_CHECKING:
    from sim.harness.failures.search import Reference
    from sim.harness.finished_run import Run
    from sim.harness.results import RunResult
    from sim.harness.scenario import Scenario


_FIGURE = re.compile(r"\b((?:labels|rooms|floors|loops|trajectory|coverage|planning)\.\w+|place_recognition\b)")
"""The dotted name of a figure in a statement, whatever name the result has in the test. A figure of place recognition has a
key, so that only the name before it is found."""


@dataclass(frozen=True, eq=False)
class Raised:
    """An exception that the SLAM has raised in the fixture `run`."""

    error: BaseException
    traceback: TracebackType | None
    """The traceback from the fixture to the line that raised the exception."""


@dataclass(frozen=True)
class Reason:
    """Why a test failed: an exception that the test's body or the SLAM has raised."""

    kind: str
    file: str
    """Path of the file with the line that raised the exception."""
    line: int
    where: str
    """The same file and line as text, with the path relative to the folder in which pytest was started."""
    statement: str
    message: str
    error: BaseException

    @property
    def figure(self) -> str | None:
        """The figure in the failing statement, such as "floors.accuracy" in "assert run.floors.accuracy > 0.9", or None."""
        found = _FIGURE.search(self.statement)
        return found and found[1]

    @property
    def unknown_figure(self) -> str:
        """Sentence on a figure that the test misspells: no `RunResult` has it; empty for any other failure."""
        error = self.error
        if not isinstance(error, AttributeError) or type(error.obj).__module__ != "sim.harness.results":
            return ""
        from sim.harness.results import figure_meant

        name, valid = error.name or "", list(vars(error.obj))
        return f"no figure {name!r}{figure_meant(type(error.obj), name)}; valid: {', '.join(valid)}"

    @property
    def uses_none(self) -> bool:
        """Whether the test compares or computes with None."""
        return isinstance(self.error, TypeError) and "NoneType" in str(self.error)

    @property
    def lacks_figure(self) -> bool:
        """Whether the test needs a figure that is misspelt or None, which no smaller scenario can change."""
        return bool(self.unknown_figure) or (self.figure is not None and self.uses_none)

    @property
    def text(self) -> str:
        """The message, and the line that raised the exception."""
        return f"{self.message}\n{self.where}: {self.statement}"


@dataclass(eq=False)
class Execution:
    """One execution of a test, with all results so far."""

    world: World | None = None
    """The world in which a decorated test runs; None for other tests."""
    scenario: "Scenario | None" = None
    """The scenario of a decorated test; None until it is built."""
    given: "RunResult | None" = None
    """What the fixture `run` returns without running the SLAM; None: the result of the SLAM."""
    by_reference: bool = False
    """Whether the fixture `run` runs the SLAM of the fixture `reference_slam` in place of `slam`."""
    reference: "Reference | None" = None
    """The SLAM of the fixture `reference_slam`, in the same scenario; None if it was not run."""
    last: LastRun = field(default_factory=LastRun)
    raised: Raised | None = None
    failure: Reason | None = None
    """Why the test failed; None if it passed."""

    @property
    def tested(self) -> "Scenario | None":
        """The scenario in which the test was executed.

        A test without the decorator `worlds` may start several runs. The result is then the scenario of the last run, or
        None if the SLAM was not started in that run.
        """
        if self.world is not None:
            return self.scenario
        return None if self.last.done is None else self.last.scenario

    @property
    def run(self) -> "Run | None":
        """The completed run of the scenario `tested`; None if there is none."""
        run = self.last.run
        return run if run is not None and run.scenario == self.tested else None

    @property
    def crashed_at(self) -> float | None:
        """Share of the frames that the SLAM had processed when it raised an exception, in [0, 1]; None if it raised none."""
        return self.last.done if self.last.in_slam and self.last.scenario == self.tested else None

    @property
    def first_wrong(self) -> str:
        """Room, time and kind of the first error that affects the figure of the failure, as text; "" if it is not known."""
        from sim.harness.diagnosis.first_wrong import crash_frame, first_wrong
        from sim.harness.scenario_sessions import picture_session

        if self.run is not None:
            reference = None if self.reference is None else self.reference.run
            return str(first_wrong(self.run, self.failure.figure if self.failure else None, reference) or "")
        if self.tested is None or self.crashed_at is None:
            return ""
        return str(crash_frame(picture_session(self.tested), self.crashed_at))


EXECUTION = pytest.StashKey[Execution]()
"""Key under which pytest stores the current execution of a test."""


def execute(
    item: pytest.Item,
    nextitem: pytest.Item | None,
    world: World,
    given: "RunResult | None" = None,
    by_reference: bool = False,
) -> tuple[list[pytest.TestReport], Execution]:
    """Set up, run and tear down a decorated test in one world; return pytest's reports and the record of the execution.

    With `given`, the SLAM is not run, and this is its result. With `by_reference`, the SLAM of the fixture `reference_slam`
    is run instead.
    """
    item._report_sections.clear()  # otherwise the printed output of all executions adds up
    execution = item.stash[EXECUTION] = Execution(world, given=given, by_reference=by_reference)
    try:
        return runtestprotocol(item, log=False, nextitem=nextitem), execution
    except KeyboardInterrupt:  # pytest stops here and would leave the fixtures set up
        item.session._setupstate.teardown_exact(nextitem)
        raise
    finally:
        del item.stash[EXECUTION]


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, None, None]:
    """Record the runs that fixtures start.

    If the SLAM raises an exception in the fixture `run`, the exception is stored, and `pytest_runtest_call` raises it.
    pytest then reports a failure of the test, not an error of its setup.
    """
    if is_without_worlds(item):
        problem = "is decorated with @worlds in a TestCase of unittest; valid: a function, or a method of any other class"
        pytest.fail(f"{item.nodeid} {problem}", pytrace=False)
    if EXECUTION not in item.stash:
        item.stash[EXECUTION] = Execution()
    execution = item.stash[EXECUTION]
    replayed = replayed_file(item.config)
    if execution.world is None and replayed is not None:
        execution.last.instead = _scenario_in(replayed)
    with watched(execution.last):
        try:
            yield
        except USER_ERRORS as error:
            if execution.raised is None or execution.raised.error is not error:
                raise


def _scenario_in(file: Path) -> "Scenario":
    from sim.harness.scenario import Scenario

    return Scenario.load(file)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """Record the runs that a test starts.

    If the SLAM raised an exception in the fixture `run`, this exception is raised, and the test's body is skipped.
    """
    __tracebackhide__ = True
    execution = item.stash[EXECUTION]
    if execution.raised is not None:
        raise execution.raised.error.with_traceback(execution.raised.traceback)
    with watched(execution.last), replay_of_draws(item, execution.last.instead):
        yield


def reason_of(item: pytest.Item, error: pytest.ExceptionInfo[BaseException], slam: object) -> Reason:
    """Describe a failure by its exception and by the last line of the user's own code in the traceback.

    If the harness refuses the estimate of `slam`, no such line is in the traceback; the line is then that of `finish`, which
    returned the estimate.
    """
    own = [entry for entry in error.traceback if _is_own(Path(entry.path), item.config.rootpath)]
    entry = own[-1] if own else error.traceback[-1]
    file, line, statement = str(entry.path), entry.lineno + 1, _statement(entry)
    if not own and isinstance(error.value, EstimateError) and (finish := getattr(type(slam), "finish", None)) is not None:
        file, line, statement = _definition(finish) or (file, line, statement)
    where = f"{relpath(file, item.config.invocation_params.dir)}:{line}"
    lines = error.exconly(tryshort=True).splitlines()
    said = next((k for k, text in enumerate(lines) if text.lstrip().startswith("+")), len(lines))
    return Reason(error.typename, file, line, where, " ".join(statement.split()), "\n".join(lines[:said]), error.value)


def _statement(entry: TracebackEntry) -> str:
    """Return the text of a line in a traceback; "" if it has no source, or none in Python."""
    try:
        return str(entry.statement)
    except (AssertionError, SyntaxError, OSError, IndexError):
        return ""


def _definition(method: Callable[..., object]) -> tuple[str, int, str] | None:
    """Return file, line and text of the line that begins the definition of a method; None without source code."""
    try:
        file, (lines, first) = inspect.getsourcefile(method), inspect.getsourcelines(method)
    except (OSError, TypeError):
        return None
    found = next((k for k, text in enumerate(lines) if text.lstrip().startswith("def ")), 0)  # decorators come before
    return (file, first + found, lines[found]) if file else None


def _is_own(path: Path, project: Path) -> bool:
    return path.is_relative_to(project) and "site-packages" not in path.parts
