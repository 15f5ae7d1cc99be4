"""`SensedCamera`: what one camera sees along a tour, as embeddings, points and depths computed by ray casts.

The rays of many frames are cast together, which is several times faster than casting them frame by frame.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Float64

from lexis.maths.se3 import inverse
from lexis.types import NO_FEATURES, Camera, Percept, Poses
from sim.feature_sensor.ray_origins import RayGrid, cameras_at
from sim.feature_sensor.surroundings import Surroundings, survey
from sim.feature_sensor.true_view import TrueView, true_views
from sim.feature_sensor.visible_shares import COLUMNS, ROWS, VisibleShares, look
from worlds.house import House

_CHUNK = 256
"""Number of frames whose rays are cast together."""
_COLUMNS, _ROWS = np.r_[2:20:4, 21:40:4], np.r_[1:30:3]
"""Columns and rows of the 100 rays whose end points a percept contains, symmetric about the centre of the image."""
Embed = Callable[[VisibleShares, Poses], Float32[np.ndarray, "n d"]]
"""Function that computes the embeddings of views that a forward camera sees from poses of the body."""


class SensedCamera:
    """What one camera of a rig sees along a tour. Views are computed in chunks when they are needed."""

    def __init__(self, camera: Camera, first: Camera, houses: Sequence[House], T_W_B: Poses, embed: Embed) -> None:
        """`first` is the first camera of the rig.

        The feature model is fitted to the first camera of a rig. Another camera sees what the first camera would see if the
        body were turned, so the poses of this turned body are used for embeddings and for the model of loops.
        """
        self._camera, self._T_W_B, self._embed = camera, T_W_B, embed
        self._as_first = T_W_B if camera is first else T_W_B @ camera.T_B_C @ inverse(first.T_B_C)
        self._chunks = list(_chunks(houses))
        self._ends = [chunk.frames.stop for chunk in self._chunks]
        self._surroundings: dict[int, Surroundings] = {}
        self._views: dict[int, list[TrueView]] = {}
        """Views of the frames, by the number of the chunk of frames, for the chunks whose rays have been cast."""
        self._drawn: dict[int, Float32[np.ndarray, "n d"]] = {}
        """Embeddings by the number of the chunk of frames, for the chunks whose percepts have been requested."""
        self._grid = RayGrid.of(camera.intrinsics, COLUMNS, ROWS)

    def percepts(self) -> Iterator[Percept]:
        """Yield the percept of each frame. Its arrays are copies, because the SLAM may write into them."""
        for number, chunk in enumerate(self._chunks):
            if number not in self._drawn:
                self._drawn[number] = self._embed(self._look(number), self._as_first[chunk.frames])
            for embedding, points in zip(self._drawn[number], self._points(number), strict=True):
                yield Percept(embedding.copy(), NO_FEATURES, points[np.isfinite(points[:, 0])])

    def view_at(self, frame: int) -> TrueView:
        """Return the ground truth of a frame, with the pose of the body that looks in the direction of this camera."""
        number = bisect_right(self._ends, frame)
        if number not in self._views:
            self._look(number)
        first: int = self._chunks[number].frames.start
        return self._views[number][frame - first]

    def _points(self, number: int) -> Float64[np.ndarray, "n points 3"]:
        """Return end points of rays at the frames of a chunk, in the body frame [m]; NaN for rays that hit nothing."""
        frames = self._chunks[number].frames
        eyes = cameras_at(self._T_W_B[frames] @ self._camera.T_B_C, np.zeros(frames.stop - frames.start, int), self._grid)
        depths = np.stack([view.image.depth for view in self._views[number]])
        depth = depths[:, _COLUMNS][:, :, _ROWS].astype(np.float64)
        depth[~np.isfinite(depth)] = np.nan
        across = eyes.place[:, None, None] + depth[..., None] * eyes.lines[:, _COLUMNS, None]
        height = eyes.height[:, None, None] + depth * eyes.slope[:, None, _ROWS]
        ends = np.concatenate([across, height[..., None]], axis=-1).reshape(len(depth), -1, 3)
        T_B_W = inverse(self._T_W_B[frames])
        return np.asarray(ends @ np.swapaxes(T_B_W[:, :3, :3], 1, 2) + T_B_W[:, None, :3, 3])

    def _look(self, number: int) -> VisibleShares:
        """Return the visible contents at the frames of the chunk with this number."""
        chunk = self._chunks[number]
        seen = look(self._survey(chunk.house), self._T_W_B[chunk.frames], self._camera)
        self._views[number] = true_views(seen, self._T_W_B[chunk.frames], self._camera, self._as_first[chunk.frames])
        return seen

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
