"""Changes of a SLAM's input, such as another clock or other room names, after which its claims should stay the same.

A change works on the stream of observations and on the room names, before they reach the SLAM; `changed_stream` converts the
claims back. The SLAM is not touched, so that the changes apply to any SLAM. `frame_changes` holds changes of the coordinate
frames, `image_changes` those of images, and `false_loops` wrong loop closures.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Protocol

import numpy as np

from lexis.inputs import with_copied_geometry
from lexis.maths.se3 import adjoint, between
from lexis.types import Camera, Observation, Percept, Pose
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import FeatureInput
from worlds.labels import STAIRS

_SYNONYMS = MappingProxyType(
    {
        "kitchen": "cooking area",
        "dining room": "eating area",
        "living room": "sitting room",
        "bedroom": "sleeping room",
        "children's room": "playroom",
        "bathroom": "shower room",
        "toilet": "restroom",
        "corridor": "hallway",
        "entrance hall": "foyer",
        "office": "private office",
        "meeting room": "conference room",
        "open-plan office": "shared office",
        "lobby": "reception",
        "laundry room": "laundry",
        "storage room": "storeroom",
    }
)
"""Other names of rooms. Stairs keep their name, because a SLAM may know them by it."""


class StreamChange(Protocol):
    """Interface of a change. Changes have no state, so one object serves any number of runs."""

    @property
    def T_new_old(self) -> Pose:
        """The motion from the odometry frame of the run to the one in which the SLAM is given its input."""

    @property
    def T_B_N(self) -> Pose:
        """Pose of the body frame in which the SLAM is given its input (N) in the body frame of the run (B)."""

    def camera(self, camera: Camera) -> Camera:
        """Return the camera that the SLAM is told."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the room names that the SLAM is told, in order, each with the name that it stands for; None: with none."""

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield what the SLAM gets in place of the observation with this number, counted from 0.

        Each has the index of the observation that it shows; of several, the last one counts. `previous` is the unchanged
        observation before, a copy of its own; None at the beginning.
        """

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return what takes the place of images in runs on features."""

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Whether the change reaches this SLAM in this scenario at all."""


@dataclass(frozen=True)
class NoChange:
    """No change: the SLAM is run once more."""

    @property
    def T_new_old(self) -> Pose:
        """The identity: the odometry frame stays."""
        return np.eye(4)

    @property
    def T_B_N(self) -> Pose:
        """The identity: the body frame stays."""
        return np.eye(4)

    def camera(self, camera: Camera) -> Camera:
        """Return the camera unchanged."""
        return camera

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the names as they are."""
        return {name: name for name in room_names}

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation unchanged."""
        yield observation

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return the input unchanged."""
        return features

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Whether the change reaches this SLAM in this scenario at all."""
        return True


@dataclass(frozen=True)
class OtherClock(NoChange):
    """The clock shows the time since 1970, as those of robots do, instead of the time since the start."""

    offset_s: float = 1.75e9
    """Time by which all stamps are later [s]."""

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation with its new stamp."""
        yield replace(observation, stamp=self.offset_s + observation.stamp)


