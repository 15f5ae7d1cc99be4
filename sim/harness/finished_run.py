"""`Run`: the estimate of a SLAM in a run that has ended, together with what the SLAM was given, and the truth."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.floors import NO_FLOOR
from lexis.maths.ties import rounded
from lexis.types import Pose
from sim.harness.estimate import Estimate
from sim.harness.scenario import Scenario
from sim.session import Session
from sim.truth import Truth, camera_positions
from worlds.house import House
from worlds.labels import STAIRS
from worlds.truth import ambiguity_at
from worlds.walkable import Walkable


class Given(NamedTuple):
    """What the SLAM was given at a frame, without the image."""

    stamp: float
    """Time stamp [s]."""
    T_O_B: Pose
    """Pose of the body in the odometry frame, from the odometry."""


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run. Arrays have one row for each frame of the estimate, unless they say otherwise."""

    scenario: Scenario
    house: House
    walkable: Walkable
    session: Session
    slam: object
    """The SLAM after its `finish`, or the `CommandSlam` of an external program. Some SLAMs also implement `PlansPaths` or
    `SavesFiles`."""
    estimate: Estimate
    given: Mapping[int, Given]
    """Input of the SLAM at every frame that it accepted; the key is `Observation.index`."""
    seconds: dict[str, float]
    """Wall times by part of the run [s]: making house and tour, building the scene, rendering, and the SLAM."""
    delivered: tuple[Truth, ...]
    """The truth of every observation that the SLAM was given, including refused ones, in the order of delivery."""
    refused: tuple[str, ...] = ()
    """Error messages with which the SLAM refused observations; always empty without faults."""

    @property
    def room_names(self) -> tuple[str, ...]:
        """The labels that rooms may have, as the SLAM was told; estimated and true labels are indices into these names."""
        return self.house.spec.room_labels

    @cached_property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Time stamps of the frames [s], as the SLAM received them."""
        return np.array([self.given[frame].stamp for frame in self.estimate.frames.tolist()])

    @cached_property
    def true_stamps(self) -> Float64[np.ndarray, "n"]:
        """True times of the frames [s], which no fault of the clock changes; see `Truth.stamp`."""
        stamps = {truth.index: truth.stamp for truth in self.delivered}
        return np.array([stamps[frame] for frame in self.estimate.frames.tolist()])

    @cached_property
    def true_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """True poses of the body in the world, `T_W_B`."""
        return np.asarray(self.session.tour.T_W_B[self.estimate.frames])

    @cached_property
    def odometry_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """Poses of the body in the odometry frame, `T_O_B`, as the SLAM received them.

        A pose that a fault has made NaN is replaced by the last finite pose before it or, if there is none, by the identity.
        """
        poses = np.array([self.given[frame].T_O_B for frame in self.estimate.frames.tolist()])
        known = np.where(np.isfinite(poses).all(axis=(1, 2)), np.arange(len(poses)), -1)
        held = np.maximum.accumulate(known)
        return np.where(held[:, None, None] < 0, np.eye(4), poses[held])

    @cached_property
    def true_rooms(self) -> Int[np.ndarray, "n"]:
        """True room of every frame, as an index into `house.rooms`."""
        return np.array([self.session.truths[frame].room for frame in self.estimate.frames.tolist()], int)

    @cached_property
    def true_labels(self) -> Int[np.ndarray, "n"]:
        """True label of every frame, as an index into `room_names`."""
        names = self.room_names
        return np.array([names.index(self.session.truths[i].label) for i in self.estimate.frames.tolist()], int)

    @cached_property
    def allowed_labels(self) -> Bool[np.ndarray, "n names"]:
        """For every frame, whether each of `room_names` counts as right in `labels.accuracy_graded`; see `ambiguity_at`."""
        rooms = ambiguity_at(self.house, camera_positions(self.true_poses, self.session.camera))
        label_of_room = np.array([self.room_names.index(room.label) for room in self.house.rooms])
        return np.stack([rooms[:, label_of_room == k].any(axis=1) for k in range(len(self.room_names))], axis=1)

    @cached_property
    def on_stairs(self) -> Bool[np.ndarray, "n"]:
        """For every frame, whether the camera is truly on stairs."""
        return np.array([self.house.rooms[room].label == STAIRS for room in self.true_rooms], bool)

    @cached_property
    def true_storeys(self) -> Int[np.ndarray, "n"]:
        """True storey of every frame, as an index into the storeys of the house, 0 for the lowest."""
        return np.array([self.session.truths[frame].storey for frame in self.estimate.frames.tolist()], int)

    @cached_property
    def true_floors(self) -> Int[np.ndarray, "n"]:
        """True number of the floor of every frame; -1 on stairs.

        Only the storeys that the walk visits are numbered, from 0 for the lowest: no SLAM can know that there is a storey
        below it on which it has never been.
        """
        visited = {truth.storey for truth in self.delivered if truth.label != STAIRS}
        return np.where(self.on_stairs, NO_FLOOR, np.searchsorted(sorted(visited), self.true_storeys))

    def most_similar(self, row: int, count: int) -> tuple[tuple[str, float], ...]:
        """Return the `count` room names most similar to the frame in a row of the estimate, with similarities, best first.

        The result is empty if the SLAM returned no similarities.
        """
        if self.estimate.similarities is None:
            return ()
        scores = self.estimate.similarities[row]
        best = np.argsort(-rounded(scores), kind="stable")[:count]
        return tuple((self.room_names[k], float(scores[k])) for k in best.tolist())

    @cached_property
    def estimated_rooms(self) -> Mapping[int, str]:
        """Name of every estimated room by its number, with its label if frames there have one: "room 4 (kitchen)"."""
        rooms, labels = self.estimate.rooms, self.estimate.named_rooms(self.room_names) or {}
        numbers = [] if rooms is None else np.unique(rooms[rooms >= 0]).tolist()
        return {number: f"room {number} ({labels[number]})" if number in labels else f"room {number}" for number in numbers}

    @cached_property
    def walked_rooms(self) -> tuple[int, ...]:
        """Rooms that the tour went through, as indices into `house.rooms`, in the order of the first visit."""
        return tuple(dict.fromkeys(truth.room for truth in self.session.truths))

    @cached_property
    def unseen_rooms(self) -> tuple[str, ...]:
        """Ids of the rooms on the tour that contain no frame of the estimate, in the order of the first visit."""
        seen = set(self.true_rooms.tolist())
        return tuple(self.house.rooms[room].id for room in self.walked_rooms if room not in seen)
