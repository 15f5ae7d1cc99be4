"""`FeatureSensor`: percepts of a tour instead of images, and the verifier that belongs to them."""

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np
from jaxtyping import Float32

from lexis.types import Camera, Features, Percept, Poses
from sim.feature_sensor.covisibility_verifier import CovisibilityVerifier, Sight
from sim.feature_sensor.model import FeatureModel
from sim.feature_sensor.oracle import true_embeddings
from sim.feature_sensor.ray_origins import RayGrid
from sim.feature_sensor.surroundings import Surroundings, survey
from sim.feature_sensor.visible_shares import COLUMNS, ROWS, VisibleShares, look
from worlds.house import House

_STREAM = 4
"""Of the sensor among the streams that a run's seed spawns; 3 is the robot's."""
_CHUNK = 256
"""Frames that are looked at together."""
NO_FEATURES = Features(np.zeros((0, 2), np.float32), np.zeros((0, 61), np.uint8))
"""Loops are verified by covisibility, not by key points."""


class FeatureSensor:
    """What LEXIS is given in the place of images. The same pose in the same house looks the same, whenever it is."""

    def __init__(self, model: FeatureModel, camera: Camera, seed: int, oracle: bool = False) -> None:
        """`seed` is the run's. As an `oracle` it tells the truth of views; loops are verified as ever."""
        self._model, self._camera, self._oracle = model, camera, oracle
        self._seed = (seed, _STREAM)
        self._surroundings: dict[int, tuple[House, Surroundings]] = {}

    def percepts(self, houses: Sequence[House], T_W_B: Poses) -> Iterator[Percept]:
        """A percept of every frame: of the house as it then is, from where the body truly is."""
        start = 0
        for _, group in groupby(houses, key=id):
            end = start + len(list(group))
            for first in range(start, end, _CHUNK):
                poses = T_W_B[first : min(first + _CHUNK, end)]
                views = look(self._survey(houses[first]), poses, self._camera)
                for embedding in self._embeddings(views, poses):
                    yield Percept(embedding, NO_FEATURES)
            start = end

    def verifier(self, houses: Sequence[House], T_W_B: Poses) -> CovisibilityVerifier:
        """Verifies the loops of the same tour."""
        sights: dict[int, Sight] = {}

        def sight_of(frame: int) -> Sight:
            if frame not in sights:
                T_W_C = T_W_B[frame] @ self._camera.T_B_C
                views = look(self._survey(houses[frame]), T_W_B[frame : frame + 1], self._camera)
                sights[frame] = Sight(T_W_B[frame], T_W_C, views.hits.depth[0])
            return sights[frame]

        grid = RayGrid.of(self._camera.intrinsics, COLUMNS, ROWS)
        return CovisibilityVerifier(self._model.loops, sight_of, grid, self._seed[0])

    def _embeddings(self, views: VisibleShares, T_W_B: Poses) -> Float32[np.ndarray, "n d"]:
        if self._oracle:
            return true_embeddings(views, T_W_B)
        return self._model.embedding.draw(views, T_W_B, self._seed)

    def _survey(self, house: House) -> Surroundings:
        if id(house) not in self._surroundings:
            self._surroundings[id(house)] = house, survey(house)
        return self._surroundings[id(house)][1]
