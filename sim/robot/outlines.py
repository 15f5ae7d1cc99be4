"""Adds the outlines of obstacles for the range scan: upright boxes for each obstacle within the height of the body.

A real robot makes such a scan by projecting the points of a depth sensor onto the plan. A table then appears as its outline,
not as four legs.
"""

from collections.abc import Iterator

import numpy as np

from sim.render.collision_geoms import part_centre, part_size
from sim.render.gl import mujoco
from worlds.house import House
from worlds.parts import Part, Vector
from worlds.stairs.build import Stairs

Interval = tuple[float, float]
_EXACT_M = 1e-6
"""Parts that reach beyond their object by rounding errors alone get no box [m]."""


def add_outlines(spec: "mujoco.MjSpec", house: House, height_m: float) -> list["mujoco.MjsGeom"]:
    """Add upright boxes for walls, railings, doors and solid furniture to `spec`, and return their geoms.

    Boxes reach from the floor to `height_m` above the floor or higher. Obstacles that begin above `height_m` are left out.
    The boxes of a railing begin at the underside of each post or rail.
    """
    floors = [storey.floor_m for storey in house.storeys]
    # Walls extend through the slab above, so that beams cannot pass between two storeys on the stairs.
    tops = [*floors[1:], house.storeys[-1].ceiling_m]
    geoms = []
    for wall in house.walls:
        x0, y0, x1, y1 = wall.bounds
        floor, ceiling = floors[wall.storey], house.storeys[wall.storey].ceiling_m
        if wall.bottom_m - floor < height_m:
            top = tops[wall.storey] if wall.top_m >= ceiling else max(wall.top_m, floor + height_m)
            geoms.append(_add(spec, (x0 + x1) / 2, (y0 + y1) / 2, (x1 - x0, y1 - y0), (floor, top)))
    for storey, (x, y, bottom), (width, depth, height), yaw in _boxes(house):
        floor = floors[storey]
        if bottom - floor < height_m:
            top = floor + max(bottom - floor + height, height_m)
            geoms.append(_add(spec, x, y, (width, depth), (floor, top), yaw))
    return geoms + [geom for flight in house.stairs for geom in _add_railing(spec, flight, height_m)]


def _boxes(house: House) -> Iterator[tuple[int, Vector, Vector, float]]:
    """Yield storey, centre of the underside [m], size [m] and yaw [rad] of boxes that cover solid furniture and doors.

    There is one box for each object, and one for each of its parts that stands out of that box, such as a door handle.
    """
    for thing in (*house.leaves, *(piece for piece in house.furniture if piece.solid)):
        yield thing.storey, thing.position, thing.size, thing.yaw
        for part in thing.parts:
            size = part_size(part)
            if _stands_out(part, size, thing.size):
                x, y, z = part_centre(part, thing.position, thing.yaw).tolist()
                yield thing.storey, (x, y, z - size[2] / 2), size, thing.yaw + part.yaw


def _stands_out(part: Part, size: Vector, of_object: Vector) -> bool:
    """Whether a part of this size reaches beyond the width or the depth of its object."""
    cos, sin, (width, depth, _) = abs(np.cos(part.yaw)), abs(np.sin(part.yaw)), size
    reach = cos * width + sin * depth, sin * width + cos * depth
    return any(abs(part.centre[axis]) + reach[axis] / 2 > of_object[axis] / 2 + _EXACT_M for axis in (0, 1))


def _add_railing(spec: "mujoco.MjSpec", flight: Stairs, height_m: float) -> list["mujoco.MjsGeom"]:
    """Add boxes for the posts and the rails of a railing."""
    geoms = []
    for part in flight.railing:
        (x, y, z), (width, depth, height) = part.centre, part.size
        foot = z - height / 2
        geoms.append(_add(spec, x, y, (width, depth), (foot, foot + height_m)))
    return geoms


def _add(
    spec: "mujoco.MjSpec", x: float, y: float, size: tuple[float, float], span: Interval, yaw: float = 0.0
) -> "mujoco.MjsGeom":
    low, high = span
    return spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, pos=[x, y, (low + high) / 2], size=[size[0] / 2, size[1] / 2, (high - low) / 2],
        quat=[np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)],
    )  # fmt: skip
