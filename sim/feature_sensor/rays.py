"""Casts rays from many cameras at once to the nearest surface, in numpy and without rendering.

Cameras are approximated as upright, so that all rays of an image column lie above the same line in the floor plan.

1. Find in the floor plan the blocks (upright boxes) that the line of each column crosses (`crossings`).
2. For each ray of the column, compute from the ray's slope which of the blocks the ray hits first.
3. If the ray hits the floor or ceiling before any block, take this hit instead.
4. Look up the room at hits on walls, floors and ceilings.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int

from lexis.types import Poses
from sim.feature_sensor.crossings import FAR_M, NEAR_M, BlockFootprints, Crossings
from sim.feature_sensor.ray_origins import RayGrid, UprightCameras, cameras_at
from sim.feature_sensor.surroundings import Surroundings
from worlds.labels import STAIRS
from worlds.truth import NOWHERE, floor_at, room_at
from worlds.visuals.surfaces import SURFACE_KINDS

WALL, FLOOR, CEILING = range(len(SURFACE_KINDS))
_NUDGE_M = 0.02
"""Distance by which a hit is moved towards the camera, in front of the wall, before its room is looked up [m]."""
_RANK = 0xFF
"""Mask of the lowest bits of a depth, a 32-bit float. The rank of a block among the blocks of its column replaces these
bits, which changes the depth by at most 3e-5 of its value."""
_CHUNK = 48
"""Number of cameras that are processed at once, so that their arrays fit into the cache."""
_TOLERANCE_M = 0.01
_TALL_M = 20.0
"""Outdoors, where there is no ceiling, a block counts as tall from this height above the floor [m]. No real block is that
high."""

Depths = Float32[np.ndarray, "k columns rows"]
Rows = Int[np.ndarray, "k columns rows"]


@dataclass(frozen=True, eq=False)
class Hits:
    """The first hit of each ray."""

    depth: Float32[np.ndarray, "n columns rows"]
    """Horizontal distance along the direction of view [m], the depth of an upright camera; infinite if nothing is hit."""
    thing: Int[np.ndarray, "n columns rows"]
    """The thing (surface or object) that each ray hits, as an index into `Surroundings.names`; `NOWHERE` if none."""
    rooms: Int[np.ndarray, "n"]
    """The room of each camera, as an index into `House.rooms`; `NOWHERE` outside of all rooms."""


def cast(around: Surroundings, T_W_C: Poses, grid: RayGrid) -> Hits:
    """Cast the rays of cameras at `T_W_C` and return the first hits. Rays of a camera that is in no room hit nothing."""
    n, shape = len(T_W_C), (len(grid.x), len(grid.y))
    rooms, storeys = room_at(around.house, T_W_C[:, :3, 3]), floor_at(around.house, T_W_C[:, :3, 3])
    hits = Hits(np.full((n, *shape), np.inf, np.float32), np.full((n, *shape), NOWHERE), rooms)
    for room in np.unique(rooms[rooms != NOWHERE]).tolist():
        caster = _Caster(around, room, grid)
        members = np.flatnonzero(rooms == room)
        for start in range(0, len(members), _CHUNK):
            rows = members[start : start + _CHUNK]
            hits.depth[rows], hits.thing[rows] = caster.cast(cameras_at(T_W_C[rows], storeys[rows], grid))
    return hits


class _Caster:
    """Casts rays of cameras in one room. Only blocks that overlap the room's range of heights can be hit."""

    def __init__(self, around: Surroundings, room: int, grid: RayGrid) -> None:
        own, house = around.house.rooms[room], around.house
        low, high = own.floor_m, np.inf if own.outdoor else own.ceiling_m
        z = around.blocks.z
        self._around, self._shape = around, (len(grid.x), len(grid.y))
        self._blocks = around.blocks[(z[:, 0] < high - _TOLERANCE_M) & (z[:, 1] > low + _TOLERANCE_M)]
        low_enough = self._blocks.z[:, 0] < low + _TOLERANCE_M
        tall = low_enough & (self._blocks.z[:, 1] > min(high, low + _TALL_M) - _TOLERANCE_M)
        self._plan = BlockFootprints(self._blocks, tall, grid)
        # On stairs, floor and ceiling are those of the camera's storey; elsewhere they are the room's.
        levels = [(s.floor_m, s.ceiling_m) if own.label == STAIRS else (low, high) for s in house.storeys]
        self._levels = np.array(levels, np.float32)
        self._open_above = np.array([each.outdoor for each in house.rooms] + [True])

    def cast(self, eyes: UprightCameras) -> tuple[Depths, Rows]:
        """Return the depth and the thing (index into `Surroundings.names`) of the first hit of each ray."""
        depth, block = self._nearest(eyes, self._plan.cross(eyes))
        return self._with_levels(eyes, depth, block)

    def _nearest(self, eyes: UprightCameras, crossed: Crossings) -> tuple[Depths, Rows]:
        """Return the depth and the index of the first block on each ray (-1: none)."""
        depth = np.full((len(eyes.place), *self._shape), np.inf, np.float32)
        block = np.full(depth.shape, -1)
        if not len(crossed.block):
            return depth, block
        ray = crossed.camera * self._shape[0] + crossed.column
        starts = np.flatnonzero(np.diff(ray, prepend=-1))
        rank = np.arange(len(ray)) - np.repeat(starts, np.diff(starts, append=len(ray)))
        rank = np.minimum(rank, _RANK).astype(np.int32)
        # Positive floats have the order of their bits, so one minimum finds both the least depth and its block.
        packed = self._entered(eyes, crossed).view(np.int32)
        packed &= ~_RANK
        packed |= rank[:, None]
        packed = np.minimum.reduceat(packed, starts)
        found = (packed & ~_RANK).view(np.float32)
        met = found < 0.99 * FAR_M
        rows = crossed.camera[starts], crossed.column[starts]
        depth[rows] = np.where(met, found, np.inf)
        block[rows] = np.where(met, crossed.block[starts[:, None] + (packed & _RANK)], -1)
        return depth, block

    def _entered(self, eyes: UprightCameras, crossed: Crossings) -> Float32[np.ndarray, "h rows"]:
        """Return the depth at which each ray enters each block that its column crosses; `FAR_M` if it misses the block."""
        camera = crossed.camera
        rise, slope = self._blocks.z[crossed.block] - eyes.height[camera, None], eyes.slope[camera]
        low, high = rise[:, :1] / slope, rise[:, 1:] / slope
        enter = np.maximum(np.minimum(low, high), crossed.near[:, None])
        met = (enter <= np.minimum(np.maximum(low, high, out=high), crossed.far[:, None])) & (enter > NEAR_M)
        return np.where(met, enter, FAR_M)

    def _with_levels(self, eyes: UprightCameras, depth: Depths, block: Rows) -> tuple[Depths, Rows]:
        """Add floors and ceilings that are hit before any block, and convert blocks to things.

        Returns the depth and the thing (index into `Surroundings.names`) of each ray; infinite and `NOWHERE` for the sky.
        """
        floor, ceiling = self._levels[eyes.storey].T
        down = eyes.slope < 0.0
        level = np.where(down, floor[:, None], ceiling[:, None])
        plane = np.maximum((level - eyes.height[:, None]) / eyes.slope, np.float32(NEAR_M))[:, None, :]
        on_plane = plane < depth
        depth = np.minimum(depth, plane)
        reach = np.minimum(depth, FAR_M) - np.float32(_NUDGE_M)
        x, y = (eyes.place[:, axis, None, None] + reach * eyes.lines[:, :, axis, None] for axis in (0, 1))
        room = self._around.rooms_at.at(eyes.storey[:, None, None], x, y)
        surface = np.where(on_plane, np.where(down, FLOOR, CEILING)[:, None], WALL)
        thing = np.where(room == NOWHERE, NOWHERE, len(SURFACE_KINDS) * room + surface)
        if len(self._blocks.thing):
            of_block = np.where(on_plane | (block < 0), NOWHERE, self._blocks.thing[block])
            thing = np.where(of_block == NOWHERE, thing, of_block)
        sky = (on_plane & ~down[:, None] & self._open_above[room]) | ~np.isfinite(depth)
        return np.where(sky, np.float32(np.inf), depth), np.where(sky, NOWHERE, thing)
