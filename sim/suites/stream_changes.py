"""Changes of a SLAM's input, such as another clock or other room names, after which its estimate should stay the same.

A change is applied to the stream of observations and to the room names, before they reach the SLAM; `changed_stream`
converts the estimate back. The SLAM itself stays the same, so the changes apply to any SLAM. `frame_changes` holds changes
of the coordinate frames, and `false_loops` adds wrong loop closures.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Protocol, runtime_checkable

import numpy as np

from lexis.inputs import with_copied_geometry
from lexis.maths.se3 import adjoint, between
from lexis.types import Camera, Observation, Percept, Pose
from sim.harness.feature_input import FeatureInput
from sim.harness.scenario import Scenario
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
"""Other names of rooms. Stairs keep their name, because a SLAM may recognise stairs by this name."""


@runtime_checkable
class StreamChange(Protocol):
    """Interface of a change of the input. Changes have no state, so one object serves any number of runs."""

    @property
    def T_new_old(self) -> Pose:
        """Transform of coordinates from the odometry frame of the run to the odometry frame that the SLAM is given."""

    @property
    def T_B_N(self) -> Pose:
        """Pose of the body frame that the SLAM is given (N), in the body frame of the run (B)."""

    def camera(self, camera: Camera) -> Camera:
        """Return the camera that the SLAM is told."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the room names that the SLAM is told, in order.

        Each is mapped to the unchanged room name for which it stands, or to None if there is no such room name.
        """

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield what the SLAM gets in place of this observation.

        Each yielded observation has the index of the unchanged observation that it shows. If several have the same index,
        what the SLAM estimates for the last one counts. `previous` is a copy of the unchanged observation before this one;
        None at the beginning.
        """

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return the changed feature model and loop verifier, for a run on features."""

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Return whether the change reaches this SLAM in this scenario."""


@dataclass(frozen=True)
class NoChange:
    """No change: the SLAM is run once more. Other changes derive from this class."""

    @property
    def T_new_old(self) -> Pose:
        """The identity: the odometry frame stays the same."""
        return np.eye(4)

    @property
    def T_B_N(self) -> Pose:
        """The identity: the body frame stays the same."""
        return np.eye(4)

    def camera(self, camera: Camera) -> Camera:
        """Return the camera unchanged."""
        return camera

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the names as they are."""
        return {name: name for name in room_names}

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation unchanged."""
        yield observation

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return the input unchanged."""
        return features

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Return whether the change reaches this SLAM in this scenario."""
        return True


