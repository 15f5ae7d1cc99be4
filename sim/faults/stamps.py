"""Faults of clocks: observations with wrong stamps."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from lexis.types import Observation
from sim.faults.fault import FrameFault, StreamFault, setting
from sim.truth import Stream, Truth


@dataclass(frozen=True)
class StampOffset(StreamFault):
    """The clocks of camera and odometry differ: each image gets the stamp and the pose of an earlier or later frame.

    Frames at one end of the stream have no such partner and are lost.
    """

    name = "stamp-offset"
    frames: int = setting(1, -100, 100)
    """Number of frames by which the camera's clock is ahead of the odometry's; negative if it is behind."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream with each image beside the stamp and pose of another frame."""
        waiting: deque[tuple[Observation, Truth]] = deque()
        for pair in stream:
            waiting.append(pair)
            if len(waiting) > abs(self.frames):
                early, late = waiting.popleft(), pair
                (seen, truth), (dated, _) = (early, late) if self.frames > 0 else (late, early)
                yield replace(dated, index=seen.index, image=seen.image), self.mark(truth) if self.frames else truth


@dataclass(frozen=True)
class StampJitter(FrameFault):
    """Stamps are noisy, so that they may even descend. Images and poses still belong together."""

    name = "stamp-jitter"
    sigma_s: float = setting(0.02, 0.0)
    """Standard deviation of the noise [s]."""

    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """Return the observation with noise on its stamp."""
        return replace(observation, stamp=observation.stamp + float(rng.normal(0.0, self.sigma_s)))


@dataclass(frozen=True)
class StampJump(FrameFault):
    """The clock is set back, as a time server may do."""

    name = "stamp-jump"
    back_s: float = setting(2.0, 0.0)
    """Time by which the clock is set back [s]."""

    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """Return the observation with an earlier stamp."""
        return replace(observation, stamp=observation.stamp - self.back_s)
