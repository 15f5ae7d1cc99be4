"""Runs the scenarios of a suite, in several processes, and collects what the checks find."""

import multiprocessing
import pickle
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import chain, zip_longest

import numpy as np

from lexis.errors import LexisError, one_line
from sim.errors import SimError
from sim.harness.crash import Crash, attempt
from sim.harness.figures import evaluate
from sim.harness.planning import try_plans
from sim.harness.results import RunResult
from sim.harness.runner import run
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.suites.checks import Check, CheckFinding, Examined, NewSlam
from sim.suites.suite import Suite, SuitePart
from worlds.errors import WorldsError

COMPLETES = "the run completes"
"""Name of the check that every part has besides its own: the SLAM raises no exception, and its claims are valid."""
_DRAWS = 20
"""Largest number of draws for one scenario; a draw is unlucky if its house or its walk is impossible."""


@dataclass(frozen=True)
class Job:
    """One scenario of a suite, to be examined by all checks of its part, or by one."""

    part: SuitePart
    number: int
    """Number of the scenario in its part, counted from 0."""
    seed: int
    """Seed of the whole suite."""
    only: str | None = None
    """Name of the one check to examine; None: all checks of the part."""


@dataclass(frozen=True, eq=False)
class Examination:
    """What all checks of a part found in one scenario."""

    part: str
    number: int
    scenario: Scenario
    result: RunResult | None
    """Figures of the unchanged run; None if it did not complete."""
    findings: Mapping[str, CheckFinding]
    """The findings by the name of the check."""


def jobs_of(suite: Suite, seed: int) -> list[Job]:
    """Return all scenarios of a suite; the parts take turns, so that each of them shows an early failure early."""
    rows = ([Job(part, number, seed) for number in range(part.n)] for part in suite.parts)
    return [job for job in chain.from_iterable(zip_longest(*rows)) if job is not None]


def scenario_of(job: Job) -> Scenario:
    """Draw the scenario of a job, again if a draw is unlucky. Raises `SimError` if all draws are."""
    rng = np.random.default_rng([job.seed, job.number // job.part.group, *job.part.name.encode()])
    for _ in range(_DRAWS):
        try:
            scenario = job.part.draw(rng, job.number)
            walk(scenario)
            return scenario
        except (WorldsError, SimError) as error:
            last = error
    raise SimError(f"suite: part {job.part.name} has no possible scenario number {job.number}: {last}")


def examine(job: Job, new_slam: NewSlam) -> Examination:
    """Run a SLAM on one scenario and make all checks. Raises `SimError` if no scenario can be drawn."""
    scenario = scenario_of(job)
    base = _examined(scenario, new_slam)
    if isinstance(base, CheckFinding):
        return Examination(job.part.name, job.number, scenario, None, {COMPLETES: base})
    findings = {COMPLETES: CheckFinding(True, "")}
    for check in job.part.checks:
        if job.only in (None, check.name):
            findings[check.name] = _found(check, base, new_slam)
    return Examination(job.part.name, job.number, scenario, base.result, findings)


def finding(check: Check | None, scenario: Scenario, new_slam: NewSlam) -> CheckFinding:
    """Run a SLAM on a scenario and make one check; None stands for the check that the run completes."""
    base = _examined(scenario, new_slam)
    if isinstance(base, CheckFinding):
        return base if check is None else CheckFinding(None, base.measured)
    return CheckFinding(True, "") if check is None else _found(check, base, new_slam)


def examinations(jobs: Sequence[Job], new_slam: NewSlam, workers: int) -> Generator[Examination, None, None]:
    """Examine scenarios in several processes; yield the results in the order of the jobs.

    `new_slam` has to be picklable if there are several workers. A consumer that stops early has to close the iterator.
    """
    if workers == 1 or len(jobs) == 1:
        yield from (examine(job, new_slam) for job in jobs)
        return
    _check_picklable(jobs[0], new_slam)
    context = multiprocessing.get_context("spawn")  # a forked torch or OpenCV may hang
    pool = ProcessPoolExecutor(workers, context)
    try:
        yield from pool.map(examine, jobs, [new_slam] * len(jobs))
    finally:
        pool.shutdown(cancel_futures=True)


def _check_picklable(job: Job, new_slam: NewSlam) -> None:
    """Raise SimError for objects that cannot be sent to other processes; the process pool might wait for ever with them."""
    for what, thing in (("SLAM", new_slam), ("suite", job.part)):
        try:
            pickle.dumps(thing)
        except Exception as error:  # whatever a user's object raises
            reason = one_line(f"{type(error).__name__}: {error}", 160)
            raise SimError(
                f"the {what} cannot be sent to other processes: {reason}; valid: classes and functions at the top of a "
                "module, or one process (workers=1)"
            ) from None


def _examined(scenario: Scenario, new_slam: NewSlam) -> Examined | CheckFinding:
    """Run the SLAM; return a finding that fails if the SLAM raised an exception or made claims that are not valid."""
    try:
        finished = attempt(lambda same, progress: run(same, new_slam(), progress), scenario)
        if isinstance(finished, Crash):
            return CheckFinding(False, f"the SLAM {finished.what}: {finished.message}")
        trials = try_plans(finished) if scenario.fidelity == "render" else ()
        return Examined(finished, evaluate(finished, trials))
    except (SimError, LexisError) as error:
        return CheckFinding(False, one_line(error, 160))


def _found(check: Check, base: Examined, new_slam: NewSlam) -> CheckFinding:
    try:
        return check.examine(base, new_slam)
    except Exception as error:  # a SLAM may raise anything on the changed input
        return CheckFinding(False, one_line(f"the changed run raises {type(error).__name__}: {error}", 160))
