"""Faults of delivery: frames that are lost, frozen, duplicated, late, or in the wrong order."""

from collections import deque
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np

from lexis.maths.se3 import between, compose_covariance
from lexis.types import Image, Observation, Percept
from sim.faults.fault import StreamFault, has_pose, setting
from sim.truth import Stream, Truth


@dataclass(frozen=True)
class Dropped(StreamFault):
    """Frames are lost while the odometry continues.

    The truth of the first frame after a gap names this fault. The covariance of this frame's odometry is that of the whole
    motion since the last frame before the gap.
    """

    name = "dropped"
    share: float = setting(0.1, 0.0, 1.0)
    """Share of the frames that are lost. The first frame is never lost."""
    burst: int = setting(1, 1)
    """Number of frames lost in a row."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream without the lost frames."""
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
    """Yield for each frame whether it belongs to a burst, a sequence of `burst` consecutive frames.

    On average, bursts contain `share` of the frames. The first frame never belongs to a burst.
    """
    rate = share / (share + burst * (1.0 - share)) if share < 1.0 else 1.0
    yield False
    left = 0
    while True:
        if left == 0 and rng.random() < rate:
            left = burst
        yield left > 0
        left = max(left - 1, 0)


def _bridging(lost: list[Observation], after: Observation) -> Observation:
    """Return the observation `after` a gap, with the covariance of the motion since the last observation before the gap."""
    covariance, known = lost[0].increment_covariance, lost[0]
    for current in (*lost[1:], after):
        # A step without a known pose counts as one without motion.
        increment = between(known.T_O_B, current.T_O_B) if has_pose(known) and has_pose(current) else np.eye(4)
        covariance = compose_covariance(covariance, increment, current.increment_covariance)
        known = current if has_pose(current) else known
    return replace(after, increment_covariance=covariance)


@dataclass(frozen=True)
class Frozen(StreamFault):
    """The cameras freeze: they repeat their images, while stamps and odometry continue."""

    name = "frozen"
    share: float = setting(0.05, 0.0, 1.0)
    """Share of the frames that show an old image."""
    burst: int = setting(10, 1)
    """Number of consecutive frames that repeat the last image before them."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream. Frames of a burst show the image of the last frame before the burst."""
        shown: tuple[Image | Percept, ...] = ()
        for (observation, truth), is_stuck in zip(stream, _bursts(self.share, self.burst, rng), strict=False):
            if is_stuck and shown:
                yield observation.with_images(_copies(shown)), self.mark(truth)
            else:
                shown = _copies(observation.images)
                yield observation, truth


def _copies(images: Sequence[Image | Percept]) -> tuple[Image | Percept, ...]:
    """Return copies of images or percepts, because the SLAM may write into the arrays that it gets."""
    return tuple(map(deepcopy, images))


@dataclass(frozen=True)
class Duplicated(StreamFault):
    """Frames arrive twice with the same stamp. The truth of the second copy names this fault."""

    name = "duplicated"
    share: float = setting(0.1, 0.0, 1.0)
    """Share of the frames that arrive twice."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream, with a copy after each frame that is drawn at random."""
        for observation, truth in stream:
            is_twice = rng.random() < self.share
            images = _copies(observation.images) if is_twice else ()
            yield observation, truth
            if is_twice:
                yield observation.with_images(images), self.mark(truth)


@dataclass(frozen=True)
class Late(StreamFault):
    """Frames are delayed, and arrive after later frames. Their stamps stay right."""

    name = "late"
    share: float = setting(0.05, 0.0, 1.0)
    """Share of the frames that are late."""
    frames: int = setting(3, 1)
    """Number of frames that a late frame is behind: it arrives after the frame that follows it at this distance."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream, with frames that are drawn at random delayed by `frames` places."""
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
    """Some groups of successive frames arrive shuffled within the group. All frames keep their right stamps.

    The ground truth of each frame that arrives in the wrong place names this fault.
    """

    name = "out-of-order"
    share: float = setting(0.1, 0.0, 1.0)
    """Share of the groups that are shuffled."""
    group: int = setting(4, 2)
    """Number of frames in a group."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream, with the frames shuffled in groups that are drawn at random."""
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
