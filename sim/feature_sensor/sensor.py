"""`FeatureSensor`: simulates percepts of a tour instead of rendering images, with a matching loop verifier."""

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np
from jaxtyping import Float32

from lexis.types import Camera, Features, Percept, Poses
from sim.feature_sensor.covisibility_verifier import CovisibilityVerifier, TrueView
from sim.feature_sensor.model import FeatureModel
from sim.feature_sensor.oracle import true_embeddings
from sim.feature_sensor.ray_origins import RayGrid
from sim.feature_sensor.surroundings import Surroundings, survey
from sim.feature_sensor.visible_shares import COLUMNS, ROWS, VisibleShares, look
from worlds.house import House

_STREAM = 4
"""Number of the sensor's stream among the random streams of a run's seed. Number 3 is the robot's."""
_CHUNK = 256
"""Number of frames whose rays are cast together."""
NO_FEATURES = Features(np.zeros((0, 2), np.float32), np.zeros((0, 61), np.uint8))
"""Percepts have no key points, because loops are verified by covisibility."""


class FeatureSensor:
    """Simulates percepts, which LEXIS receives instead of images. A pose in a house always gives the same percept."""

    def __init__(self, model: FeatureModel, camera: Camera, seed: int, oracle: bool = False) -> None:
        """`seed` is the seed of the run. With `oracle`, embeddings hold the ground truth; loop verification is unchanged."""
        self._model, self._camera, self._oracle = model, camera, oracle
        self._seed = (seed, _STREAM)
        self._surroundings: dict[int, tuple[House, Surroundings]] = {}

    def percepts(self, houses: Sequence[House], T_W_B: Poses) -> Iterator[Percept]:
        """Yield the percept of each frame, from the true body pose in the house as it is at that frame."""
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
        """Return the loop verifier for the tour whose percepts were simulated."""
        sights: dict[int, TrueView] = {}
        grid = RayGrid.of(self._camera.intrinsics, COLUMNS, ROWS)

        def sight_of(frame: int) -> TrueView:
            if frame not in sights:
                T_W_C = T_W_B[frame] @ self._camera.T_B_C
                views = look(self._survey(houses[frame]), T_W_B[frame : frame + 1], self._camera)
                sights[frame] = TrueView(T_W_B[frame], T_W_C, views.hits.depth[0], grid)
            return sights[frame]

        return CovisibilityVerifier(self._model.loops, sight_of, self._seed[0])

    def _embeddings(self, views: VisibleShares, T_W_B: Poses) -> Float32[np.ndarray, "n d"]:
        if self._oracle:
            return true_embeddings(views, T_W_B)
        return self._model.embedding.draw(views, T_W_B, self._seed)

    def _survey(self, house: House) -> Surroundings:
        if id(house) not in self._surroundings:
            self._surroundings[id(house)] = house, survey(house)
        return self._surroundings[id(house)][1]
