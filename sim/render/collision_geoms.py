"""Collision geometry of a house: boxes, cylinders and ellipsoids in a geom group that viewers hide by default."""

from collections.abc import Iterable

import numpy as np

from sim.render.gl import mujoco
from worlds.house import House
from worlds.labels import STAIRS
from worlds.parts import Part, Vector
from worlds.rectangles import tiles
from worlds.stairs.build import Stairs

GROUP = 3
"""Geom group of the collision geoms. Viewers hide this group by default."""
_FLOOR_M = 0.1
"""Thickness of the floors [m]."""
_LEAST_M = 1e-3
"""Smallest half size that a geom gets [m], because MuJoCo accepts positive sizes only."""
_TYPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "cone": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "ball": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
}


def add_collisions(spec: "mujoco.MjSpec", house: House) -> None:
    """Add the ground and all obstacles of a house to `spec` as static geoms."""
    add_ground(spec, house)
    add_obstacles(spec, house)


def add_ground(spec: "mujoco.MjSpec", house: House) -> list["mujoco.MjsGeom"]:
    """Add the surfaces that a robot stands on (floors and stairs) to `spec`, as static geoms named "<id>#<number>".

    A lift has a platform on every storey, because its one platform is wherever the robot is.
    """
    geoms = []
    for room in house.rooms:
        for i, (x0, y0, x1, y1) in enumerate(tiles(room.polygon)):
            geoms.append(_add_box(spec, f"{room.id}/floor#{i}", (x0, y0, room.floor_m - _FLOOR_M), (x1, y1, room.floor_m)))
    for flight in house.stairs:
        geoms += _add_parts(spec, _name(flight), flight.treads + flight.floors, (0.0, 0.0, 0.0), 0.0)
        if flight.kind == "lift":
            (x0, y0, x1, y1), top = house.room_by_id[flight.room].polygon.bounds, float(flight.walking_line[-1, 2])
            geoms.append(_add_box(spec, f"{_name(flight)}/platform#0", (x0, y0, top - _FLOOR_M), (x1, y1, top)))
    return geoms


def add_obstacles(spec: "mujoco.MjSpec", house: House) -> list["mujoco.MjsGeom"]:
    """Add the obstacles of a house to `spec`, as static geoms named "<id>#<number>".

    Obstacles are walls, railings, solid furniture, and door leaves at their opening angles.
    """
    geoms = []
    for i, wall in enumerate(house.walls):
        x0, y0, x1, y1 = wall.bounds
        geoms.append(_add_box(spec, f"wall#{i}", (x0, y0, wall.bottom_m), (x1, y1, wall.top_m)))
    for flight in house.stairs:
        geoms += _add_parts(spec, f"{_name(flight)}/railing", flight.railing, (0.0, 0.0, 0.0), 0.0)
    for thing in (*house.leaves, *(piece for piece in house.furniture if piece.solid)):
        geoms += _add_parts(spec, thing.id, thing.parts, thing.position, thing.yaw)
    return geoms


def _name(flight: Stairs) -> str:
    return f"{STAIRS}/{flight.room}/{flight.storey}"


def _add_box(spec: "mujoco.MjSpec", name: str, low: Vector, high: Vector) -> "mujoco.MjsGeom":
    ends = np.array([low, high])
    return _add(spec, name, "box", ends.mean(axis=0), np.ptp(ends, axis=0), 0.0)


def _add_parts(
    spec: "mujoco.MjSpec", name: str, parts: Iterable[Part], position: Vector, yaw: float
) -> list["mujoco.MjsGeom"]:
    return [
        _add(spec, f"{name}#{i}", part.shape, part_centre(part, position, yaw), np.array(part_size(part)), yaw + part.yaw)
        for i, part in enumerate(parts)
    ]


def part_centre(part: Part, position: Vector, yaw: float) -> np.ndarray:
    """Return the centre of a part in W [m]. `position` [m] and `yaw` [rad] are those of the object to which it belongs."""
    (x, y, z), cos, sin = part.centre, np.cos(yaw), np.sin(yaw)
    return np.asarray(np.array(position) + (cos * x - sin * y, sin * x + cos * y, z))


def part_size(part: Part) -> Vector:
    """Return the size of the box around a part's collision geom [m]. The geoms of cylinders and cones are round."""
    width, depth, height = part.size
    widest = max(width, depth)
    return (widest, widest, height) if _TYPES[part.shape] == mujoco.mjtGeom.mjGEOM_CYLINDER else part.size


def _add(spec: "mujoco.MjSpec", name: str, shape: str, centre: np.ndarray, size: np.ndarray, yaw: float) -> "mujoco.MjsGeom":
    half = np.maximum(size / 2, _LEAST_M)
    if _TYPES[shape] == mujoco.mjtGeom.mjGEOM_CYLINDER:
        half = np.array([half[0], half[2], 0.0])
    return spec.worldbody.add_geom(
        name=name, type=_TYPES[shape], pos=centre, size=half, quat=[np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)],
        group=GROUP,
    )  # fmt: skip
