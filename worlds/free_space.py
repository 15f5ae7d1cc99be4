"""Free space of a house: obstacles as upright boxes, and the exact distance from every grid point to the nearest obstacle.

Distances are horizontal. An obstacle counts on a storey if it overlaps the heights that a standing body takes up.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from jaxtyping import Bool, Float64, Int
from shapely import STRtree

from worlds.house import House
from worlds.labels import STAIRS
from worlds.placed import Placed
from worlds.walls import Wall

BODY_LOW_M = 0.05
"""Obstacles that end at or below this height above the walked surface, such as rugs, do not stop a body [m]."""
BODY_HIGH_M = 1.9
"""Height of the space that a body needs above the walked surface [m]; lintels are higher."""
CLEARANCE_CAP_M = 1.0
"""Greatest distance to obstacles that is computed; larger distances are replaced by this value [m]."""
STAIRS_LINK_M = 0.5
"""Greatest distance between the end of a walking line (the path up stairs) and the free grid points joined to it [m]."""
_PADDING_M = 0.3
"""Distance by which the grid extends beyond the rooms on every side [m]."""
_TOLERANCE_M = 1e-6


@dataclass(frozen=True, eq=False)
class Obstacles:
    """The obstacles of a house: upright boxes, each rotated about z by a yaw."""

    centre: Float64[np.ndarray, "n 2"]
    """Centre of each box in the plan, in W [m]."""
    size: Float64[np.ndarray, "n 2"]
    """Width and depth of each box, along its own axes [m]."""
    yaw: Float64[np.ndarray, "n"]
    """Rotation of each box about z, counter-clockwise [rad]."""
    span: Float64[np.ndarray, "n 2"]
    """Heights of each box's lower and upper end in W [m]."""

    @staticmethod
    def of(rows: Sequence[tuple[float, ...]]) -> "Obstacles":
        """Return boxes given as rows (x and y of the centre, width, depth, yaw, heights of both ends), in m and rad."""
        table = np.array(rows, dtype=np.float64).reshape(-1, 7)
        return Obstacles(table[:, :2], table[:, 2:4], table[:, 4], table[:, 5:])

    @staticmethod
    def around(things: Sequence[Placed]) -> "Obstacles":
        """Return the box that each object fills."""
        poses = ((thing.position, thing.size, thing.yaw) for thing in things)
        return Obstacles.of([(x, y, width, depth, yaw, z, z + height) for (x, y, z), (width, depth, height), yaw in poses])

    @staticmethod
    def of_walls(walls: Sequence[Wall]) -> "Obstacles":
        """Return each wall as a box."""
        return Obstacles.of([(*_centred(wall.bounds), 0.0, wall.bottom_m, wall.top_m) for wall in walls])

    @cached_property
    def corners(self) -> Float64[np.ndarray, "n 4 2"]:
        """Corners of each box in the plan, counter-clockwise, in W [m]."""
        corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * self.size[:, None, :]
        cos, sin = np.cos(self.yaw)[:, None], np.sin(self.yaw)[:, None]
        x, y = cos * corners[..., 0] - sin * corners[..., 1], sin * corners[..., 0] + cos * corners[..., 1]
        return np.asarray(np.stack([x, y], axis=-1) + self.centre[:, None, :])

    @cached_property
    def footprints(self) -> STRtree:
        """Spatial index of the boxes' outlines in the plan; item i of the index is box i."""
        return STRtree(np.asarray(shapely.polygons(self.corners)))

    def at_height(self, surface_m: float) -> "Obstacles":
        """Return the boxes that can collide with a body standing on a surface at height `surface_m` in W [m]."""
        return self.chosen((self.span[:, 0] < surface_m + BODY_HIGH_M) & (self.span[:, 1] > surface_m + BODY_LOW_M))

    def chosen(self, which: Bool[np.ndarray, "n"] | slice) -> "Obstacles":
        """Return the boxes where a mask is True, or those of a slice."""
        return Obstacles(self.centre[which], self.size[which], self.yaw[which], self.span[which])

    def and_also(self, others: "Obstacles") -> "Obstacles":
        """Return these boxes and others as one set."""
        columns = ("centre", "size", "yaw", "span")
        return Obstacles(*(np.concatenate([getattr(self, name), getattr(others, name)]) for name in columns))

    def within(self, point: Float64[np.ndarray, "2"], distance_m: float) -> "Obstacles":
        """Return all boxes within `distance_m` [m] of a point of the plan, and possibly some boxes a little farther away."""
        reach = np.linalg.norm(self.size, axis=1) / 2 + distance_m
        return self.chosen((np.abs(self.centre - point) <= reach[:, None]).all(axis=1))

    def clear(
        self, start: Float64[np.ndarray, "m 3"], end: Float64[np.ndarray, "m 3"], radius_m: float
    ) -> Bool[np.ndarray, "m"]:
        """Return for each of `m` straight steps on the walked surface whether a body makes the step without a collision.

        Step i leads from `start[i]` to `end[i]`, which are points in W [m]; `radius_m` is the body's radius [m]. On a slope,
        the body counts as tall enough to be at both ends of the step at once. A free step may therefore be reported as
        blocked, but a blocked step is never reported as free.
        """
        steps = np.asarray(shapely.linestrings(np.stack([start[:, :2], end[:, :2]], axis=1)))
        step, box = self.footprints.query(steps, predicate="dwithin", distance=radius_m - _TOLERANCE_M)
        low = np.minimum(start[step, 2], end[step, 2]) + BODY_LOW_M
        high = np.maximum(start[step, 2], end[step, 2]) + BODY_HIGH_M
        meets = (self.span[box, 0] < high) & (self.span[box, 1] > low)
        free = np.full(len(steps), True)
        free[step[meets]] = False
        return free


