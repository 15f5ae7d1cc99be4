"""`lexis-sim bench throughput`: houses per second in tests that do not render, with all processor cores at work.

Every worker process handles houses of its own, as the workers of a parallel pytest do. Work that a process does only once,
such as importing libraries and loading the encoder, is done before the clock starts.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from sim.harness.figures import evaluate
from sim.harness.runner import run
from sim.harness.scenario import Scenario
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ
from sim.processes import process_pool, usable_cores
from worlds.presets import sample_house
from worlds.spec import HouseSpec
from worlds.validation import built_and_checked

_ROOMS, _LENGTH_M = 7, 170.0
"""Number of rooms, to which corridors, halls and stairs are added. Length of the tour [m]; LEXIS makes about 250 keyframes
on it."""
_WARM_UP_SEED = 1


@dataclass(frozen=True)
class Handled:
    """A house that a worker process has tested: the time, the number of rooms, and the number of frames."""

    seconds: float
    """Wall time for the house [s]."""
    processor_s: float
    """Processor time for the house [s], which depends less than the wall time on what else the machine does."""
    rooms: int
    frames: int
    """Number of frames in the SLAM's estimate, which are the keyframes in the case of LEXIS; 0 if no SLAM ran."""


@dataclass(frozen=True)
class Throughput:
    """The speed of tests of one kind ("layout" or "features"), in houses per second."""

    tier: str
    wanted: float
    """Required number of houses per second."""
    per_second: float
    """Measured number of houses per second, by all workers together."""
    handled: tuple[Handled, ...]


def measure_throughput(houses: int, seed: int) -> Iterator[Throughput]:
    """Measure the tests `layout` (without a SLAM) and `features` (with LEXIS) on homes with seeds from `seed` upwards.

    There is one worker process for each processor core.
    """
    workers = usable_cores()
    for tier, wanted, handle in (("layout", 30.0, check_layout), ("features", 2.0, run_on_features)):
        yield _measured(tier, wanted, handle, range(seed, seed + houses), workers)


def check_layout(seed: int) -> Handled:
    """Draw a house, build it and check it, as the pytest fixture `house` does."""
    start = time.perf_counter(), time.process_time()
    house = built_and_checked(_house(seed))
    return Handled(*_since(*start), len(house.rooms), 0)


def run_on_features(seed: int) -> Handled:
    """Draw a house, let LEXIS map it on the feature sensor, and compute all figures except those of plans."""
    start = time.perf_counter(), time.process_time()
    scenario = Scenario(
        house=_house(seed), seed=seed, length_m=_LENGTH_M, frame_rate_hz=FEATURES_FRAME_RATE_HZ, fidelity="features"
    )
    finished = run(scenario)
    evaluate(finished, [])
    return Handled(*_since(*start), len(finished.house.rooms), len(finished.estimate.frames))


def _since(wall: float, processor: float) -> tuple[float, float]:
    return time.perf_counter() - wall, time.process_time() - processor


def _house(seed: int) -> HouseSpec:
    return sample_house("home", seed, rooms=_ROOMS)


def _measured(tier: str, wanted: float, handle: Callable[[int], Handled], seeds: range, workers: int) -> Throughput:
    with process_pool(workers, handle, (_WARM_UP_SEED,)) as pool:
        list(pool.map(time.sleep, [0.2] * 2 * workers))  # makes the pool start all of its workers
        start = time.perf_counter()
        handled = tuple(pool.map(handle, seeds))
        return Throughput(tier, wanted, len(seeds) / (time.perf_counter() - start), handled)
