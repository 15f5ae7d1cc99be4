"""Faults of the odometry, and kidnapping, which the odometry does not notice."""

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from lexis.maths.se3 import between, inverse, upright
from lexis.types import Observation
from sim.faults.fault import SpanFault, StreamFault, has_pose, setting
from sim.truth import Stream, Truth


@dataclass(frozen=True)
class OdometryJump(StreamFault):
    """The odometry's pose jumps once in a random horizontal direction. The reported covariance does not show the jump."""

    name = "odometry-jump"
    at_s: float = setting(60.0, 0.0)
    """Time after the start of the tour at which the odometry jumps [s]."""
    distance_m: float = setting(1.0, 0.0)
    """Length of the jump [m]."""
    turn_rad: float = setting(0.2, 0.0, math.pi)
    """Change of yaw, of random sign [rad]."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream. From the jump on, all estimated poses are displaced by one rigid motion."""
        direction, sign = rng.uniform(-np.pi, np.pi), rng.choice([-1.0, 1.0])
        move = upright(sign * self.turn_rad, self.distance_m * np.array([np.cos(direction), np.sin(direction), 0.0]))
        jump = None
        for observation, truth in stream:
            if truth.stamp < self.at_s or (jump is None and not has_pose(observation)):
                yield observation, truth
                continue
            T_O_B = observation.T_O_B
            if jump is None:
                jump = T_O_B @ move @ inverse(T_O_B)
            yield replace(observation, T_O_B=jump @ T_O_B), self.mark(truth)


@dataclass(frozen=True)
class OdometryFreeze(SpanFault):
    """The odometry freezes while the body moves. Afterwards it continues from the frozen pose, without the missed motion."""

    name = "odometry-freeze"
    at_s: float = setting(60.0, 0.0, kw_only=True)
    """Time after the start of the tour at which the fault begins [s]."""
    for_s: float = setting(3.0, 0.0, kw_only=True)
    """Duration of the fault [s]."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream with frozen poses while the fault lasts.

        Afterwards all poses stay wrong, because the odometry continues from the frozen pose. The truth of every frame with a
        wrong pose contains the name of this fault.
        """
        before: Observation | None = None
        reported = np.eye(4)
        frozen = False
        for observation, truth in stream:
            frozen = frozen or (before is not None and self.active(truth))
            known = has_pose(observation)
            if before is None or not frozen:
                reported = observation.T_O_B if known else reported
                yield observation, truth
            elif self.active(truth):
                yield replace(observation, T_O_B=reported), self.mark(truth)
            elif not known:
                yield observation, self.mark(truth)
            else:
                reported = reported @ between(before.T_O_B, observation.T_O_B)
                yield replace(observation, T_O_B=reported), self.mark(truth)
            before = observation if known else before


@dataclass(frozen=True)
class OdometryNaN(SpanFault):
    """The odometry fails for single frames: all entries of the pose are NaN."""

    name = "odometry-nan"
    share: float = setting(0.02, 0.0, 1.0)
    """Share of the frames in the fault's time span for which the odometry fails."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream, with the odometry's pose replaced by NaN in frames that are drawn at random."""
        for observation, truth in stream:
            if self.active(truth) and rng.random() < self.share:
                yield replace(observation, T_O_B=np.full((4, 4), np.nan)), self.mark(truth)
            else:
                yield observation, truth


@dataclass(frozen=True)
class Kidnap(StreamFault):
    """The body is moved elsewhere between two frames. Neither the odometry nor the clock shows this.

    To simulate this, a part is cut out of the tour. The stamps, the true stamps and the estimated poses of the frames after
    the cut are changed, as if this part had never been there. The truth of these frames names the fault.
    """

    name = "kidnap"
    at_s: float = setting(60.0, 0.0)
    """Time after the start of the tour at which the body is moved [s]."""
    skip_s: float = setting(20.0, 0.0)
    """Duration of the part that is cut out of the tour [s]. The body continues from its place at the end of this part."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream without the part that is cut out. Stamps and estimated poses continue without a gap."""
        last: tuple[Observation, Truth] | None = None
        unseen: tuple[Observation, Truth] | None = None
        before, within = np.eye(4), np.eye(4)  # the last known poses before the cut and in it
        over = False
        for observation, truth in stream:
            if last is None or truth.stamp < self.at_s:
                if unseen is None and not over:  # otherwise, the frame is late
                    last = observation, truth
                    before = within = observation.T_O_B if has_pose(observation) else before
                yield observation, truth
            elif truth.stamp < self.at_s + self.skip_s:
                if not over:
                    unseen = observation, truth
                    within = observation.T_O_B if has_pose(observation) else within
            else:
                over = True
                if unseen is None:
                    yield observation, truth
                    continue
                # Faults of the clock may have changed the stamps, but not the true stamps.
                cut_s, true_cut_s = unseen[0].stamp - last[0].stamp, unseen[1].stamp - last[1].stamp
                T_O_B = before @ between(within, observation.T_O_B)
                moved = replace(observation, stamp=observation.stamp - cut_s, T_O_B=T_O_B)
                yield moved, replace(self.mark(truth), stamp=truth.stamp - true_cut_s)

    def cut(self, stamps: Float64[np.ndarray, "n"]) -> tuple[float, float]:
        """Return the part that is cut out of a walk: its start (excluded) and its end (included) [s].

        `stamps` are the stamps that all frames have without this fault [s]. Data of other sensors are cut in the same way.
        Both times are equal if no frame is cut out.
        """
        last = stamps[stamps < self.at_s][-1:] if (stamps < self.at_s).any() else stamps[:1]
        unseen = stamps[(stamps < self.at_s + self.skip_s) & (stamps > last)]
        return float(last[0]), float(unseen[-1]) if unseen.size else float(last[0])
