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

    Frames at one end of the stream are lost, because there is no earlier or later frame with a stamp for them.
    """

    name = "stamp-offset"
    frames: int = setting(1, -100, 100)
    """Number of frames by which the camera's clock is ahead of the odometry's clock; negative if it is behind."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream, with each image combined with the stamp and pose of the frame that is `frames` later."""
        waiting: deque[tuple[Observation, Truth]] = deque()
        for pair in stream:
            waiting.append(pair)
            if len(waiting) > abs(self.frames):
                early, late = waiting.popleft(), pair
                (seen, truth), (dated, _) = (early, late) if self.frames > 0 else (late, early)
                yield replace(dated, index=seen.index).with_images(seen.images), self.mark(truth) if self.frames else truth


@dataclass(frozen=True)
class StampJitter(FrameFault):
    """Stamps are noisy and may even decrease from frame to frame. Image and pose of a frame still belong together."""

    name = "stamp-jitter"
    sigma_s: float = setting(0.02, 0.0)
    """Standard deviation of the noise [s]."""

    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """Return the observation with noise on its stamp."""
        return replace(observation, stamp=observation.stamp + float(rng.normal(0.0, self.sigma_s)))


@dataclass(frozen=True)
class StampJump(FrameFault):
    """During the time span of the fault, the clock is `back_s` behind, as if a time server had set it back."""

    name = "stamp-jump"
    back_s: float = setting(2.0, 0.0)
    """Time by which the clock is set back [s]."""

    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """Return the observation with an earlier stamp."""
        return replace(observation, stamp=observation.stamp - self.back_s)
