"""`FeatureSensor`: simulates percepts of a tour instead of rendering images, with a matching loop verifier."""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float32

from lexis.types import Camera, Percept, Poses
from sim.feature_sensor.covisibility_verifier import CovisibilityVerifier, LoopModel
from sim.feature_sensor.model import FeatureModel
from sim.feature_sensor.oracle import true_embeddings
from sim.feature_sensor.sensed_camera import Embed, SensedCamera
from sim.feature_sensor.true_view import TrueView
from sim.feature_sensor.visible_shares import VisibleShares
from sim.random_streams import RandomStream
from worlds.house import House


class FeatureSensor:
    """Simulates percepts, which LEXIS receives instead of images. The percepts at equal poses in a house are equal."""

    def __init__(self, model: FeatureModel, camera: Camera, seed: int, oracle: bool = False) -> None:
        """`seed` is the seed of the run. With `oracle`, embeddings hold the ground truth; loop verification is unchanged."""
        self._model, self._camera, self._seed = model, camera, seed
        self._oracle = oracle

    def tour(self, houses: Sequence[House], T_W_B: Poses) -> "SensedTour":
        """Return the percepts and the loop verifier of a tour along the true body poses `T_W_B`.

        `houses[i]` is the house at frame i, since furniture may be moved during a tour.
        """
        return SensedTour(self._camera, houses, T_W_B, self._embeddings, self._model.loops, self._seed)

    def _embeddings(self, views: VisibleShares, T_W_B: Poses) -> Float32[np.ndarray, "n d"]:
        if self._oracle:
            return true_embeddings(views, T_W_B)
        return self._model.embedding.draw(views, T_W_B, (self._seed, RandomStream.PERCEPTS))


class SensedTour:
    """The percepts of a tour by all cameras of a rig, and a loop verifier that uses the same views."""

    def __init__(
        self, camera: Camera, houses: Sequence[House], T_W_B: Poses, embed: Embed, loops: LoopModel, seed: int
    ) -> None:
        self._cameras = [SensedCamera(each, camera, houses, T_W_B, embed) for each in camera.rig]
        self._loops, self._seed = loops, seed

    def percepts(self) -> Iterator[tuple[Percept, ...]]:
        """Yield the percepts of all cameras for each frame. Their arrays are copies: the SLAM may write into them."""
        return zip(*(camera.percepts() for camera in self._cameras), strict=True)

    def verifier(self) -> CovisibilityVerifier:
        """Return the loop verifier for this tour."""

        def views_of(frame: int) -> tuple[TrueView, ...]:
            return tuple(camera.view_at(frame) for camera in self._cameras)

        return CovisibilityVerifier(self._loops, views_of, self._seed)
