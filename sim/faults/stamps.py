"""Faults of clocks: images that say a wrong time."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from lexis.types import Observation
from sim.faults.fault import FrameFault, StreamFault, setting
from sim.truth import Stream, Truth


@dataclass(frozen=True)
class StampOffset(StreamFault):
    """Camera and odometry disagree on the time: each image is given the stamp and the pose of an earlier or later frame.

    The frames at one end have no pose to go with and are lost.
    """

    name = "stamp-offset"
    frames: int = setting(1, -100, 100)
    """How far the image's clock is ahead of the odometry's; negative: behind."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with images beside other frames' stamps and poses."""
        waiting: deque[tuple[Observation, Truth]] = deque()
        for pair in stream:
            waiting.append(pair)
            if len(waiting) > abs(self.frames):
                early, late = waiting.popleft(), pair
                (seen, truth), (dated, _) = (early, late) if self.frames > 0 else (late, early)
                yield replace(dated, index=seen.index, image=seen.image), self.mark(truth) if self.frames else truth


@dataclass(frozen=True)
class StampJitter(FrameFault):
    """Stamps are noisy, so that time may even go backwards; images and poses belong together."""

    name = "stamp-jitter"
    sigma_s: float = setting(0.02, 0.0)
    """Standard deviation [s]."""

    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """The observation with noise on its stamp."""
        return replace(observation, stamp=observation.stamp + float(rng.normal(0.0, self.sigma_s)))


@dataclass(frozen=True)
class StampJump(FrameFault):
    """The clock is set back, as by a time server."""

    name = "stamp-jump"
    back_s: float = setting(2.0, 0.0)
    """By how much [s]."""

    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """The observation with an earlier stamp."""
        return replace(observation, stamp=observation.stamp - self.back_s)
