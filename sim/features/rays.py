"""Rays from cameras to the nearest surface, for many cameras at once, in numpy and without pixels.

The camera stands upright, so that all rays of an image column stand over one line in the plan. What that line crosses is
found in the plan (2-D), and only then how high each ray of the column is there. Roll is left out, pitch shifts the rows.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int

from lexis.types import Intrinsics, Poses
from sim.features.surroundings import SURFACES, Blocks, Surroundings, is_stairs
from worlds.truth import NOWHERE, floor_at, room_at

WALL, FLOOR, CEILING = range(len(SURFACES))
_NEAR_M = 0.05
_FAR_M = np.float32(200.0)
_NUDGE_M = 0.02
"""Towards the camera, when the room of a hit is looked up: a wall's face is half a wall away from where rooms meet."""
_RANK = 0xFF
"""Bits of a depth that make way for which of the blocks in a column it belongs to: 3e-5 of it."""
_CHUNK = 48
"""Cameras at once: their arrays should fit into the cache."""


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
class Hits:
    """What rays meet first."""

    depth: Float32[np.ndarray, "n columns rows"]
    """Along the optical axis [m]; infinite where there is nothing."""
    thing: Int[np.ndarray, "n columns rows"]
    """Row of `Surroundings.names`, or `NOWHERE`."""


@dataclass(frozen=True, eq=False)
class _Eyes:
    """Cameras in one room."""

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
        return np.stack([self.ahead[:, 1], -self.ahead[:, 0]], axis=1)


def cast(around: Surroundings, T_W_C: Poses, grid: RayGrid) -> Hits:
    """Cast the rays of cameras at `T_W_C`."""
    n, shape = len(T_W_C), (len(grid.x), len(grid.y))
    hits = Hits(np.full((n, *shape), np.inf, np.float32), np.full((n, *shape), NOWHERE))
    rooms, storeys = room_at(around.house, T_W_C[:, :3, 3]), floor_at(around.house, T_W_C[:, :3, 3])
    for room in np.unique(rooms[rooms != NOWHERE]).tolist():
        caster = _Caster(around, room, grid)
        members = np.flatnonzero(rooms == room)
        for start in range(0, len(members), _CHUNK):
            rows = members[start : start + _CHUNK]
            hits.depth[rows], hits.thing[rows] = caster.cast(_eyes(T_W_C[rows], storeys[rows], grid))
    return hits


def _eyes(T_W_C: Poses, storeys: Int[np.ndarray, "k"], grid: RayGrid) -> _Eyes:
    axis = T_W_C[:, :3, 2]
    level = np.linalg.norm(axis[:, :2], axis=1, keepdims=True)
    ahead = (axis[:, :2] / np.maximum(level, 1e-9)).astype(np.float32)
    right = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
    lines = ahead[:, None] + grid.x[:, None] * right[:, None]
    rise = (axis[:, 2] / np.maximum(level[:, 0], 1e-9)).astype(np.float32)
    slope = rise[:, None] - grid.y
    slope[slope == 0.0] = 1e-6
    place = T_W_C[:, :3, 3].astype(np.float32)
    return _Eyes(place[:, :2], place[:, 2], ahead, lines, slope, storeys)


