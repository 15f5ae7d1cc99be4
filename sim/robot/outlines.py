"""Adds the outlines of obstacles for the range scan: an upright box for each obstacle within the height of the body.

A real robot makes such a scan by projecting the points of a depth sensor onto the plan. A table then appears as its outline,
not as four legs.
"""

import numpy as np

from sim.render.gl import mujoco
from worlds.house import House
from worlds.stairs.build import Stairs

Interval = tuple[float, float]


def add_outlines(spec: "mujoco.MjSpec", house: House, height_m: float) -> list["mujoco.MjsGeom"]:
    """Add upright boxes for walls, railings, doors and solid furniture to `spec`, and return their geoms.

    Boxes reach from the floor to `height_m` above the floor or higher. Obstacles that begin above `height_m` are left out.
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
    for thing in (*house.leaves, *(piece for piece in house.furniture if piece.solid)):
        (x, y, bottom), (width, depth, height) = thing.position, thing.size
        floor = floors[thing.storey]
        if bottom - floor < height_m:
            top = floor + max(bottom - floor + height, height_m)
            geoms.append(_add(spec, x, y, (width, depth), (floor, top), thing.yaw))
    return geoms + [geom for flight in house.stairs for geom in _add_railing(spec, flight, height_m)]


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
