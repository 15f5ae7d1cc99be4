"""Runs the scenarios of a suite, in several processes, and collects what the checks find."""

import math
import pickle
import time
from collections import deque
from collections.abc import Generator, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain, zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from lexis.errors import one_line
from sim.errors import SimError
from sim.fidelity import ORACLE
from sim.harness.crash import COMPLETES
from sim.harness.figures import EvaluatedRun
from sim.harness.last_run import LastRun, watched
from sim.harness.results import RunResult
from sim.harness.scenario import Scenario
from sim.harness.shrinking.reductions import with_features
from sim.harness.walk import walk
from sim.processes import process_pool
from sim.suites.checks import Check, CheckFinding, NewSlam, evaluated_run
from sim.suites.suite import Suite, SuitePart
from sim.wording import error_text
from worlds.errors import WorldsError

DIED = "the SLAM ends its process, as a fatal error of compiled code does"
"""What is found in a scenario in which the SLAM ends the worker process."""
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
    """Whether a SLAM that looks at no images is run for its figures alone: nothing is rendered, and nothing is checked."""


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
    """Return all scenarios of a suite. The parts take turns, so that an early failure in any part shows early."""
    rows = ([Job(part, number, seed) for number in range(part.n)] for part in suite.parts)
    return [job for job in chain.from_iterable(zip_longest(*rows)) if job is not None]


def drawn_scenario(job: Job) -> Scenario:
    """Draw the scenario of a job. Raises `SimError` if all draws are unlucky."""
    place = job.number % job.part.group
    drawn = _drawn_group(job.part, job.number - place, job.seed)[place]
    return replace(with_features(drawn), encoder=ORACLE, feature_model=None) if job.is_bare else drawn


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
    scenario = drawn_scenario(job)
    base = evaluated_run(scenario, new_slam)
    if isinstance(base, CheckFinding):
        return Examination(job.part.name, job.number, scenario, None, {COMPLETES: base})
    checks = () if job.is_bare else job.part.checks
    findings = {COMPLETES: CheckFinding(True, "")} | {check.name: check.examine(base, new_slam) for check in checks}
    return Examination(job.part.name, job.number, scenario, base.result, findings)


def finding(check: Check | None, scenario: Scenario, new_slam: NewSlam) -> CheckFinding:
    """Run a SLAM on a scenario and evaluate one check; None stands for the check that the run completes.

    Another check is not decided if the run does not complete. Raises `SimError` for an impossible scenario.
    """
    base = evaluated_run(scenario, new_slam)
    if isinstance(base, CheckFinding) and check is not None:
        return CheckFinding(None, base.measured)
    return _found(check, base, new_slam)


def replayed_finding(check: Check | None, scenario: Scenario, new_slam: NewSlam) -> CheckFinding:
    """Return the `finding` for the replay of a failure, in which a check also fails if the run does not complete.

    The pytest plugin does not see the runs. The last of them may be about a changed scenario, and the plugin would say where
    that run first went wrong.
    """
    with watched(LastRun()):
        return _found(check, evaluated_run(scenario, new_slam), new_slam)


def _found(check: Check | None, base: EvaluatedRun | CheckFinding, new_slam: NewSlam) -> CheckFinding:
    if isinstance(base, CheckFinding):
        return base
    return CheckFinding(True, "") if check is None else check.examine(base, new_slam)


def examinations(
    jobs: Sequence[Job], new_slam: NewSlam, workers: int, end: float = math.inf
) -> Generator[Examination, None, None]:
    """Examine scenarios in several processes; yield the results in the order of the jobs.

    When `time.monotonic()` reaches `end` [s], no further scenario is begun; the first one is examined in any case.
    `new_slam` has to be picklable if there are several workers. A consumer that stops early has to close the iterator.

    With several workers, a SLAM that ends its process fails the check that the run completes. Whenever a process ends, the
    scenarios that were being examined are lost. Each of them is examined again in a process of its own, which tells the one
    that ends it; new processes then go on with the other scenarios.

    Raises `SimError` for objects that cannot be sent to other processes, and if a process ends before it begins a scenario.
    """
    if workers == 1:
        yield from (examine(job, new_slam) for job in jobs if job is jobs[0] or time.monotonic() < end)
        return
    for what, thing in (("SLAM", new_slam), *(("suite", part) for part in dict.fromkeys(job.part for job in jobs))):
        _check_picklable(what, thing)
    again: dict[Job, Examination] = {}
    left = deque(jobs)
    while left:
        with TemporaryDirectory() as folder:
            others = [job for job in left if job not in again]
            notes = [Path(folder) / str(number) for number in range(len(others))]
            ends = [math.inf if job is jobs[0] else end for job in others]
            try:
                with closing(_in_processes(others, new_slam, workers, notes, ends)) as found:
                    yield from _in_order(left, again, found)
            except BrokenProcessPool:
                again |= {job: _examined_alone(job, new_slam) for job in _begun(others, notes)}


def _in_processes(
    jobs: Sequence[Job], new_slam: NewSlam, workers: int, notes: Sequence[Path], ends: Sequence[float]
) -> Generator[Examination | None, None, None]:
    """Examine scenarios in new processes as `_noted` does. Raises `BrokenProcessPool` if a process ends."""
    pool = process_pool(workers)
    try:
        yield from pool.map(_noted, jobs, [new_slam] * len(jobs), notes, ends)
    finally:
        pool.shutdown(cancel_futures=True)


def _in_order(
    left: "deque[Job]", known: Mapping[Job, Examination], found: Iterator[Examination | None]
) -> Generator[Examination, None, None]:
    """Yield the results of the jobs that are left, known or found, and remove each of these jobs from `left`."""
    while left:
        each = known.get(left[0]) or next(found)
        left.popleft()
        if each is not None:
            yield each


def _noted(job: Job, new_slam: NewSlam, note: Path, end: float) -> Examination | None:
    """Examine a scenario unless the time is over. Meanwhile, the file `note` exists; it stays if the process ends."""
    if time.monotonic() >= end:
        return None
    note.touch()
    found = examine(job, new_slam)
    note.unlink()
    return found


def _begun(jobs: Sequence[Job], notes: Sequence[Path]) -> list[Job]:
    """Return the jobs whose notes exist. Raises `SimError` if there is none."""
    if begun := [job for job, note in zip(jobs, notes, strict=True) if note.exists()]:
        return begun
    raise SimError(
        "suite: a process died before it began a scenario; valid: in a script, a call of check_slam below "
        "'if __name__ == \"__main__\":', or one process (workers=1)"
    )


def _examined_alone(job: Job, new_slam: NewSlam) -> Examination:
    """Examine a scenario in a process of its own; if this process ends, the check that the run completes fails."""
    with process_pool(1) as pool:
        try:
            return pool.submit(examine, job, new_slam).result()
        except BrokenProcessPool:
            return Examination(job.part.name, job.number, drawn_scenario(job), None, {COMPLETES: CheckFinding(False, DIED)})


def _check_picklable(what: str, thing: object) -> None:
    """Raise SimError for an object that cannot be sent to other processes.

    Without this check, the pool of processes might wait for ever.
    """
    try:
        pickle.dumps(thing)
    except Exception as error:  # whatever a user's object raises
        reason = one_line(error_text(error), 160)
        raise SimError(
            f"the {what} cannot be sent to other processes: {reason}; valid: classes and functions at the top of a module, "
            "or one process (workers=1)"
        ) from None
