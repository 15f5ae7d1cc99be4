"""The baseline for rendering speed: `mujoco.Renderer` on a model with one geom per furniture part and per wall face.

The simulator itself merges these geoms into a few meshes, which renders faster.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import UInt8

from lexis.types import Camera, Pose
from sim.render.camera import fovy_deg
from sim.render.gl import mujoco, require_rendering
from sim.render.scene import CAMERA, house_mjspec
from worlds.house import House
from worlds.parts import Part
from worlds.visuals.house_visuals import ATLAS, STAIRS_OBJECT, Visual, Visuals, visuals
from worlds.visuals.meshes import Solid, solids_mesh

_CV_FROM_MUJOCO = np.diag([1.0, -1.0, -1.0])
_MAX_GEOMS = 20_000


def unmerged(house: House) -> Visuals:
    """Return the quads of `visuals(house)`, with a separate visual for each face of the building and part of an object."""
    seen = visuals(house)
    things = [*house.furniture, *house.leaves, *house.windows]
    parts_of = {thing.id: thing.parts for thing in things}
    parts_of |= {f"{STAIRS_OBJECT}/{flight.storey}/{flight.room}": flight.parts for flight in house.stairs}
    return Visuals(
        seen.images, tuple(piece for visual in seen.parts for piece in _pieces(visual, parts_of.get(visual.name)))
    )


def _pieces(visual: Visual, parts: Sequence[Part] | None) -> Iterator[Visual]:
    of_shell = visual.image != ATLAS or parts is None
    part_of_quad = np.arange(len(visual.corners)) if of_shell else solids_mesh([Solid(parts or ())]).part
    for i in np.unique(part_of_quad):
        own = part_of_quad == i
        yield Visual(
            f"{visual.name}#{i}", visual.shows, visual.image, visual.corners[own], visual.uv[own], visual.normals[own]
        )


class PlainRenderer:
    """MuJoCo's own renderer: without shadows and multi-sampling or, if `defaults`, with MuJoCo's default settings."""

    def __init__(self, house: House, camera: Camera, *, defaults: bool = False) -> None:
        require_rendering()
        self._camera, k = camera, camera.intrinsics
        spec = house_mjspec(house, unmerged(house))
        if not defaults:
            spec.visual.quality.offsamples, spec.visual.quality.shadowsize = 0, 0
        else:
            for light in spec.lights:
                light.castshadow = True
        spec.visual.global_.offwidth, spec.visual.global_.offheight = k.width, k.height
        body = spec.worldbody.add_body(name=CAMERA, mocap=True)
        body.add_camera(name=CAMERA, fovy=fovy_deg(k))
        self.model = spec.compile()
        self._data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self._data)
        self._renderer = mujoco.Renderer(self.model, k.height, k.width, max_geom=_MAX_GEOMS)
        if not defaults:
            for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION, mujoco.mjtRndFlag.mjRND_HAZE):
                self._renderer.scene.flags[flag] = False

    def rgb(self, T_W_B: Pose) -> UInt8[np.ndarray, "h w 3"]:
        """Render the image of the camera at a pose of the body."""
        T_W_C = T_W_B @ self._camera.T_B_C
        self._data.cam_xpos[0] = T_W_C[:3, 3]
        self._data.cam_xmat[0] = (T_W_C[:3, :3] @ _CV_FROM_MUJOCO).reshape(-1)
        self._renderer.update_scene(self._data, camera=CAMERA)
        return np.asarray(self._renderer.render())

    def close(self) -> None:
        """Release the GL context."""
        self._renderer.close()
