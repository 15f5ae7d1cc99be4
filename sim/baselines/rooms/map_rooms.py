"""`MapRooms`: the adapter by which the harness runs a segmentation of the true map."""

from collections.abc import Sequence
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Int

from lexis.config import KeyframeConfig
from lexis.errors import ObservationError
from lexis.keyframes import KeyframeSelector
from lexis.types import Camera, Observation
from sim.baselines.rooms.cells import Free, Segments
from sim.baselines.rooms.true_map import TrueMap
from sim.errors import SimError
from sim.harness.estimate import Estimate
from sim.harness.scenario import Scenario
from sim.harness.walk import Walk, walk


@runtime_checkable
class MapSegmentation(Protocol):
    """Interface of a method that divides the free cells of a storey into rooms."""

    def segments(self, free: Free, resolution_m: float) -> Segments:
        """Return the segment of every free cell, from 1; 0 for cells that are not free."""


class MapRooms:
    """Returns the rooms that a segmentation finds in the true map, at the true positions of LEXIS's keyframes.

    Unlike a SLAM, this baseline is given the true walls, the true stairs and the true poses, so that no error but the
    segmentation's own counts. It estimates rooms and floors, but neither poses nor labels. Keyframes are selected
    by odometry as LEXIS selects them, so that figures of both are about the same frames.
    """

    def __init__(self, walked: Walk, segmentation: MapSegmentation) -> None:
        """Prepare a run of the walk's scenario, whose house and poses are the truth that the baseline is given."""
        self._walk, self._segmentation = walked, segmentation
        self._begin()

    @staticmethod
    def of(scenario: Scenario, segmentation: MapSegmentation) -> "MapRooms":
        """Prepare a run of a scenario. Raises `WorldsError` or `SimError` if the scenario is impossible."""
        return MapRooms(walk(scenario), segmentation)

    @cached_property
    def map(self) -> TrueMap:
        """The true map."""
        return TrueMap.of(self._walk.house)

    @cached_property
    def segments(self) -> Int[np.ndarray, "storeys nx ny"]:
        """Segment of every cell of the true map."""
        return self.map.segmented(self._segmentation.segments)

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run. The camera and the names of rooms are ignored."""
        self._begin()

    def _begin(self) -> None:
        self._selector = KeyframeSelector(KeyframeConfig())
        self._frames: list[int] = []
        self._last = -1

    def process(self, observation: Observation) -> None:
        """Note the number of the observation if it is a keyframe.

        Raises `ObservationError` for a pose that is not finite, or an observation that comes before an earlier one.
        """
        if not np.isfinite(observation.T_O_B).all():
            raise ObservationError(f"observation {observation.index}: T_O_B is not finite; valid: a rigid motion")
        if observation.index <= self._last:
            raise ObservationError(f"observation {observation.index} comes after {self._last}; valid: ascending numbers")
        self._last = observation.index
        frame = self._selector.select(observation)
        if frame is not None and frame.is_keyframe:
            self._frames.append(observation.index)

    def finish(self) -> Estimate:
        """Return rooms and floors of all keyframes. Raises `SimError` without observations."""
        if not self._frames:
            raise SimError("MapRooms: was given no observation; valid: one or more")
        frames = np.array(self._frames)
        points = self._walk.tour.T_W_B[frames, :3, 3]
        return Estimate(frames, rooms=self.map.rooms_at(self.segments, points), floors=self.map.floors_at(points))
