"""Tells the pytest plugin about runs that a test starts by itself: `sim.harness.run` stores the latest run here.

pytest loads this module at every start, so it loads nothing heavy.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sim.wording import qualified_name

if TYPE_CHECKING:
    from sim.harness.finished_run import Run
    from sim.harness.results import RunResult
    from sim.harness.scenario import Scenario
    from sim.harness.trial import Trial


@dataclass(eq=False)
class LastRun:
    """The run that began last, with all results so far."""

    instead: "Scenario | None" = None
    """The scenario that is run in place of every other, for replays; None: every run gets its own scenario."""
    scenario: "Scenario | None" = None
    """The scenario of the last run; None if no run has begun."""
    slam: object = None
    """The SLAM of the last run; None if no run has begun, and while a program is run instead of a SLAM."""
    command: str = ""
    """The command of the program that is run instead of a SLAM; "" without one."""
    done: float | None = None
    """Share of the walk before the frame that the SLAM processes or has processed last, in [0, 1]; None until the SLAM is
    started."""
    started: bool = False
    """Whether the SLAM of the last run has been started, so that it gets observations."""
    in_slam: bool = False
    """Whether a method of the SLAM was called and has not returned, so that an exception is the SLAM's."""
    run: "Run | None" = None
    """The last run; None if it was not completed."""
    result: "RunResult | None" = None
    """The figures of `run`, if they were computed."""
    trials: "Sequence[Trial]" = ()
    """The plans on the map of `run` that the simulated robot has driven; they are part of the figures."""

    def begin(self, scenario: "Scenario") -> "Scenario":
        """Record that a run begins, and forget the previous run.

        Returns the scenario to run: `instead` if it is set, otherwise `scenario`.
        """
        self.forget()
        self.scenario = self.instead or scenario
        return self.scenario

    def forget(self) -> None:
        """Forget the previous run, whose SLAM must not be blamed for what happens before the next run begins."""
        self.scenario, self.slam, self.command, self.done = None, None, "", None
        self.started, self.in_slam = False, False
        self.run, self.result, self.trials = None, None, ()

    @property
    def slam_name(self) -> str:
        """Module and class of the SLAM, or the command of a program; "" without either."""
        return self.command if self.slam is None else qualified_name(self.slam)

    def evaluated(self, run: "Run", result: "RunResult", trials: "Sequence[Trial]") -> None:
        """Record the figures of a run, unless another run has begun since."""
        if run is self.run:
            self.result, self.trials = result, trials

    @contextmanager
    def calling_slam(self, *allowed: type[Exception]) -> Iterator[None]:
        """Set `in_slam` while the block calls a method of the SLAM.

        After an exception, `in_slam` stays true, unless the method may raise exceptions of this type: `allowed`.
        """
        self.in_slam = True
        try:
            yield
        except allowed:
            self.in_slam = False
            raise
        self.in_slam = False


_WATCHED: ContextVar[LastRun | None] = ContextVar("lexis_last_run", default=None)


@contextmanager
def watched(last: LastRun) -> Iterator[None]:
    """While the block runs, record in `last` the runs that this thread begins."""
    token = _WATCHED.set(last)
    try:
        yield
    finally:
        _WATCHED.reset(token)


@contextmanager
def noted() -> Iterator[LastRun]:
    """Record the runs that begin in the block, and yield the record.

    Inside a block of `watched`, the record is that block's; elsewhere it is a new record.
    """
    last = _WATCHED.get() or LastRun()
    with watched(last):
        yield last


def last_run() -> LastRun:
    """Return the record of a surrounding `watched`; outside of such a block, a new record that nobody reads."""
    return _WATCHED.get() or LastRun()
