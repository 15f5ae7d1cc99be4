"""Faults of delivery: frames that are lost, repeated, stuck, or arrive in the wrong order."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexis.maths.se3 import between, compose_covariance
from lexis.types import Observation
from sim.faults.fault import StreamFault, setting
from sim.truth import Stream, Truth


@dataclass(frozen=True)
class Dropped(StreamFault):
    """Frames are lost. The odometry goes on: the next frame's covariance covers the gap, and it is the one recorded."""

    name = "dropped"
    share: float = setting(0.1, 0.0, 1.0)
    """Of the frames that are lost; the first never is."""
    burst: int = setting(1, 1)
    """Frames lost in a row."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream without the lost frames."""
        lost: list[Observation] = []
        for (observation, truth), is_lost in zip(stream, _bursts(self.share, self.burst, rng), strict=False):
            if is_lost:
                lost.append(observation)
                continue
            if lost:
                observation, truth = _bridging(lost, observation), self.mark(truth)
                lost = []
            yield observation, truth


def _bursts(share: float, burst: int, rng: np.random.Generator) -> Iterator[bool]:
    """Of one frame after the other, whether it is in a burst, so that bursts hold that share of them; the first never is."""
    rate = share / (share + burst * (1.0 - share)) if share < 1.0 else 1.0
    yield False
    left = 0
    while True:
        if left == 0 and rng.random() < rate:
            left = burst
        yield left > 0
        left = max(left - 1, 0)


def _bridging(lost: list[Observation], after: Observation) -> Observation:
    """The observation after a gap, with the covariance since the one before it."""
    covariance = lost[0].increment_covariance
    for previous, current in zip(lost, [*lost[1:], after], strict=True):
        increment = between(previous.T_O_B, current.T_O_B)
        covariance = compose_covariance(covariance, increment, current.increment_covariance)
    return replace(after, increment_covariance=covariance)


@dataclass(frozen=True)
class Frozen(StreamFault):
    """The camera hangs: the same image again and again, while stamps and odometry go on."""

    name = "frozen"
    share: float = setting(0.05, 0.0, 1.0)
    """Of the frames that show an old image."""
    burst: int = setting(10, 1)
    """Frames in a row with the image of the one before them."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with images that stay."""
        shown: Observation | None = None
        for (observation, truth), is_stuck in zip(stream, _bursts(self.share, self.burst, rng), strict=False):
            if is_stuck and shown is not None:
                yield replace(observation, image=shown.image), self.mark(truth)
            else:
                shown = observation
                yield observation, truth


@dataclass(frozen=True)
class Duplicated(StreamFault):
    """Frames arrive twice, all of them the same, stamp included; the second is recorded."""

    name = "duplicated"
    share: float = setting(0.1, 0.0, 1.0)
    """Of the frames that arrive twice."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with frames repeated."""
        for observation, truth in stream:
            yield observation, truth
            if rng.random() < self.share:
                yield observation, self.mark(truth)


@dataclass(frozen=True)
class Late(StreamFault):
    """Frames arrive after frames that were made after them, with the right stamp."""

    name = "late"
    share: float = setting(0.05, 0.0, 1.0)
    """Of the frames that are late."""
    frames: int = setting(3, 1)
    """How many overtake a late one."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with frames held back."""
        held: deque[tuple[int, Observation, Truth]] = deque()
        for position, (observation, truth) in enumerate(stream):
            if rng.random() < self.share:
                held.append((position + self.frames, observation, self.mark(truth)))
            else:
                yield observation, truth
            while held and held[0][0] <= position:
                yield held.popleft()[1:]
        for _, observation, truth in held:
            yield observation, truth


@dataclass(frozen=True)
class OutOfOrder(StreamFault):
    """Frames arrive in groups whose order is random, with the right stamps; those not in their place are recorded."""

    name = "out-of-order"
    share: float = setting(0.1, 0.0, 1.0)
    """Of the groups that are shuffled."""
    group: int = setting(4, 2)
    """Frames in a group."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with groups shuffled."""
        waiting: list[tuple[Observation, Truth]] = []
        for pair in stream:
            waiting.append(pair)
            if len(waiting) == self.group:
                yield from self._shuffled(waiting, rng)
                waiting = []
        yield from waiting

    def _shuffled(self, pairs: list[tuple[Observation, Truth]], rng: np.random.Generator) -> Stream:
        order = rng.permutation(len(pairs)) if rng.random() < self.share else np.arange(len(pairs))
        for place, k in enumerate(order):
            observation, truth = pairs[k]
            yield observation, truth if k == place else self.mark(truth)
