"""Where rays begin and which way they go: a grid of them through the image plane, and the cameras that cast them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int

from lexis.types import Intrinsics, Poses


@dataclass(frozen=True, eq=False)
class RayGrid:
    """Where rays go through the image plane, at unit depth."""

    x: Float32[np.ndarray, "columns"]
    """To the right."""
    y: Float32[np.ndarray, "rows"]
    """Down."""

    @staticmethod
    def of(intrinsics: Intrinsics, columns: int, rows: int) -> "RayGrid":
        """Rays through the middles of equal fields of the image."""
        k = intrinsics
        u = (np.arange(columns) + 0.5) * (k.width / columns) - 0.5
        v = (np.arange(rows) + 0.5) * (k.height / rows) - 0.5
        # Never exactly level: then a ray's height says where it meets any level.
        return RayGrid(((u - k.cx) / k.fx).astype(np.float32), ((v - k.cy) / k.fy + 1e-4).astype(np.float32))

    @property
    def size(self) -> int:
        """Rays in all."""
        return len(self.x) * len(self.y)


@dataclass(frozen=True, eq=False)
class UprightCameras:
    """Upright cameras."""

    place: Float32[np.ndarray, "k 2"]
    height: Float32[np.ndarray, "k"]
    ahead: Float32[np.ndarray, "k 2"]
    """Unit vectors in the plan."""
    lines: Float32[np.ndarray, "k columns 2"]
    """Direction of every column in the plan, at unit depth."""
    slope: Float32[np.ndarray, "k rows"]
    """Rise of every row at unit depth; never zero."""
    storey: Int[np.ndarray, "k"]

    @property
    def right(self) -> Float32[np.ndarray, "k 2"]:
        """Unit vectors in the plan, square to `ahead`."""
        return _right_of(self.ahead)


def cameras_at(T_W_C: Poses, storeys: Int[np.ndarray, "k"], grid: RayGrid) -> UprightCameras:
    """The cameras at `T_W_C`. Roll is left out, pitch shifts the rows."""
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