class _Caster:
    """Casts from within one room: only blocks that reach into its height can be met."""

    def __init__(self, around: Surroundings, room: int, grid: RayGrid) -> None:
        self._around, self._grid = around, grid
        own, house = around.house.rooms[room], around.house
        z = around.blocks.z
        low, high = own.floor_m, np.inf if own.outdoor else own.ceiling_m
        self._blocks = around.blocks[(z[:, 0] < high - 0.01) & (z[:, 1] > low + 0.01)]
        self._tall = (self._blocks.z[:, 0] < low + 0.01) & (self._blocks.z[:, 1] > min(high, low + 20.0) - 0.01)
        self._level = None if is_stairs(house, room) else (low, high)
        self._floors = np.array([storey.floor_m for storey in house.storeys], np.float32)
        self._ceilings = np.array([storey.ceiling_m for storey in house.storeys], np.float32)
        self._outdoor = np.array([each.outdoor for each in house.rooms] + [True])
        self._corners = _corners(self._blocks)

    def cast(self, eyes: _Eyes) -> tuple[Float32[np.ndarray, "k columns rows"], Int[np.ndarray, "k columns rows"]]:
        """Depths and things."""
        camera, column, block, near, far = self._crossed(eyes)
        depth, owner = self._nearest(eyes, camera, column, block, near, far)
        return self._with_levels(eyes, depth, owner)

    def _crossed(self, eyes: _Eyes) -> tuple[np.ndarray, ...]:
        """In the plan: which columns cross which blocks, from what depth to what depth; none of them behind a wall."""
        camera, block, first, count = self._spanned(eyes)
        pair = np.repeat(np.arange(len(camera)), count)
        column = np.arange(len(pair)) - np.repeat(np.cumsum(count) - count - first, count)
        camera, block = camera[pair], block[pair]
        near, far = _through(self._blocks, block, eyes.place[camera], eyes.lines[camera, column])
        ray = camera * len(self._grid.x) + column
        met = far > np.maximum(near, _NEAR_M)
        behind = np.full(len(eyes.place) * len(self._grid.x), _FAR_M)
        closed = met & self._tall[block] & (near > 0.0)
        np.minimum.at(behind, ray[closed], near[closed])
        met &= near <= behind[ray]
        return camera[met], column[met], block[met], np.maximum(near[met], 0.0), far[met]

    def _spanned(self, eyes: _Eyes) -> tuple[np.ndarray, ...]:
        """(camera, block, first column, number of columns) of every block that may be in the image."""
        offset = self._corners[None] - eyes.place[:, None, None]
        depth = np.einsum("kbcj,kj->kbc", offset, eyes.ahead)
        side = np.einsum("kbcj,kj->kbc", offset, eyes.right)
        crossing = depth.min(axis=2) < _NEAR_M
        at = side / np.maximum(depth, _NEAR_M)
        x, last = self._grid.x, len(self._grid.x) - 1
        step = x[1] - x[0]
        first = np.where(crossing, 0, np.ceil((at.min(axis=2) - x[0]) / step).clip(0, last + 1)).astype(int)
        end = np.where(crossing, last, np.floor((at.max(axis=2) - x[0]) / step).clip(-1, last)).astype(int)
        seen = (depth.max(axis=2) > _NEAR_M) & (end >= first)
        camera, block = np.nonzero(seen)
        return camera, block, first[seen], (end - first + 1)[seen]

    def _nearest(
        self, eyes: _Eyes, camera: np.ndarray, column: np.ndarray, block: np.ndarray, near: np.ndarray, far: np.ndarray
    ) -> tuple[Float32[np.ndarray, "k columns rows"], Int[np.ndarray, "k columns rows"]]:
        """Depth of the first block on every ray, and which it is (-1: none)."""
        shape = len(eyes.place), len(self._grid.x), len(self._grid.y)
        depth, owner = np.full(shape, np.inf, np.float32), np.full(shape, -1)
        if not len(camera):
            return depth, owner
        order = np.argsort(camera * shape[1] + column, kind="stable")
        camera, column, block, near, far = (values[order] for values in (camera, column, block, near, far))
        ray = camera * shape[1] + column
        starts = np.flatnonzero(np.diff(ray, prepend=-1))
        rank = np.arange(len(ray)) - np.repeat(starts, np.diff(starts, append=len(ray)))
        enter = self._entered(eyes, camera, block, near, far)
        packed = np.minimum.reduceat(
            (enter.view(np.int32) & ~_RANK) | np.minimum(rank, _RANK)[:, None].astype(np.int32), starts
        )
        found = (packed & ~_RANK).view(np.float32)
        which = block[starts[:, None] + (packed & _RANK)]
        rows = camera[starts], column[starts]
        depth[rows] = np.where(found < _FAR_M * 0.99, found, np.inf)
        owner[rows] = np.where(found < _FAR_M * 0.99, which, -1)
        return depth, owner

    def _entered(
        self, eyes: _Eyes, camera: np.ndarray, block: np.ndarray, near: np.ndarray, far: np.ndarray
    ) -> Float32[np.ndarray, "h rows"]:
        """Depth at which every ray of a column enters a block that the column crosses; `_FAR_M` where it passes by."""
        level = (self._blocks.z[block] - eyes.height[camera, None])[:, :, None] / eyes.slope[camera, None, :]
        enter = np.maximum(level.min(axis=1), near[:, None])
        return np.where((enter <= np.minimum(level.max(axis=1), far[:, None])) & (enter > _NEAR_M), enter, _FAR_M)

    def _with_levels(
        self, eyes: _Eyes, depth: Float32[np.ndarray, "k columns rows"], owner: Int[np.ndarray, "k columns rows"]
    ) -> tuple[Float32[np.ndarray, "k columns rows"], Int[np.ndarray, "k columns rows"]]:
        """Floors and ceilings where nothing is before them; then things instead of blocks."""
        floor, ceiling = self._floors[eyes.storey], self._ceilings[eyes.storey]
        if self._level is not None:
            floor, ceiling = (np.full_like(floor, level) for level in self._level)
        down = eyes.slope < 0.0
        plane = (np.where(down, floor[:, None], ceiling[:, None]) - eyes.height[:, None]) / eyes.slope
        plane = np.maximum(plane, _NEAR_M)[:, None, :]
        on_plane = plane < depth
        depth = np.minimum(depth, plane)
        reach = np.minimum(depth, _FAR_M) - _NUDGE_M
        places = eyes.place[:, None, None] + reach[..., None] * eyes.lines[:, :, None]
        room = self._around.rooms_at.at(eyes.storey[:, None, None], places)
        surface = np.where(on_plane, np.where(down, FLOOR, CEILING)[:, None], WALL)
        thing = np.where(room == NOWHERE, NOWHERE, len(SURFACES) * room + surface)
        hit = owner >= 0
        of_block = np.where(hit, self._blocks.thing[owner], NOWHERE) if len(self._blocks.thing) else owner
        thing = np.where(on_plane | (of_block == NOWHERE), thing, of_block)
        sky = (on_plane & ~down[:, None] & self._outdoor[room]) | ~np.isfinite(depth)
        return np.where(sky, np.inf, depth).astype(np.float32), np.where(sky, NOWHERE, thing)


