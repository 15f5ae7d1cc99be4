"""`lexis-sim bench scale`: how the time of LEXIS per keyframe and the size of its map grow with the number of keyframes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import process_time

import numpy as np
from jaxtyping import Float64, Int

from lexis.map.arrays import pack
from lexis.types import LexisMap, Observation
from sim.harness import Scenario, run
from sim.harness.adapters import Lexis
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ
from worlds.presets import sample_house

_PORTIONS = 8


@dataclass(frozen=True)
class Portion:
    """A part of a walk between two keyframes."""

    first: int
    """Id of the first keyframe of the part."""
    last: int
    keyframe_ms: float
    """Processor time of LEXIS per keyframe, features and percepts not included [ms]."""


class _Clocked(Lexis):
    """LEXIS that records the processor time it has spent until the end of each observation [s]."""

    def __init__(self) -> None:
        super().__init__()
        self.spent_s: list[float] = []

    def process(self, observation: Observation) -> None:
        """Process the next observation and add its time to the time spent so far."""
        start = process_time()
        super().process(observation)
        self.spent_s.append((self.spent_s[-1] if self.spent_s else 0.0) + process_time() - start)


def measure_scale(rooms: int, length_m: float, seed: int) -> tuple[list[Portion], LexisMap]:
    """Walk a path through the rooms of a home again and again; return the times of its parts and the finished map.

    The run uses the feature sensor, so that no time is spent on rendering. Raises `WorldsError` if there is no house with
    that many rooms.
    """
    house = sample_house("home", seed, rooms=rooms)
    usual = Scenario(fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ, tour_kind="random")
    slam = _Clocked()
    run(replace(usual, house=house, seed=seed, length_m=length_m), slam)
    frames = np.array([keyframe.observation_index for keyframe in slam.map.keyframes])
    return list(_portions(np.array(slam.spent_s), frames)), slam.map


def _portions(spent_s: Float64[np.ndarray, "observations"], frames: Int[np.ndarray, "keyframes"]) -> Iterator[Portion]:
    """Divide the keyframes into equal parts; yield the parts with their times.

    `spent_s` is the processor time until the end of each observation [s]; `frames` holds the observations of the keyframes.
    """
    ends = np.linspace(0, len(frames) - 1, _PORTIONS + 1).astype(int)
    for first, last in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        seconds = spent_s[frames[last]] - spent_s[frames[first]]
        yield Portion(first, last, 1e3 * float(seconds) / max(last - first, 1))


def bytes_per_keyframe(map: LexisMap) -> float:
    """Return the size of the arrays of a map per keyframe [bytes]."""
    return sum(array.nbytes for array in pack(map, features=True).values()) / len(map.keyframes)
