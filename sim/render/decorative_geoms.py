"""Draws plain shapes, such as people who move, into a scene just before it is rendered. The model stays unchanged."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from jaxtyping import Float64

from sim.render.gl import mujoco
from worlds.parts import Part
from worlds.visuals.meshes import Solid

_SHAPES: Mapping[str, "mujoco.mjtGeom"] = MappingProxyType(
    {
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
        "ball": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    }
)


def draw(scene: "mujoco.MjvScene", solids: Sequence[Solid]) -> None:
    """Append solids in plain colours to a scene that is about to be rendered. Their parts may be boxes, cylinders and balls.

    In segmentation images, these parts have the numbers that follow those of the scene's geoms. The parts occlude what is
    behind them.
    """
    for solid in solids:
        turn, position = _about_z(solid.yaw), np.array(solid.position)
        for part in solid.parts:
            _draw_part(scene, part, position + turn @ np.array(part.centre), turn @ _about_z(part.yaw))


def _draw_part(
    scene: "mujoco.MjvScene", part: Part, position: Float64[np.ndarray, "3"], rotation: Float64[np.ndarray, "3 3"]
) -> None:
    geom = scene.geoms[scene.ngeom]
    half, colour = 0.5 * np.array(part.size), np.array([*part.colour, 1.0], np.float32)
    mujoco.mjv_initGeom(geom, _SHAPES[part.shape], half, position, rotation.reshape(-1), colour)
    geom.size[:] = half
    geom.objtype, geom.objid, geom.segid = mujoco.mjtObj.mjOBJ_UNKNOWN, -1, scene.ngeom
    scene.ngeom += 1


def _about_z(angle_rad: float) -> Float64[np.ndarray, "3 3"]:
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
