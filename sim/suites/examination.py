"""Runs the scenarios of a suite, in several processes, and collects what the checks find."""

import math
import os
import pickle
import time
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain, zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from lexis.errors import one_line
from sim.errors import SimError
from sim.harness.results import RunResult
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.number_checks import check_count
from sim.processes import process_pool
from sim.suites.checks import Check, CheckFinding, NewSlam, examined
from sim.suites.suite import Suite, SuitePart
from worlds.errors import WorldsError

COMPLETES = "the run completes"
"""Name of the check that every part has besides its own: the SLAM raises no exception, and its claims are valid."""
DIED = "a process died while it ran the SLAM on"
"""Part of the message of the error for a SLAM that aborts its process."""
_DRAWS = 20
"""Largest number of draws for one scenario; a draw is unlucky if its house or its walk is impossible."""


@dataclass(frozen=True)
class Job:
    """One scenario of a suite."""

    part: SuitePart
    number: int
    """Number of the scenario in its part, counted from 0."""
    seed: int
    """Seed of the whole suite."""
    is_bare: bool = False
    """Whether the SLAM is run without checks, for its figures alone."""


@dataclass(frozen=True, eq=False)
class Examination:
    """What all checks of a part found in one scenario."""

    part: str
    number: int
    scenario: Scenario
    result: RunResult | None
    """Figures of the unchanged run; None if this run did not complete."""
    findings: Mapping[str, CheckFinding]
    """The findings by the name of the check."""


def jobs_of(suite: Suite, seed: int) -> list[Job]:
    """Return all scenarios of a suite. The parts take turns, so that an early failure in any part shows early.

    Raises `SimError` for a seed that is negative or no whole number.
    """
    check_count("suite: seed", seed, 0)
    rows = ([Job(part, number, seed) for number in range(part.n)] for part in suite.parts)
    return [job for job in chain.from_iterable(zip_longest(*rows)) if job is not None]


def scenario_of(job: Job) -> Scenario:
    """Draw the scenario of a job. Raises `SimError` if all draws are unlucky."""
    place = job.number % job.part.group
    return _drawn_group(job.part, job.number - place, job.seed)[place]


@lru_cache(maxsize=64)
def _drawn_group(part: SuitePart, first: int, seed: int) -> tuple[Scenario, ...]:
    """Draw the scenarios of the group that begins with number `first`.

    If the draw is unlucky for one scenario, the whole group is drawn again.
    """
    for attempt in range(_DRAWS):
        try:
            group = []
            for number in range(first, first + part.group):
                rng = np.random.default_rng([seed, attempt, first, *part.name.encode()])
                group.append(part.scenario(rng, number))
                walk(group[-1])
            return tuple(group)
        except (WorldsError, SimError) as error:
            last = error
    raise SimError(f"suite: part {part.name} has no possible scenarios from number {first}: {last}")


def examine(job: Job, new_slam: NewSlam) -> Examination:
    """Run a SLAM on one scenario and evaluate all checks. Raises `SimError` if no scenario can be drawn."""
    scenario = scenario_of(job)
    base = examined(scenario, new_slam)
    if isinstance(base, CheckFinding):
        return Examination(job.part.name, job.number, scenario, None, {COMPLETES: base})
    checks = () if job.is_bare else job.part.checks
    findings = {COMPLETES: CheckFinding(True, "")} | {check.name: check.examine(base, new_slam) for check in checks}
    return Examination(job.part.name, job.number, scenario, base.result, findings)


def finding(check: Check | None, scenario: Scenario, new_slam: NewSlam) -> CheckFinding:
    """Run a SLAM on a scenario and evaluate one check; None stands for the check that the run completes.

    Raises `SimError` for an impossible scenario.
    """
    base = examined(scenario, new_slam)
    if isinstance(base, CheckFinding):
        return base if check is None else CheckFinding(None, base.measured)
    return CheckFinding(True, "") if check is None else check.examine(base, new_slam)


def examinations(
    jobs: Sequence[Job], new_slam: NewSlam, workers: int, end: float = math.inf
) -> Generator[Examination, None, None]:
    """Examine scenarios in several processes; yield the results in the order of the jobs.

    When `time.monotonic()` reaches `end` [s], no further scenario is begun; the first one is examined in any case.
    `new_slam` has to be picklable if there are several workers. A consumer that stops early has to close the iterator.
    Raises `SimError` for fewer than one worker, for objects that cannot be sent to other processes, and if a process dies.
    """
    check_count("suite: workers", workers, 1)
    if workers == 1 or len(jobs) == 1:
        yield from (examine(job, new_slam) for job in jobs if job is jobs[0] or time.monotonic() < end)
        return
    for what, thing in (("SLAM", new_slam), *(("suite", part) for part in dict.fromkeys(job.part for job in jobs))):
        _check_picklable(what, thing)
    with TemporaryDirectory() as folder:
        notes = Path(folder)
        pool = process_pool(workers)
        try:
            ends = [math.inf if job is jobs[0] else end for job in jobs]
            found = pool.map(_noted, jobs, [new_slam] * len(jobs), [notes] * len(jobs), ends)
            yield from (each for each in found if each is not None)
        except BrokenProcessPool:
            during = ", or ".join(sorted(note.read_text() for note in notes.iterdir()))
            if not during:
                raise SimError(
                    "suite: a process died before it began a scenario; valid: in a script, a call of check_slam below "
                    "'if __name__ == \"__main__\":', or one process (workers=1)"
                ) from None
            valid = "valid: a SLAM that does not abort; with one process (workers=1), its own messages tell where it does"
            raise SimError(f"suite: {DIED} {during}; {valid}") from None
        finally:
            pool.shutdown(cancel_futures=True)


def _noted(job: Job, new_slam: NewSlam, notes: Path, end: float) -> Examination | None:
    """Examine a scenario unless the time is over.

    Meanwhile, a file names the scenario, so that the scenario is known if the process dies.
    """
    if time.monotonic() >= end:
        return None
    note = notes / str(os.getpid())
    note.write_text(f"scenario {job.number} of part {job.part.name}, seed {job.seed}")
    found = examine(job, new_slam)
    note.unlink()
    return found


def _check_picklable(what: str, thing: object) -> None:
    """Raise SimError for an object that cannot be sent to other processes.

    Without this check, the pool of processes might wait for ever.
    """
    try:
        pickle.dumps(thing)
    except Exception as error:  # whatever a user's object raises
        reason = one_line(f"{type(error).__name__}: {error}", 160)
        raise SimError(
            f"the {what} cannot be sent to other processes: {reason}; valid: classes and functions at the top of a module, "
            "or one process (workers=1)"
        ) from None
