"""Origins and directions of rays: a grid of rays through the image plane, and the upright cameras that cast them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int

from lexis.types import Intrinsics, Poses


@dataclass(frozen=True, eq=False)
class RayGrid:
    """A grid of rays, given by their points of intersection with the image plane at unit depth."""

    x: Float32[np.ndarray, "columns"]
    """Horizontal coordinates of the ray columns on the image plane at unit depth, positive to the right."""
    y: Float32[np.ndarray, "rows"]
    """Vertical coordinates of the ray rows on the image plane at unit depth, positive downwards."""

    @staticmethod
    def of(intrinsics: Intrinsics, columns: int, rows: int) -> "RayGrid":
        """Divide the image into equal cells and make a ray through the centre of each cell."""
        k = intrinsics
        u = (np.arange(columns) + 0.5) * (k.width / columns) - 0.5
        v = (np.arange(rows) + 0.5) * (k.height / rows) - 0.5
        # The offset keeps rays from being exactly level, so that each ray meets the level of a floor or ceiling at a finite
        # depth.
        return RayGrid(((u - k.cx) / k.fx).astype(np.float32), ((v - k.cy) / k.fy + 1e-4).astype(np.float32))

    @property
    def size(self) -> int:
        """Number of rays."""
        return len(self.x) * len(self.y)


@dataclass(frozen=True, eq=False)
class UprightCameras:
    """Positions and ray directions of upright cameras, split into horizontal and vertical parts."""

    place: Float32[np.ndarray, "k 2"]
    """Horizontal position of each camera in W [m]."""
    height: Float32[np.ndarray, "k"]
    """Height of the camera in W [m]."""
    ahead: Float32[np.ndarray, "k 2"]
    """Horizontal direction of view of each camera, as a unit vector in W."""
    lines: Float32[np.ndarray, "k columns 2"]
    """Horizontal direction of the rays of each image column, scaled to unit depth."""
    slope: Float32[np.ndarray, "k rows"]
    """Rise of the rays of each image row, per unit of depth; never zero."""
    storey: Int[np.ndarray, "k"]
    """Index of the storey that holds the camera."""

    @property
    def right(self) -> Float32[np.ndarray, "k 2"]:
        """Horizontal unit vector to the right of each camera, perpendicular to `ahead`."""
        return _right_of(self.ahead)


def cameras_at(T_W_C: Poses, storeys: Int[np.ndarray, "k"], grid: RayGrid) -> UprightCameras:
    """Return upright cameras that approximate cameras at `T_W_C`.

    Roll is ignored, and pitch only changes the slopes of the rays.
    """
    axis = T_W_C[:, :3, 2]
    level = np.linalg.norm(axis[:, :2], axis=1, keepdims=True)
    ahead = (axis[:, :2] / np.maximum(level, 1e-9)).astype(np.float32)
    lines = ahead[:, None] + grid.x[:, None] * _right_of(ahead)[:, None]
    rise = (axis[:, 2] / np.maximum(level[:, 0], 1e-9)).astype(np.float32)
    slope = rise[:, None] - grid.y
    slope[slope == 0.0] = 1e-6
    place = T_W_C[:, :3, 3].astype(np.float32)
    return UprightCameras(place[:, :2], place[:, 2], ahead, lines, slope, storeys)


def _right_of(ahead: Float32[np.ndarray, "k 2"]) -> Float32[np.ndarray, "k 2"]:
    return np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
