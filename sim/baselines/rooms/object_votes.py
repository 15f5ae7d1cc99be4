"""`ObjectVotes`: names the rooms of a segmentation by the objects in them, as Hydra does (Hughes et al., IJRR 2024)."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Int

from lexis.types import Camera, Observation
from sim.baselines.rooms.map_rooms import MapRooms, MapSegmentation
from sim.baselines.rooms.object_scores import ObjectScores
from sim.harness.estimate import Estimate
from sim.harness.scenario import Scenario
from worlds.labels import STAIRS
from worlds.truth import objects

UNNAMED = -1
"""Label of rooms without any object."""
_NO_OBJECTS = ("door", "window")


class ObjectVotes:
    """Returns the rooms of a segmentation of the true map, and labels them by a vote of the true objects in them.

    Every category of furniture that stands in a room votes once, with its scores for the room names. A keyframe gets the
    label of its room. The baseline is given the true position and category of all objects of the house, seen or not; the
    true stairs have their label from the start, and no other room may be called stairs.
    """

    def __init__(self, rooms: MapRooms, scores: ObjectScores) -> None:
        """Prepare a run of the scenario of `rooms`."""
        self._rooms, self._scores = rooms, scores
        self._names: tuple[str, ...] = ()

    @staticmethod
    def of(scenario: Scenario, segmentation: MapSegmentation, scores: ObjectScores) -> "ObjectVotes":
        """Prepare a run of a scenario. Raises `WorldsError` or `SimError` if the scenario is impossible."""
        return ObjectVotes(MapRooms.of(scenario, segmentation), scores)

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run. The camera is ignored."""
        self._rooms.start(camera, room_names)
        self._names = tuple(room_names)

    def process(self, observation: Observation) -> None:
        """Note the number of the observation if it is a keyframe."""
        self._rooms.process(observation)

    def finish(self) -> Estimate:
        """Return rooms, labels and floors of all keyframes. Raises `SimError` without observations."""
        estimate = self._rooms.finish()
        assert estimate.rooms is not None
        labels = self.labels
        stairs = self._names.index(STAIRS) if STAIRS in self._names else UNNAMED
        # `MapRooms` numbers the staircases after the segments.
        return replace(estimate, labels=np.append(labels, stairs)[np.minimum(estimate.rooms, len(labels))])

    @property
    def labels(self) -> Int[np.ndarray, "segments"]:
        """Label of every segment, from segment 0, which is none; as an index into the names of rooms."""
        rooms = [name for name in self._names if name != STAIRS]
        categories, present = self._present
        if not rooms or not categories:
            return np.full(len(present), UNNAMED)
        votes = present @ self._scores.scores(categories, rooms)
        index = np.array([self._names.index(name) for name in rooms])
        return np.where(present.any(axis=1), index[votes.argmax(axis=1)], UNNAMED)

    @cached_property
    def _present(self) -> tuple[Counter[str], Bool[np.ndarray, "segments categories"]]:
        """Number of pieces of furniture by category, and whether each segment contains each category."""
        pieces = [each for each in objects(self._rooms.map.house) if each.kind not in _NO_OBJECTS]
        categories = Counter(piece.kind for piece in pieces)
        count = int(self._rooms.segments.max(initial=0)) + 1
        present = np.zeros((count, len(categories)), bool)
        if pieces:
            at = self._rooms.map.rooms_at(self._rooms.segments, np.array([piece.centre for piece in pieces]))
            column = np.array([list(categories).index(piece.kind) for piece in pieces])
            present[at[at < count], column[at < count]] = True
        return categories, present