def solid_obstacles(house: House, leaves: bool = True) -> Obstacles:
    """Return the solid objects of a house as boxes: walls, fences, solid furniture and, if `leaves`, the door leaves."""
    pieces = [piece for piece in house.furniture if piece.solid]
    return Obstacles.of_walls(house.walls).and_also(Obstacles.around([*pieces, *(house.leaves if leaves else ())]))


def stair_wells(house: House) -> Obstacles:
    """Return each stairwell as a box, from its lowest floor to its highest ceiling; there is no floor to walk on inside."""
    stairs = [room for room in house.rooms if room.label == STAIRS]
    return Obstacles.of([(*_centred(room.polygon.bounds), 0.0, room.floor_m, room.ceiling_m) for room in stairs])


def _centred(bounds: Sequence[float]) -> tuple[float, float, float, float]:
    """Convert a rectangle (x0, y0, x1, y1) to (x of the centre, y of the centre, width, depth)."""
    x0, y0, x1, y1 = bounds
    return (x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The free space of all storeys of a house, with the same grid of points on every storey."""

    x: Float64[np.ndarray, "nx"]
    """x coordinates of the grid points in W [m]."""
    y: Float64[np.ndarray, "ny"]
    """y coordinates of the grid points in W [m]."""
    floors: Float64[np.ndarray, "storeys"]
    """Heights of the floors in W [m]."""
    clearance: Float64[np.ndarray, "storeys nx ny"]
    """Distance to the nearest obstacle or stairwell, at most `CLEARANCE_CAP_M`; 0 inside an obstacle or stairwell [m]."""
    room: Int[np.ndarray, "storeys nx ny"]
    """Index in `house.rooms` of the room at each point, -1 outside of all rooms."""


def survey(house: House, resolution_m: float) -> FreeSpace:
    """Return the free space of a house on a grid whose points are `resolution_m` [m] apart."""
    x, y = lattice(house, resolution_m)
    solids, wells = solid_obstacles(house), stair_wells(house)
    floors = np.array([storey.floor_m for storey in house.storeys])
    clearance = [clearance_on(x, y, (solids.at_height(floor), wells.at_height(floor))) for floor in floors]
    return FreeSpace(x, y, floors, np.stack(clearance), np.stack([_rooms(house, x, y, floor) for floor in floors]))


def lattice(house: House, resolution_m: float) -> tuple[Float64[np.ndarray, "nx"], Float64[np.ndarray, "ny"]]:
    """Return the coordinates x and y in W of a grid with points `resolution_m` apart that covers the plan of a house [m]."""
    x0, y0, x1, y1 = shapely.total_bounds([room.polygon for room in house.rooms])
    x = np.arange(x0 - _PADDING_M, x1 + _PADDING_M, resolution_m)
    return x, np.arange(y0 - _PADDING_M, y1 + _PADDING_M, resolution_m)


def free_clearance(radius_m: float, resolution_m: float) -> float:
    """Return the least distance from an obstacle at which a point of a grid counts as free for a body [m].

    It is so large that the body also stays clear of obstacles on the straight line between two diagonal neighbours.
    """
    return math.hypot(radius_m, resolution_m / math.sqrt(2.0))


def clearance_on(
    x: Float64[np.ndarray, "nx"],
    y: Float64[np.ndarray, "ny"],
    groups: Sequence[Obstacles],
    cap_m: float = CLEARANCE_CAP_M,
) -> Float64[np.ndarray, "nx ny"]:
    """Return the distance from every grid point (`x`, `y`) to the nearest obstacle of all `groups`, at most `cap_m` [m].

    Each box only changes the points within `cap_m` of its bounding rectangle. Boxes parallel to the axes are the common case
    and take a faster path, in which x and y are treated separately.
    """
    squared = np.full((len(x), len(y)), cap_m**2)
    for obstacles in groups:
        cos, sin = np.cos(obstacles.yaw), np.sin(obstacles.yaw)
        # Half the size of each box's bounding rectangle.
        reach = np.abs(np.stack([cos, -sin, sin, cos], axis=-1).reshape(-1, 2, 2)) @ obstacles.size[..., None] / 2
        low, high = obstacles.centre - reach[..., 0] - cap_m, obstacles.centre + reach[..., 0] + cap_m
        i0, i1 = np.searchsorted(x, low[:, 0]).tolist(), np.searchsorted(x, high[:, 0]).tolist()
        j0, j1 = np.searchsorted(y, low[:, 1]).tolist(), np.searchsorted(y, high[:, 1]).tolist()
        quarter_turns = obstacles.yaw / (np.pi / 2)
        aligned = np.isclose(quarter_turns, np.round(quarter_turns), atol=1e-9)
        for k in range(len(obstacles.yaw)):
            dx, dy = x[i0[k] : i1[k]] - obstacles.centre[k, 0], y[j0[k] : j1[k]] - obstacles.centre[k, 1]
            if aligned[k]:
                along, across = np.abs(dx) - reach[k, 0, 0], np.abs(dy) - reach[k, 1, 0]
                distance = np.add.outer(np.maximum(along, 0.0) ** 2, np.maximum(across, 0.0) ** 2)
            else:
                u, v = np.add.outer(cos[k] * dx, sin[k] * dy), np.add.outer(-sin[k] * dx, cos[k] * dy)
                along, across = np.abs(u) - obstacles.size[k, 0] / 2, np.abs(v) - obstacles.size[k, 1] / 2
                distance = np.maximum(along, 0.0) ** 2 + np.maximum(across, 0.0) ** 2
            window = squared[i0[k] : i1[k], j0[k] : j1[k]]
            np.minimum(window, distance, out=window)
    np.sqrt(squared, out=squared)
    return squared


def _rooms(
    house: House, x: Float64[np.ndarray, "nx"], y: Float64[np.ndarray, "ny"], floor: float
) -> Int[np.ndarray, "nx ny"]:
    index = np.full((len(x), len(y)), -1)
    for k, room in enumerate(house.rooms):
        if room.floor_m <= floor < room.ceiling_m:
            x0, y0, x1, y1 = room.polygon.bounds
            i = slice(np.searchsorted(x, x0), np.searchsorted(x, x1, side="right"))
            j = slice(np.searchsorted(y, y0), np.searchsorted(y, y1, side="right"))
            # Points on the boundary count as inside, because a door may lie exactly on a line of the grid.
            inside = shapely.intersects_xy(room.polygon, x[i, None], y[None, j])
            index[i, j][inside] = k
    return index
