"""`Raster`: one GL context that draws a scene from anywhere, for any pinhole.

It draws the merged meshes of what the camera may see for pictures and depth, and the geoms for their ids. The house stands
still, so MuJoCo's abstract scenes are filled once and only their cameras move.
"""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from jaxtyping import Float32, Int32, UInt8

from lexis.types import Intrinsics, Pose
from sim.errors import GraphicsError
from sim.render.decorative_geoms import draw
from sim.render.gl import graphics_errors, mujoco, require_rendering
from sim.render.scene import Scene
from sim.render.visibility import Cells
from worlds.visuals.meshes import Solid

_HIDDEN = -1
_SPARE = 1024
"""Places in an abstract scene that are kept for what is no geom of the model: what moves."""
NO_GEOM = -1


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """All that a camera sees from one pose."""

    rgb: UInt8[np.ndarray, "h w 3"]
    depth: Float32[np.ndarray, "h w"]
    """Along the optical axis [m]."""
    geom_ids: Int32[np.ndarray, "h w"]
    """Index into `Scene.object_of_geom`, `NO_GEOM` for sky."""


class Raster:
    """Holds a GL context: use it as a context manager or call `close`. Belongs to the thread that made it.

    Raises `GraphicsError` where there is no off-screen OpenGL, where it fails, and for images larger than the scene's.
    """

    def __init__(self, scene: Scene) -> None:
        require_rendering()
        self._scene, model = scene, scene.model
        self._merged = _merged_scene(scene)
        self._objects = _abstract_scene(scene)
        for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            self._objects.flags[flag] = True
        self._geoms = list(self._merged.geoms[: len(scene.merged)])
        self._meshes = [geom.dataid for geom in self._geoms]
        self._shown: Cells = scene.visibility.all
        self._size = model.vis.global_.offwidth, model.vis.global_.offheight
        with graphics_errors(f"a context of {self._size[0]} x {self._size[1]} px"):
            self._gl = mujoco.GLContext(*self._size)
            self._gl.make_current()
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._open = True

    def place(self, solids: Sequence[Solid]) -> None:
        """Draw these, too, from now on, instead of those placed before; in ids they are `NO_GEOM`."""
        for abstract, standing in ((self._merged, len(self._scene.merged)), (self._objects, self._scene.model.ngeom)):
            abstract.ngeom = standing
            draw(abstract, solids)

    def rgb(self, T_W_C: Pose, intrinsics: Intrinsics) -> UInt8[np.ndarray, "h w 3"]:
        """The picture."""
        image = np.empty((intrinsics.height, intrinsics.width, 3), np.uint8)
        self._draw_merged(T_W_C, intrinsics, image, None)
        return np.ascontiguousarray(image[::-1])

    def depth(self, T_W_C: Pose, intrinsics: Intrinsics) -> Float32[np.ndarray, "h w"]:
        """Distance along the optical axis [m]; of the sky, that of the far plane."""
        buffer = np.empty((intrinsics.height, intrinsics.width), np.float32)
        self._draw_merged(T_W_C, intrinsics, None, buffer)
        return self._metres(buffer)

    def geom_ids(self, T_W_C: Pose, intrinsics: Intrinsics) -> Int32[np.ndarray, "h w"]:
        """Index into `Scene.object_of_geom` per pixel, `NO_GEOM` for sky."""
        image = np.empty((intrinsics.height, intrinsics.width, 3), np.uint8)
        self._draw(self._objects, T_W_C, intrinsics, image, None)
        red, green, blue = np.moveaxis(image[::-1].astype(np.int32), -1, 0)
        # All geoms are drawn, so that a geom's place among the drawn is its id; MuJoCo counts them from 1.
        return np.asarray(red + (green << 8) + (blue << 16) - 1)

    def frame(self, T_W_C: Pose, intrinsics: Intrinsics) -> RenderedFrame:
        """Picture and depth, drawn together, and ids."""
        image = np.empty((intrinsics.height, intrinsics.width, 3), np.uint8)
        buffer = np.empty((intrinsics.height, intrinsics.width), np.float32)
        self._draw_merged(T_W_C, intrinsics, image, buffer)
        return RenderedFrame(np.ascontiguousarray(image[::-1]), self._metres(buffer), self.geom_ids(T_W_C, intrinsics))

    def close(self) -> None:
        """Release the GL context; more than once does no harm, and to no other raster."""
        if self._open:
            self._open = False
            with self._gl.as_current() if hasattr(self._gl, "as_current") else nullcontext():
                self._context.free()
            self._gl.free()

    def __enter__(self) -> "Raster":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _draw_merged(
        self,
        T_W_C: Pose,
        intrinsics: Intrinsics,
        image: UInt8[np.ndarray, "h w 3"] | None,
        buffer: Float32[np.ndarray, "h w"] | None,
    ) -> None:
        seen = self._scene.visibility.seen(T_W_C, intrinsics)
        if seen != self._shown:
            self._shown = seen
            for geom, mesh, part in zip(self._geoms, self._meshes, self._scene.merged, strict=True):
                geom.dataid = _HIDDEN if seen.isdisjoint(part.cells) else mesh
        self._draw(self._merged, T_W_C, intrinsics, image, buffer)

    def _draw(
        self,
        scene: "mujoco.MjvScene",
        T_W_C: Pose,
        intrinsics: Intrinsics,
        image: UInt8[np.ndarray, "h w 3"] | None,
        buffer: Float32[np.ndarray, "h w"] | None,
    ) -> None:
        """Draw into the frame buffer and read it, from the bottom row up."""
        if not self._open:
            raise GraphicsError("this renderer is closed; valid: drawing before close()")
        if intrinsics.width > self._size[0] or intrinsics.height > self._size[1]:
            wanted, size = f"{intrinsics.width} x {intrinsics.height}", f"{self._size[0]} x {self._size[1]}"
            raise GraphicsError(f"an image of {wanted} px from a scene that was built for {size} px; build it for both")
        _aim(scene, T_W_C, intrinsics)
        area = mujoco.MjrRect(0, 0, intrinsics.width, intrinsics.height)
        with graphics_errors("drawing"):
            self._gl.make_current()
            mujoco.mjr_render(area, scene, self._context)
            mujoco.mjr_readPixels(image, buffer, area, self._context)

    def _metres(self, buffer: Float32[np.ndarray, "h w"]) -> Float32[np.ndarray, "h w"]:
        """From a reversed depth buffer: 1 at the near plane, 0 at the far one."""
        camera = self._merged.camera[0]
        near, far = np.float32(camera.frustum_near), np.float32(camera.frustum_far)
        return np.asarray(near * far / (near + buffer[::-1] * (far - near)))


