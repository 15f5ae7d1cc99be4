"""Finds, in the floor plan, the blocks (upright boxes) that each image column crosses, and the depths of entry and exit."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32, Int

from sim.feature_sensor.ray_origins import RayGrid, UprightCameras
from sim.feature_sensor.surroundings import Blocks

NEAR_M = 0.05
"""Least distance of a block in front of the camera [m]. Nearer blocks are ignored, as if the camera were inside them."""
FAR_M = np.float32(200.0)
"""Depth of rays that hit nothing [m]."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """One row for each block that an image column crosses, sorted by camera and column."""

    camera: Int[np.ndarray, "h"]
    column: Int[np.ndarray, "h"]
    block: Int[np.ndarray, "h"]
    near: Float32[np.ndarray, "h"]
    """Depth at which the column's line in the plan enters the block [m]."""
    far: Float32[np.ndarray, "h"]
    """Depth at which the column's line leaves the block [m]."""


class BlockFootprints:
    """The footprints of blocks (upright boxes) in the floor plan, for intersection with image columns."""

    def __init__(self, blocks: Blocks, tall: Bool[np.ndarray, "b"], grid: RayGrid) -> None:
        """`tall` marks the blocks that reach from floor to ceiling and occlude everything behind them."""
        self._blocks, self._tall, self._grid = blocks, tall, grid
        self._corners = _corners(blocks)
        self._axes = np.cos(blocks.yaw), np.sin(blocks.yaw)

    def cross(self, eyes: UprightCameras) -> Crossings:
        """Return the blocks that each image column of each camera crosses, up to the first tall block."""
        camera, block, first, count = self._spanned(eyes)
        pair = np.repeat(np.arange(len(camera)), count)
        column = np.arange(len(pair)) - np.repeat(np.cumsum(count) - count - first, count)
        camera, block = camera[pair], block[pair]
        near, far = self._through(block, eyes.place[camera], eyes.lines[camera, column])
        columns = len(self._grid.x)
        ray = camera * columns + column
        met = far > np.maximum(near, NEAR_M)
        wall = np.full(len(eyes.place) * columns, FAR_M)
        # A tall block occludes nothing if the camera is inside it.
        shut = met & self._tall[block] & (near > 0.0)
        np.minimum.at(wall, ray[shut], near[shut])
        kept = np.flatnonzero(met & (near <= wall[ray]))
        kept = kept[np.argsort(ray[kept], kind="stable")]
        return Crossings(camera[kept], column[kept], block[kept], np.maximum(near[kept], np.float32(0.0)), far[kept])

    def _spanned(self, eyes: UprightCameras) -> tuple[Int[np.ndarray, "p"], ...]:
        """Return pairs of a camera and a block that may be in the camera's image.

        The four arrays hold the camera, the block, the first image column and the number of image columns of each pair.
        """
        offset = self._corners[None] - eyes.place[:, None, None]
        depth = np.einsum("kbcj,kj->kbc", offset, eyes.ahead)
        side = np.einsum("kbcj,kj->kbc", offset, eyes.right)
        x, last = self._grid.x, len(self._grid.x) - 1
        at = (side / np.maximum(depth, NEAR_M) - x[0]) / (x[1] - x[0])
        beside = depth.min(axis=2) < NEAR_M  # part of the block is behind the camera, so it may be in any column
        first = np.where(beside, 0, np.ceil(at.min(axis=2)).clip(0, last + 1)).astype(int)
        end = np.where(beside, last, np.floor(at.max(axis=2)).clip(-1, last)).astype(int)
        seen = (depth.max(axis=2) > NEAR_M) & (end >= first)
        camera, block = np.nonzero(seen)
        return camera, block, first[seen], (end - first + 1)[seen]

    def _through(
        self, block: Int[np.ndarray, "h"], place: Float32[np.ndarray, "h 2"], line: Float32[np.ndarray, "h 2"]
    ) -> tuple[Float32[np.ndarray, "h"], Float32[np.ndarray, "h"]]:
        """Return the depths at which lines enter and leave blocks (slab method).

        For a line that misses its block, the depth of entry is larger than the depth of exit.
        """
        cos, sin = (values[block] for values in self._axes)
        offset, half = place - self._blocks.centre[block], self._blocks.half[block]
        near, far = np.full(len(block), -np.inf, np.float32), np.full(len(block), np.inf, np.float32)
        for axis, (a, b) in enumerate(((cos, sin), (-sin, cos))):
            start = a * offset[:, 0] + b * offset[:, 1]
            along = a * line[:, 0] + b * line[:, 1]
            along = np.where(np.abs(along) < 1e-9, np.float32(1e-9), along)
            middle, reach = -start / along, np.abs(half[:, axis] / along)
            near, far = np.maximum(near, middle - reach), np.minimum(far, middle + reach)
        return near, far


def _corners(blocks: Blocks) -> Float32[np.ndarray, "b 4 2"]:
    cos, sin = np.cos(blocks.yaw), np.sin(blocks.yaw)
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], np.float32)
    local = signs[None] * blocks.half[:, None]
    x = cos[:, None] * local[..., 0] - sin[:, None] * local[..., 1]
    y = sin[:, None] * local[..., 0] + cos[:, None] * local[..., 1]
    return np.asarray(blocks.centre[:, None] + np.stack([x, y], axis=-1), np.float32)
