"""Tests the reducer (`prove`): it reduces scenarios in which planted bugs show, and each reduction is checked by laws.

A reduction is a search for the smallest scenario that fails in the same way. `broken_laws` lists the laws.
"""

import runpy
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import repeat
from pathlib import Path

import numpy as np

from sim.bench.failing_scenarios import FAMILIES, Family, failing_scenario
from sim.bench.planted_bugs import MENDED
from sim.harness.failures.blame_table import BlameTable
from sim.harness.failures.failure_folder import Replay, write_failure
from sim.harness.scenario import Scenario
from sim.harness.shrinking.failure_test import FailureTest
from sim.harness.shrinking.reducer import is_valid, reduce
from sim.harness.shrinking.reduction import Reduction
from sim.harness.walk import walk
from sim.harness.world_tests import TEST_REPLAY
from sim.processes import process_pool

_PYTEST_FAILED = 1
"""Exit status with which pytest says that a test failed."""


@dataclass(frozen=True)
class ProofPlan:
    """What `prove` does: the seed of its scenarios, its limits, and the folder for files."""

    seed: int
    """Seed of the scenarios."""
    deadline_s: float
    """Largest time for the reduction of one scenario [s]."""
    most_rooms: int
    """Greatest number of rooms in a house, without corridors, halls and stairs."""
    out: Path
    """Folder for the failure folders of reductions. Only failure folders of reductions that break a law are kept."""
    own_pytest_every: int
    """How often pytest runs a test_replay.py in a process of its own: once in this many scenarios, or never if 0. In
    addition, every test_replay.py is called directly."""


@dataclass(frozen=True)
class ReductionProof:
    """Result of testing the reducer on one scenario: sizes before and after the reduction, the time, and broken laws."""

    number: int
    rooms: tuple[int, int]
    """Number of rooms before and after."""
    walk_m: tuple[float, float]
    """Lengths of the tours before and after [m]."""
    tried: int
    """Number of candidates (smaller scenarios) that were tried."""
    seconds: float
    """Wall time of the reduction [s]."""
    in_time: bool
    """Whether the search ended before the deadline."""
    broken: tuple[str, ...]
    """The laws that the reduction breaks, in words; see `broken_laws`."""

    @property
    def family(self) -> Family:
        """The family of the scenario: its bug and its failure.

        This is not a field, because a `Family` cannot be pickled, and proofs are pickled to pass them between processes.
        """
        return family_of(self.number)


def family_of(number: int) -> Family:
    """Return the family (planted bug and failure) of the scenario with the given number. The families take turns."""
    return FAMILIES[number % len(FAMILIES)]


def prove(plan: ProofPlan, scenarios: int, processes: int) -> Iterator[ReductionProof]:
    """Reduce scenarios 0, 1, ... in several processes and check the laws of `broken_laws`; yield the proofs in order.

    Raises `SimError` if no failing scenario is found for a family.
    """
    if processes == 1:
        yield from map(prove_one, range(scenarios), repeat(plan))
        return
    with process_pool(processes) as pool:
        try:
            yield from pool.map(prove_one, range(scenarios), repeat(plan))
        finally:
            pool.shutdown(cancel_futures=True)


def prove_one(number: int, plan: ProofPlan) -> ReductionProof:
    """Draw one scenario, reduce it, and check the laws of `broken_laws`.

    The failure folder is deleted if no law is broken.
    """
    family = family_of(number)
    scenario = failing_scenario(family, plan.seed, number, plan.most_rooms)
    test = family.test()
    start = time.perf_counter()
    reduction = reduce(scenario, test, plan.deadline_s)
    seconds = time.perf_counter() - start
    folder = folder_of(number, plan)
    own_pytest = plan.own_pytest_every > 0 and (number + 1) % plan.own_pytest_every == 0
    broken = tuple(broken_laws(reduction, test, family.bug, folder, own_pytest))
    if broken:
        plan.out.mkdir(parents=True, exist_ok=True)
        scenario.save(folder.with_suffix(".json"))
    elif folder.is_dir():
        shutil.rmtree(folder)
    before, after = reduction.sizes
    lengths = _length_m(reduction.original), _length_m(reduction.scenario)
    in_time = reduction.ended == "smallest"
    return ReductionProof(number, (before.rooms, after.rooms), lengths, reduction.tried, seconds, in_time, broken)