def _abstract_scene(scene: Scene) -> "mujoco.MjvScene":
    """All geoms as they are, with lights and sky, in the order of their ids."""
    model = scene.model
    abstract = mujoco.MjvScene(model, maxgeom=model.ngeom + _SPARE)
    everything = mujoco.mjtCatBit.mjCAT_ALL.value
    mujoco.mjv_updateScene(model, scene.data, mujoco.MjvOption(), None, mujoco.MjvCamera(), everything, abstract)
    for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION, mujoco.mjtRndFlag.mjRND_HAZE):
        abstract.flags[flag] = False
    return abstract


def _merged_scene(scene: Scene) -> "mujoco.MjvScene":
    """The same with the merged meshes in the place of the geoms."""
    abstract, model = _abstract_scene(scene), scene.model
    textures = {geom.matid: geom.texid for geom in abstract.geoms[: abstract.ngeom]}
    abstract.ngeom = len(scene.merged)
    for i, (geom, part) in enumerate(zip(abstract.geoms, scene.merged, strict=False)):
        geom.matid = model.material(part.visual.image).id
        geom.texid = textures[geom.matid]
        mesh = model.ngeom + i
        geom.dataid = 2 * mesh  # MuJoCo counts a mesh and its hull
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.mesh_quat[mesh])
        geom.pos, geom.mat = model.mesh_pos[mesh], rotation.reshape(3, 3)
    return abstract


def _aim(scene: "mujoco.MjvScene", T_W_C: Pose, intrinsics: Intrinsics) -> None:
    """Set the pinhole; this is the one place that knows of MuJoCo's cameras."""
    k = intrinsics
    for camera in scene.camera:  # of both eyes, between which MuJoCo looks from
        near = camera.frustum_near
        left, right = (-0.5 - k.cx) / k.fx * near, (k.width - 0.5 - k.cx) / k.fx * near
        camera.pos, camera.forward, camera.up = T_W_C[:3, 3], T_W_C[:3, 2], -T_W_C[:3, 1]
        camera.frustum_center, camera.frustum_width = (left + right) / 2, (right - left) / 2  # half of it, in fact
        camera.frustum_bottom, camera.frustum_top = -(k.height - 0.5 - k.cy) / k.fy * near, (k.cy + 0.5) / k.fy * near
