"""`attempt`: runs a SLAM on a scenario, and returns the finished run or, if the SLAM crashed, a `Crash`."""

import os
import traceback
from collections.abc import Callable, Sequence
from contextlib import chdir
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

import lexis
import sim
import worlds
from lexis.errors import EncoderError, LexisError, encodable, one_line
from sim.errors import USER_ERRORS, EstimateError, ProgramError, SimError
from sim.harness.finished_run import Run
from sim.harness.last_run import noted
from sim.harness.planning import try_plans
from sim.harness.runner import Progress
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import full_name_of
from sim.harness.trial import Trial
from sim.wording import error_text

Runner = Callable[[Scenario, Progress | None], Run]
"""A function that runs the SLAM under test on a scenario. Every call has to create a new SLAM object, because a finished run
keeps its SLAM."""
COMPLETES = "the run completes"
"""Name of a check that every run has to pass: the SLAM raises no exception, and its estimates are valid."""
TRACEBACK = "failure-traceback.txt"
"""Name of the file with the traceback. A folder with this file is the output of a crash, which a new result may replace."""
_Result = TypeVar("_Result")
_NOT_OWN = tuple(
    f"{Path(package.__file__).parent}{os.sep}" for package in (lexis, sim, worlds, traceback) if package.__file__
)
"""Folders whose code is not the user's: the packages of the project, and Python's library with all installed packages."""
_INSTALLED = "site-packages"
_MESSAGE = 160
"""Largest length of an exception's one-line message, in characters."""


@dataclass(frozen=True, eq=False)
class Crash:
    """An exception of the SLAM or of a test, or a failure of the program under test, that ended the run or the test."""

    scenario: Scenario
    error: BaseException
    done: float | None
    """Share of the frames that the SLAM had processed, in [0, 1]; None if the frame is unknown, as with programs."""
    slam: str = ""
    """Module and class of the SLAM, or the command of a program; "" if it is not known."""

    @property
    def what(self) -> str:
        """What the SLAM did, in a few words: "raises RuntimeError" or "ends with exit status 3"."""
        return self.error.how if isinstance(self.error, ProgramError) else f"raises {type(self.error).__name__}"

    @property
    def message(self) -> str:
        """The exception in one line, such as "RuntimeError: lost"."""
        return one_line(error_text(self.error), _MESSAGE)

    @property
    def sentence(self) -> str:
        """What went wrong: "the SLAM raises RuntimeError: lost", or what the error says about a program."""
        if isinstance(self.error, ProgramError):
            return encodable(str(self.error))
        return encodable(f"the SLAM raises {error_text(self.error)}")

    @property
    def place(self) -> str:
        """See `place_in_own_code`."""
        return place_in_own_code(self.error)

    @property
    def traceback(self) -> str:
        """The traceback as Python prints it, or what a program printed on stderr; empty if a program printed nothing."""
        if isinstance(self.error, ProgramError):
            told = self.error.stderr.decode(errors="replace").rstrip()
            return f"{told}\n" if told else ""
        return encodable("".join(traceback.format_exception(self.error)))


def place_in_own_code(error: BaseException) -> str:
    """Return the innermost line of the user's own code, such as ", in my_slam.py:12"; "" if there is none."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [each for each in frames if not each.filename.startswith((*_NOT_OWN, "<")) and _INSTALLED not in each.filename]
    return f", in {Path(own[-1].filename).name}:{own[-1].lineno}" if own else ""


def attempt(runner: Runner, scenario: Scenario, progress: Progress | None = None) -> Run | Crash:
    """Run a SLAM; return the finished run, or the crash of the SLAM or of the program under test.

    A crash is an exception in a method of the SLAM, or a failure of the program. Exceptions from outside the SLAM's methods
    are passed on. So is `EstimateError`: the estimate of the SLAM is not valid. Until the SLAM has been started, so are
    `SimError` and `EncoderError`: a setting is not valid, or a model cannot be loaded.
    """
    with noted() as last, chdir("."):  # a SLAM may change the working directory
        last.forget()
        try:
            return runner(scenario, progress)
        except EstimateError:
            raise
        except ProgramError as error:
            return Crash(scenario, error, None, last.slam_name)
        except USER_ERRORS as error:
            cannot_start = isinstance(error, (SimError, EncoderError)) and not last.started
            if cannot_start or not last.in_slam:
                raise
            return Crash(scenario, error, last.done, last.slam_name)


def attempt_plans(finished: Run) -> Sequence[Trial] | Crash:
    """Let a robot drive the SLAM's plans; return the driven plans, or the crash if the SLAM's `plan` raised an exception.

    Exceptions from outside `plan` are passed on. Raises `EstimateError` for a plan that is not valid.
    """
    return _attempted(finished, partial(try_plans, finished), EstimateError)


def attempt_write(finished: Run, write: Callable[[], None]) -> Crash | None:
    """Call `write`, which writes the files of a finished run; return the crash if the SLAM's `save` raised an exception.

    Exceptions from outside `save` are passed on, and so are `SimError` and `LexisError`: the files cannot be written.
    """
    return _attempted(finished, write, SimError, LexisError)


def _attempted(finished: Run, act: Callable[[], _Result], *passed_on: type[Exception]) -> _Result | Crash:
    """Return what `act` returns, or the crash if a method of the SLAM of a finished run raised an exception in it.

    Exceptions of the types `passed_on`, and those from outside the SLAM's methods, are passed on.
    """
    with noted() as last, chdir("."):
        last.in_slam = False
        try:
            return act()
        except passed_on:
            raise
        except USER_ERRORS as error:
            if not last.in_slam:
                raise
            return Crash(finished.scenario, error, None, full_name_of(finished.slam))