def folder_of(number: int, plan: ProofPlan) -> Path:
    """Return the path of the failure folder of a scenario.

    If the reduction breaks a law, the original scenario is saved beside the folder, in a file with the suffix .json.
    """
    return plan.out / f"{family_of(number).bug.replace(' ', '-')}-{number}"


def _length_m(scenario: Scenario) -> float:
    return float(walk(scenario).tour.length_m)


def broken_laws(reduction: Reduction, test: FailureTest, bug: str, folder: Path, own_pytest: bool) -> Iterator[str]:
    """Yield the laws that a reduction breaks, in words, and write its failure folder to `folder`.

    The laws: the smallest scenario is valid, fails with the signature of the original, and is no larger than the original.
    The test in the folder fails, but passes for a SLAM that has small errors instead of the bug. If `own_pytest`, the test
    also fails if pytest runs it in another process.
    """
    if not is_valid(reduction.scenario):
        yield "valid: the house of the smallest scenario breaks a rule"
        return
    before, after = reduction.sizes
    if after > before:
        yield f"no larger: {after} is larger than {before}"
    if (found := replace(test)(reduction.scenario)) != reduction.signature:  # a new test, without cached runs
        yield f"same signature: {found} instead of {reduction.signature}"
        return
    replay = Replay("from sim.bench.planted_bugs import BUGS, planted", f"planted(BUGS[{bug!r}])(scenario)")
    write_failure(folder, reduction, test, BlameTable(()), replay)
    yield from broken_replays(folder, bug, own_pytest)


def broken_replays(folder: Path, bug: str, own_pytest: bool) -> Iterator[str]:
    """Yield, in words, the laws that the test_replay.py of a failure folder breaks; see `broken_laws`."""
    replay = folder / TEST_REPLAY
    if not _fails(replay):
        yield "replays: test_replay.py passes, although the bug is there"
    mended = folder / "test_mended.py"
    mended.write_text(replay.read_text(encoding="utf-8").replace(repr(bug), repr(MENDED)), encoding="utf-8")
    if _fails(mended):
        yield "replays: test_replay.py fails without the bug"
    if own_pytest and (status := _pytest_status(replay)) != _PYTEST_FAILED:
        yield f"replays: pytest test_replay.py ends with status {status} instead of {_PYTEST_FAILED}"


def _fails(file: Path) -> bool:
    """Return whether the test in a file raises an exception when it is called in this process."""
    try:
        runpy.run_path(str(file))["test_replay"]()
    except Exception:
        return True
    return False


def _pytest_status(file: Path) -> int:
    return subprocess.run([sys.executable, "-m", "pytest", "-q", file.name], cwd=file.parent, capture_output=True).returncode


@dataclass(frozen=True)
class ReductionSummary:
    """Sizes and times of the reductions of one family. Each triple holds a median, a 90 % quantile and a largest value."""

    family: str
    scenarios: int
    in_time: int
    """How many searches ended before the deadline."""
    broken: int
    """How many reductions break a law."""
    least_rooms: int | None
    """Least number of rooms in which the family's planted bug can show; None in the summary of all families together."""
    rooms_before: float
    """Median number of rooms of the original scenarios."""
    rooms: tuple[float, float, float]
    walk_before_m: float
    """Median length of the original tours [m]."""
    walk_m: tuple[float, float, float]
    tried: tuple[float, float, float]
    seconds: tuple[float, float, float]


def summaries(proofs: Sequence[ReductionProof]) -> Iterator[ReductionSummary]:
    """Yield one summary for each family that occurs, and last one for all families together."""
    for family in FAMILIES:
        if members := [proof for proof in proofs if proof.family == family]:
            yield _summary(family.bug, family.rooms, members)
    yield _summary("all", None, proofs)


def _summary(name: str, least_rooms: int | None, proofs: Sequence[ReductionProof]) -> ReductionSummary:
    def spread(value: Callable[[ReductionProof], float]) -> tuple[float, float, float]:
        values = [float(value(proof)) for proof in proofs]
        most, worst = np.quantile(values, [0.9, 1.0], method="higher").tolist()
        return float(np.median(values)), most, worst

    return ReductionSummary(
        name,
        len(proofs),
        sum(proof.in_time for proof in proofs),
        sum(bool(proof.broken) for proof in proofs),
        least_rooms,
        spread(lambda proof: proof.rooms[0])[0],
        spread(lambda proof: proof.rooms[1]),
        spread(lambda proof: proof.walk_m[0])[0],
        spread(lambda proof: proof.walk_m[1]),
        spread(lambda proof: proof.tried),
        spread(lambda proof: proof.seconds),
    )
