"""`FeatureSensor`: simulates percepts of a tour instead of rendering images, with a matching loop verifier.

The rays of many frames are cast together, which is several times faster than casting them frame by frame.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import groupby
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Float64

from lexis.maths.se3 import inverse
from lexis.types import Camera, Features, Percept, Poses
from sim.feature_sensor.covisibility_verifier import CovisibilityVerifier, LoopModel, TrueView
from sim.feature_sensor.model import FeatureModel
from sim.feature_sensor.oracle import true_embeddings
from sim.feature_sensor.ray_origins import RayGrid, cameras_at
from sim.feature_sensor.surroundings import Surroundings, survey
from sim.feature_sensor.visible_shares import COLUMNS, ROWS, VisibleShares, look
from worlds.house import House

_STREAM = 4
"""Number of the sensor's random stream. A run has several random streams; stream 3 is for the robot."""
_CHUNK = 256
"""Number of frames whose rays are cast together."""
NO_FEATURES = Features(np.zeros((0, 2), np.float32), np.zeros((0, 61), np.uint8))
"""The features of all simulated percepts: no key points, because loops are verified by covisibility."""
_COLUMNS, _ROWS = np.r_[2:20:4, 21:40:4], np.r_[1:30:3]
"""Columns and rows of the 100 rays whose end points a percept contains, symmetric about the centre of the image."""


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
        return self._model.embedding.draw(views, T_W_B, (self._seed, _STREAM))


class SensedTour:
    """The percepts of a tour, and a loop verifier that uses the same views. Each view is computed once."""

    def __init__(
        self,
        camera: Camera,
        houses: Sequence[House],
        T_W_B: Poses,
        embeddings: Callable[[VisibleShares, Poses], Float32[np.ndarray, "n d"]],
        loops: LoopModel,
        seed: int,
    ) -> None:
        """`embeddings(views, T_W_B)` computes the embeddings of views that are seen from body poses `T_W_B`."""
        self._camera, self._T_W_B = camera, T_W_B
        self._embeddings, self._loops, self._seed = embeddings, loops, seed
        self._chunks = list(_chunks(houses))
        self._ends = [chunk.frames.stop for chunk in self._chunks]
        self._surroundings: dict[int, Surroundings] = {}
        self._depths: dict[int, Float32[np.ndarray, "n columns rows"]] = {}
        """Depths of the rays [m], by the number of the chunk of frames, for the chunks whose rays have been cast."""
        self._drawn: dict[int, Float32[np.ndarray, "n d"]] = {}
        """Embeddings by the number of the chunk of frames, for the chunks whose percepts have been requested."""
        self._grid = RayGrid.of(camera.intrinsics, COLUMNS, ROWS)

    def percepts(self) -> Iterator[Percept]:
        """Yield the percept of each frame. Its arrays are copies, because the SLAM may write into them."""
        for number, chunk in enumerate(self._chunks):
            if number not in self._drawn:
                self._drawn[number] = self._embeddings(self._look(number), self._T_W_B[chunk.frames])
            for embedding, points in zip(self._drawn[number], self._points(number), strict=True):
                yield Percept(embedding.copy(), NO_FEATURES, points[np.isfinite(points[:, 0])])

    def verifier(self) -> CovisibilityVerifier:
        """Return the loop verifier for this tour."""

        @cache
        def view_of(frame: int) -> TrueView:
            T_W_B = np.asarray(self._T_W_B[frame])
            return TrueView(T_W_B, T_W_B @ self._camera.T_B_C, self._depth(frame), self._grid)

        return CovisibilityVerifier(self._loops, view_of, self._seed)

    def _depth(self, frame: int) -> Float32[np.ndarray, "columns rows"]:
        number = bisect_right(self._ends, frame)
        if number not in self._depths:
            self._look(number)
        return np.asarray(self._depths[number][frame - self._chunks[number].frames.start])

    def _points(self, number: int) -> Float64[np.ndarray, "n points 3"]:
        """Return end points of rays at the frames of a chunk, in the body frame [m]; NaN for rays that hit nothing."""
        frames = self._chunks[number].frames
        eyes = cameras_at(self._T_W_B[frames] @ self._camera.T_B_C, np.zeros(frames.stop - frames.start, int), self._grid)
        depth = self._depths[number][:, _COLUMNS][:, :, _ROWS].astype(np.float64)
        depth[~np.isfinite(depth)] = np.nan
        across = eyes.place[:, None, None] + depth[..., None] * eyes.lines[:, _COLUMNS, None]
        height = eyes.height[:, None, None] + depth * eyes.slope[:, None, _ROWS]
        ends = np.concatenate([across, height[..., None]], axis=-1).reshape(len(depth), -1, 3)
        T_B_W = inverse(self._T_W_B[frames])
        return np.asarray(ends @ np.swapaxes(T_B_W[:, :3, :3], 1, 2) + T_B_W[:, None, :3, 3])

    def _look(self, number: int) -> VisibleShares:
        """Return the visible contents at the frames of the chunk with this number."""
        chunk = self._chunks[number]
        views = look(self._survey(chunk.house), self._T_W_B[chunk.frames], self._camera)
        self._depths[number] = views.hits.depth
        return views

    def _survey(self, house: House) -> Surroundings:
        if id(house) not in self._surroundings:
            self._surroundings[id(house)] = survey(house)
        return self._surroundings[id(house)]


class _Chunk(NamedTuple):
    """Successive frames in an unchanged house."""

    house: House
    frames: slice


def _chunks(houses: Sequence[House]) -> Iterator[_Chunk]:
    start = 0
    for _, group in groupby(houses, key=id):
        end = start + len(list(group))
        for first in range(start, end, _CHUNK):
            yield _Chunk(houses[first], slice(first, min(first + _CHUNK, end)))
        start = end
