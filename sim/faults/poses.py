"""Faults of the odometry, and kidnapping, which it knows nothing of."""

import math
from dataclasses import dataclass, replace

import numpy as np

from lexis.maths.se3 import between, exp, inverse
from lexis.types import Observation
from sim.faults.fault import SpanFault, StreamFault, setting
from sim.truth import Stream


@dataclass(frozen=True)
class OdometryJump(StreamFault):
    """The odometry jumps once, in a random direction on the floor, and its covariance says nothing of it."""

    name = "odometry-jump"
    at_s: float = setting(60.0, 0.0)
    """When, after the start of the tour [s]."""
    distance_m: float = setting(1.0, 0.0)
    """How far [m]."""
    turn_rad: float = setting(0.2, 0.0, math.pi)
    """How far it turns, either way [rad]."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with all poses from then on moved as one."""
        direction, sign = rng.uniform(-np.pi, np.pi), rng.choice([-1.0, 1.0])
        move = np.eye(4)
        move[:3, :3] = exp(np.array([0.0, 0.0, sign * self.turn_rad, 0.0, 0.0, 0.0]))[:3, :3]
        move[:2, 3] = self.distance_m * np.array([np.cos(direction), np.sin(direction)])
        jump = None
        for observation, truth in stream:
            if truth.stamp < self.at_s:
                yield observation, truth
                continue
            T_O_B = observation.T_O_B
            if jump is None:
                jump = T_O_B @ move @ inverse(T_O_B)
            yield replace(observation, T_O_B=jump @ T_O_B), self.mark(truth)


@dataclass(frozen=True)
class OdometryFreeze(SpanFault):
    """The odometry hangs: the pose stays while the body moves, and goes on from there without what was missed."""

    name = "odometry-freeze"
    at_s: float = setting(60.0, 0.0, kw_only=True)
    """When it begins, after the start of the tour [s]."""
    for_s: float = setting(3.0, 0.0, kw_only=True)
    """How long it lasts [s]."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with a pose that stays; all poses after it are recorded too, for they are off."""
        before: Observation | None = None
        reported = np.eye(4)
        frozen = False
        for observation, truth in stream:
            frozen = frozen or (before is not None and self.active(truth))
            if before is None or not frozen:
                reported = observation.T_O_B
                yield observation, truth
            else:
                if not self.active(truth):
                    reported = reported @ between(before.T_O_B, observation.T_O_B)
                yield replace(observation, T_O_B=reported), self.mark(truth)
            before = observation


@dataclass(frozen=True)
class OdometryNaN(SpanFault):
    """The odometry loses track for single frames: all of the pose is not a number."""

    name = "odometry-nan"
    share: float = setting(0.02, 0.0, 1.0)
    """Of the frames of its span."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with poses of NaN."""
        for observation, truth in stream:
            if self.active(truth) and rng.random() < self.share:
                yield replace(observation, T_O_B=np.full((4, 4), np.nan)), self.mark(truth)
            else:
                yield observation, truth


@dataclass(frozen=True)
class Kidnap(StreamFault):
    """The body is elsewhere from one frame to the next; odometry and clock do not know: a stretch of the tour is cut out.

    All frames after it are recorded: their poses and stamps are those that the odometry and the clock make of it.
    """

    name = "kidnap"
    at_s: float = setting(60.0, 0.0)
    """When, after the start of the tour [s]."""
    skip_s: float = setting(20.0, 0.0)
    """How much of the tour is cut out: the body goes on from where it would have been after that time [s]."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream without the stretch, its ends joined as if there had been none."""
        last: Observation | None = None
        unseen: Observation | None = None
        for observation, truth in stream:
            if last is None or truth.stamp < self.at_s:
                last = observation
                yield observation, truth
            elif truth.stamp < self.at_s + self.skip_s:
                unseen = observation
            elif unseen is None:
                yield observation, truth
            else:
                cut_s = unseen.stamp - last.stamp
                T_O_B = last.T_O_B @ between(unseen.T_O_B, observation.T_O_B)
                moved = replace(observation, stamp=observation.stamp - cut_s, T_O_B=T_O_B)
                yield moved, replace(self.mark(truth), stamp=truth.stamp - cut_s)
