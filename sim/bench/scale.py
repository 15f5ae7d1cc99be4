"""`lexis-sim bench scale`: how the time of LEXIS per keyframe and the size of its map grow with the number of keyframes."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise
from time import process_time

import numpy as np

from lexis.map.arrays import pack
from lexis.types import LexisMap, Observation
from sim.harness import Scenario, run
from sim.harness.adapters import Lexis
from sim.harness.walk import walk
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ
from worlds.presets import sample_house

LAP_M = 40.0
"""Length of one lap of a walk that repeats itself [m]."""


@dataclass(frozen=True)
class Portion:
    """A part of a walk between two keyframes."""

    first: int
    """Id of the first keyframe of the part."""
    last: int
    keyframe_ms: float
    """Processor time of LEXIS per keyframe [ms]. It includes the simulated verification of loops, but no images: neither
    encoding nor feature extraction."""
    active: int
    """Number of keyframes at the end of the part that have not retired from the pose graph."""
    map_bytes: int
    """Size of the arrays of the map at the end of the part [bytes]."""


@dataclass(frozen=True)
class _Mark:
    """What LEXIS had done and stored after some observation."""

    keyframes: int = 0
    spent_s: float = 0.0
    active: int = 0
    map_bytes: int = 0


class _Clocked(Lexis):
    """LEXIS that records the processor time that it has spent, and the size of its map, after some observations."""

    def __init__(self, marked: Collection[int]) -> None:
        """`marked` holds the indices of these observations."""
        super().__init__()
        self._marked, self._spent_s, self.marks = marked, 0.0, [_Mark()]

    def process(self, observation: Observation) -> None:
        """Process the next observation and add its time to the time spent so far."""
        start = process_time()
        super().process(observation)
        self._spent_s += process_time() - start
        if observation.index in self._marked and self._running.keyframe_count:
            map = self._running.snapshot()
            active = sum(keyframe.anchor is None for keyframe in map.keyframes)
            self.marks.append(_Mark(len(map.keyframes), self._spent_s, active, map_bytes(map)))


def measure_scale(
    rooms: int, length_m: float, seed: int, laps: int | None = None, portions: int = 10
) -> tuple[list[Portion], LexisMap]:
    """Walk through the rooms of a home again and again; return at most `portions` parts of the walk and the finished map.

    The walk is a random one of `length_m` or, with `laps`, repeats one circuit of `LAP_M`. The run uses the feature sensor,
    so that no time is spent on rendering. Raises `WorldsError` if there is no house with that many rooms.
    """
    usual = Scenario(fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ, seed=seed)
    scenario = replace(usual, house=sample_house("home", seed, rooms=rooms), tour_kind="random", length_m=length_m)
    if laps is not None:
        scenario = replace(scenario, tour_kind="loop", length_m=laps * LAP_M)
    frames = len(walk(scenario).tour.stamps)
    slam = _Clocked(np.linspace(0, frames - 1, portions + 1).astype(int)[1:].tolist())
    run(scenario, slam)
    return [_portion(before, after) for before, after in pairwise(slam.marks)], slam.map


def _portion(before: _Mark, after: _Mark) -> Portion:
    seconds, keyframes = after.spent_s - before.spent_s, after.keyframes - before.keyframes
    return Portion(before.keyframes, after.keyframes - 1, 1e3 * seconds / max(keyframes, 1), after.active, after.map_bytes)


def map_bytes(map: LexisMap) -> int:
    """Return the size of the arrays of a map [bytes]."""
    return sum(array.nbytes for array in pack(map, features=True).values())