@dataclass(frozen=True)
class ReusedArrays(NoChange):
    """Image or percept, pose and covariance are overwritten once the SLAM has processed them, as by a driver's buffers."""

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield a copy of the observation, and overwrite the copy when the next observation is asked for."""
        lent = copied(observation)
        yield lent
        seen = lent.image
        of_image = (seen.embedding, seen.points) if isinstance(seen, Percept) else (seen,)
        for array in (*of_image, lent.T_O_B, lent.increment_covariance):
            array[...] = 0


@dataclass(frozen=True)
class Pause(NoChange):
    """The robot stands still now and then: an observation is repeated, and the later ones come later."""

    every: int = 20
    """Number of observations from one pause to the next."""
    repeats: int = 15
    """How often the observation is repeated at which the robot stands still."""
    period_s: float = 1.0
    """Time between the repeated observations [s]."""

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation, and then its repetitions if the robot stands still there."""
        late = replace(observation, stamp=observation.stamp + number // self.every * self.repeats * self.period_s)
        yield copied(late)
        if number % self.every == self.every - 1:
            still = np.eye(6) * 1e-12
            for k in range(1, self.repeats + 1):
                yield replace(copied(late), stamp=late.stamp + k * self.period_s, increment_covariance=still.copy())


@dataclass(frozen=True)
class Slip(NoChange):
    """The odometry slips once and says so: the covariance of this step is as large as the slip, so loops can mend it."""

    after: int = 40
    """Number of the last observation before the slip, counted from 0."""
    shift_m: tuple[float, float, float] = (0.5, -0.4, 0.0)
    """Displacement of all later poses in the odometry frame [m]."""

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation, with its displaced pose after the slip."""
        if number <= self.after:
            yield observation
            return
        T_O_B, covariance = observation.T_O_B.copy(), observation.increment_covariance
        T_O_B[:3, 3] += self.shift_m
        if number == self.after + 1:
            covariance = covariance.copy()
            covariance[3:, 3:] += np.eye(3) * float(np.dot(self.shift_m, self.shift_m))
        yield replace(observation, T_O_B=T_O_B, increment_covariance=covariance)


@dataclass(frozen=True)
class HeightDrift(NoChange):
    """The odometry rises all the time, also on level floors. For each step it states an error as large as its rise."""

    rate_m_s: float = 0.02
    """Speed of the drift [m/s]."""

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation with its displaced pose."""
        T_O_B, covariance = observation.T_O_B.copy(), observation.increment_covariance.copy()
        T_O_B[2, 3] += self.rate_m_s * observation.stamp
        if previous is not None:
            up = T_O_B[2, :3]  # the vertical, in the body frame
            covariance[3:, 3:] += np.outer(up, up) * (self.rate_m_s * (observation.stamp - previous.stamp)) ** 2
        yield replace(observation, T_O_B=T_O_B, increment_covariance=covariance)


@dataclass(frozen=True)
class StepsInTwoParts(NoChange):
    """Before each observation, the robot stands still at the place of the one before it, with half of the uncertainty.

    The motion since the observation before, and its whole covariance, are the same as without the additional observation.
    """

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation before once more, half a step later, and then this one with half of its covariance."""
        if previous is None:
            yield observation
            return
        half = 0.5 * observation.increment_covariance
        Ad = adjoint(between(previous.T_O_B, observation.T_O_B))  # from the body at the end of the step to the one before
        stamp = 0.5 * (previous.stamp + observation.stamp)
        yield replace(previous, stamp=stamp, increment_covariance=Ad @ half @ Ad.T)
        yield replace(observation, increment_covariance=half)


@dataclass(frozen=True)
class PermutedNames(NoChange):
    """The room names come in another order, which is neither theirs nor its reverse."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the names at odd places, followed by those at even places in the reverse order."""
        return {name: name for name in (*room_names[1::2], *reversed(room_names[::2]))}


@dataclass(frozen=True)
class MoreNames(NoChange):
    """There are further room names, for rooms that no house has."""

    more: tuple[str, ...] = ("swimming pool", "stable")

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the names, followed by the further ones."""
        return {name: name for name in room_names} | dict.fromkeys(self.more)


@dataclass(frozen=True)
class CapitalLetters(NoChange):
    """Rooms have their names in capital letters, except for stairs."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the names in capital letters."""
        return {name if name == STAIRS else name.upper(): name for name in room_names}


@dataclass(frozen=True)
class Synonyms(NoChange):
    """Rooms have other names of the same meaning."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return a synonym of each name, or the name itself where none is known or the synonym is a room name as well."""
        free = {name: synonym for name, synonym in _SYNONYMS.items() if synonym not in room_names}
        return {free.get(name, name): name for name in room_names}


def copied(observation: Observation) -> Observation:
    """Return an observation whose arrays are copies, except for key points."""
    own = with_copied_geometry(observation)
    image = own.image
    seen = replace(image, embedding=image.embedding.copy()) if isinstance(image, Percept) else image.copy()
    return replace(own, image=seen)
