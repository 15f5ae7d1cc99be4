"""`attempt`: run a SLAM on a scenario, and get either the finished run or the `Crash` that has ended it."""

import traceback
from collections.abc import Callable
from dataclasses import dataclass

from lexis.errors import LexisError, ObservationError, one_line
from sim.errors import ProgramError, SimError
from sim.harness.last_run import noted
from sim.harness.runner import Progress, Run
from sim.harness.scenario import Scenario
from worlds.errors import WorldsError

Runner = Callable[[Scenario, Progress | None], Run]
"""Runs the SLAM under test on a scenario. Each run needs a SLAM object of its own, because runs are kept."""
TRACEBACK = "traceback.txt"
"""File that identifies the folder of a crash, which a new result may replace."""
_MESSAGE = 160
"""Largest length of an exception in one line, in characters."""


@dataclass(frozen=True, eq=False)
class Crash:
    """A run that was not completed, because the SLAM raised an exception or the program under test failed."""

    scenario: Scenario
    error: BaseException
    done: float | None
    """Share of the frames that the SLAM had processed, in [0, 1]; None if the SLAM was not started."""

    @property
    def has_place(self) -> bool:
        """Whether the frame is known at which it happened. Programs are given all frames at once."""
        return self.done is not None and not isinstance(self.error, ProgramError)

    @property
    def what(self) -> str:
        """What the SLAM did, in a few words: "raises RuntimeError" or "ends with exit status 3"."""
        return self.error.how if isinstance(self.error, ProgramError) else f"raises {type(self.error).__name__}"

    @property
    def message(self) -> str:
        """The exception in one line, such as "RuntimeError: lost"."""
        return one_line(f"{type(self.error).__name__}: {self.error}", _MESSAGE)

    @property
    def traceback(self) -> str:
        """The traceback of the exception, as Python prints it; for a program, what it printed on stderr."""
        if isinstance(self.error, ProgramError):
            return self.error.stderr
        return "".join(traceback.format_exception(self.error))


def attempt(runner: Runner, scenario: Scenario, progress: Progress | None = None) -> Run | Crash:
    """Run a SLAM; return the run, or the crash by which the SLAM has ended it.

    Raises `SimError`, `WorldsError` or `LexisError` if the scenario cannot be run or the claims of the SLAM are not valid.
    """
    with noted() as last:
        try:
            return runner(scenario, progress)
        except (ProgramError, ObservationError) as error:  # without faults, a SLAM must not refuse an observation
            return Crash(scenario, error, last.done)
        except (SimError, WorldsError, LexisError):
            raise
        except Exception as error:  # whatever a SLAM raises
            return Crash(scenario, error, last.done)