def _corners(blocks: Blocks) -> Float32[np.ndarray, "b 4 2"]:
    cos, sin = np.cos(blocks.yaw), np.sin(blocks.yaw)
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], np.float32)
    local = signs[None] * blocks.half[:, None]
    x = cos[:, None] * local[..., 0] - sin[:, None] * local[..., 1]
    y = sin[:, None] * local[..., 0] + cos[:, None] * local[..., 1]
    return np.asarray(blocks.centre[:, None] + np.stack([x, y], axis=-1), np.float32)


def _through(
    blocks: Blocks, block: Int[np.ndarray, "h"], place: Float32[np.ndarray, "h 2"], line: Float32[np.ndarray, "h 2"]
) -> tuple[Float32[np.ndarray, "h"], Float32[np.ndarray, "h"]]:
    """Depths at which lines in the plan enter and leave the sides of blocks; entered after left where they miss."""
    cos, sin = np.cos(blocks.yaw)[block], np.sin(blocks.yaw)[block]
    offset, half = place - blocks.centre[block], blocks.half[block]
    near, far = np.full(len(block), -np.inf, np.float32), np.full(len(block), np.inf, np.float32)
    for axis, (a, b) in enumerate(((cos, sin), (-sin, cos))):
        start = a * offset[:, 0] + b * offset[:, 1]
        along = a * line[:, 0] + b * line[:, 1]
        along = np.where(np.abs(along) < 1e-9, np.float32(1e-9), along)
        middle, reach = -start / along, np.abs(half[:, axis] / along)
        near, far = np.maximum(near, middle - reach), np.minimum(far, middle + reach)
    return near, far