@dataclass(frozen=True)
class OtherClock(NoChange):
    """Stamps count from 1970, as the clocks of robots do, instead of from the start of the run."""

    offset_s: float = 1.75e9
    """Time that is added to all stamps [s]."""

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation with its new stamp."""
        yield replace(observation, stamp=self.offset_s + observation.stamp)


@dataclass(frozen=True)
class ReusedArrays(NoChange):
    """Image or percept, pose and covariance are overwritten after the SLAM has processed them, as in a driver's buffers."""

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield a copy of the observation, and overwrite the copy when the next observation is requested."""
        lent = copied(observation)
        yield lent
        for seen in lent.images:
            for array in (seen.embedding, seen.points) if isinstance(seen, Percept) else (seen,):
                array[...] = 0
        lent.T_O_B[...] = lent.increment_covariance[...] = 0


@dataclass(frozen=True)
class Pause(NoChange):
    """The robot stands still at regular intervals: an observation is repeated, which delays all later ones."""

    every_s: float = 10.0
    """Walking time from one pause to the next [s]."""
    repeats: int = 15
    """Number of times that the observation of a pause is repeated."""
    period_s: float = 1.0
    """Time between two repetitions of an observation [s]."""

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the repetitions of the previous observation, if the robot has paused there, and then the observation."""
        pauses = int(observation.stamp // self.every_s)
        if previous is not None and previous.stamp // self.every_s < pauses:
            still, late = np.eye(6) * 1e-12, self._delayed(previous)
            for k in range(1, self.repeats + 1):
                yield replace(copied(late), stamp=late.stamp + k * self.period_s, increment_covariance=still.copy())
        yield copied(self._delayed(observation))

    def _delayed(self, observation: Observation) -> Observation:
        pauses = int(observation.stamp // self.every_s)
        return replace(observation, stamp=observation.stamp + pauses * self.repeats * self.period_s)


@dataclass(frozen=True)
class Slip(NoChange):
    """The odometry slips, once or repeatedly, and states an error as large as the slip for this step.

    Loop closures can therefore mend the slips.
    """

    first_s: float = 20.5
    """Time of the first slip [s]. The first observation that is not earlier has the slip before it."""
    every_s: float = math.inf
    """Time from one slip to the next [s]; infinite: there is only one slip."""
    shift_m: tuple[float, float, float] = (0.5, -0.4, 0.0)
    """Displacement in the odometry frame of all poses after a slip [m]. The displacements of several slips add up."""

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation with its pose displaced by all slips so far."""
        slips = self._slips_until(observation.stamp)
        new = slips - (0 if previous is None else self._slips_until(previous.stamp))
        T_O_B, covariance = observation.T_O_B.copy(), observation.increment_covariance.copy()
        T_O_B[:3, 3] += slips * np.array(self.shift_m)
        covariance[3:, 3:] += np.eye(3) * new**2 * float(np.dot(self.shift_m, self.shift_m))
        yield replace(observation, T_O_B=T_O_B, increment_covariance=covariance)

    def _slips_until(self, stamp: float) -> int:
        return 0 if stamp < self.first_s else 1 + int((stamp - self.first_s) // self.every_s)


@dataclass(frozen=True)
class HeightDrift(NoChange):
    """The odometry rises all the time, also on level floors, and states an additional error as large as each rise."""

    rate_m_s: float = 0.015
    """Speed at which the odometry rises [m/s]."""

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation with its pose raised by the drift so far, and its covariance by that of the latest rise."""
        T_O_B, covariance = observation.T_O_B.copy(), observation.increment_covariance.copy()
        T_O_B[2, 3] += self.rate_m_s * observation.stamp
        if previous is not None:
            up = T_O_B[2, :3]  # the vertical, in the body frame
            covariance[3:, 3:] += np.outer(up, up) * (self.rate_m_s * (observation.stamp - previous.stamp)) ** 2
        yield replace(observation, T_O_B=T_O_B, increment_covariance=covariance)


@dataclass(frozen=True)
class StepsInTwoParts(NoChange):
    """The odometry reports each step in two parts: the first without motion, the second with the whole motion.

    Each part has half of the step's covariance. For the first part, the SLAM gets the previous observation once more.
    """

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the previous observation again, half a step later, and then this observation with half its covariance."""
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
    """The room names come in another order, which from three names on is neither the original order nor its reverse."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the names at odd positions, followed by the names at even positions in reverse order."""
        return {name: name for name in (*room_names[1::2], *reversed(room_names[::2]))}


@dataclass(frozen=True)
class MoreNames(NoChange):
    """There are additional room names, for rooms that no house has."""

    more: tuple[str, ...] = ("swimming pool", "stable")

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the original room names, followed by the additional names in `more`."""
        return {name: name for name in room_names} | dict.fromkeys(self.more)


@dataclass(frozen=True)
class CapitalLetters(NoChange):
    """Room names are in capital letters, except for stairs."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return the names in capital letters."""
        return {name if name == STAIRS else name.upper(): name for name in room_names}


@dataclass(frozen=True)
class Synonyms(NoChange):
    """Rooms have other names of the same meaning."""

    def names(self, room_names: Sequence[str]) -> Mapping[str, str | None]:
        """Return a synonym of each name, or the name itself if it has no synonym or the synonym is a room name, too."""
        free = {name: synonym for name, synonym in _SYNONYMS.items() if synonym not in room_names}
        return {free.get(name, name): name for name in room_names}


def copied(observation: Observation) -> Observation:
    """Return an observation whose arrays are copies, except for key points."""
    own = with_copied_geometry(observation)
    return own.with_images(
        replace(image, embedding=image.embedding.copy()) if isinstance(image, Percept) else image.copy()
        for image in own.images
    )
