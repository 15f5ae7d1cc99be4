"""`Raster`: renders a scene from any pose with any pinhole camera, in one GL context.

Images and depth are drawn from merged meshes; meshes of rooms that the camera cannot see are left out. Geom ids are drawn
from the separate geoms. The house is static, so MuJoCo's abstract scenes (lists of geoms to draw) are filled once, and only
their cameras move.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from jaxtyping import Float32, Int32, UInt8

from lexis.types import Intrinsics, Pose
from sim.errors import GraphicsError
from sim.render.decorative_geoms import draw
from sim.render.gl import graphics_errors, mujoco, require_rendering
from sim.render.gl_context import GlContext
from sim.render.scene import Scene
from sim.render.visibility import Cells
from worlds.visuals.meshes import Solid

_HIDDEN = -1
"""Mesh id of a geom that MuJoCo does not draw."""
_SPARE = 1024
"""Number of geoms for which a scene (`mujoco.MjvScene`) has memory beyond its own geoms at first, for the parts of moving
things."""
NO_GEOM = -1


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """Image, depth and geom ids of one camera pose."""

    rgb: UInt8[np.ndarray, "h w 3"]
    depth: Float32[np.ndarray, "h w"]
    """Depth along the optical axis [m]; for a fisheye camera, the distance along each pixel's ray [m]."""
    geom_ids: Int32[np.ndarray, "h w"]
    """Index of each pixel's geom in `Scene.object_of_geom`; `NO_GEOM` for sky and moving things."""


class Raster:
    """Renders a scene with any pinhole camera. Use it as a context manager, or call `close` at the end.

    A raster may be used by several threads, but only by one at a time. Raises `GraphicsError` if off-screen OpenGL is
    missing or fails, and for images that are larger than the scene was built for.
    """

    def __init__(self, scene: Scene) -> None:
        require_rendering()
        self._scene = scene
        self._fill(_SPARE)
        self._context = GlContext(scene.model)
        self._context.resources.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR

    def _fill(self, spare: int) -> None:
        """Make the abstract scenes, with memory for `spare` parts of moving things."""
        scene = self._scene
        self._spare = spare
        self._merged = _merged_scene(scene, spare)
        self._objects = _abstract_scene(scene, spare)
        for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            self._objects.flags[flag] = True
        self._geoms = list(self._merged.geoms[: len(scene.merged)])
        self._meshes = [geom.dataid for geom in self._geoms]
        self._shown: Cells = scene.visibility.all

    def place(self, solids: Sequence[Solid]) -> None:
        """Draw `solids` (moving things) in all further images, in place of the previous solids. Their id is `NO_GEOM`."""
        if (parts := sum(len(solid.parts) for solid in solids)) > self._spare:
            self._fill(parts)
        for abstract, standing in ((self._merged, len(self._scene.merged)), (self._objects, self._scene.model.ngeom)):
            abstract.ngeom = standing
            draw(abstract, solids)

    def rgb(self, T_W_C: Pose, intrinsics: Intrinsics) -> UInt8[np.ndarray, "h w 3"]:
        """Render the RGB image from a camera pose."""
        image = np.empty((intrinsics.height, intrinsics.width, 3), np.uint8)
        self._draw_merged(T_W_C, intrinsics, image, None)
        return np.ascontiguousarray(image[::-1])

    def depth(self, T_W_C: Pose, intrinsics: Intrinsics) -> Float32[np.ndarray, "h w"]:
        """Render the depth along the optical axis [m]; the sky has the depth of the far plane."""
        buffer = np.empty((intrinsics.height, intrinsics.width), np.float32)
        self._draw_merged(T_W_C, intrinsics, None, buffer)
        return self._metres(buffer)

    def geom_ids(self, T_W_C: Pose, intrinsics: Intrinsics) -> Int32[np.ndarray, "h w"]:
        """Render, for each pixel, the index of its geom in `Scene.object_of_geom`; `NO_GEOM` for sky and moving things."""
        image = np.empty((intrinsics.height, intrinsics.width, 3), np.uint8)
        self._draw(self._objects, T_W_C, intrinsics, image, None)
        red, green, blue = np.moveaxis(image[::-1].astype(np.int32), -1, 0)
        # All geoms are drawn, so a geom's position in the list equals its id. MuJoCo encodes position + 1 as a colour.
        ids = red + (green << 8) + (blue << 16) - 1
        return np.where(ids < self._scene.model.ngeom, ids, np.int32(NO_GEOM))  # moving things come after the geoms

    def frame(self, T_W_C: Pose, intrinsics: Intrinsics) -> RenderedFrame:
        """Render image and depth in one rendering pass, and geom ids in another."""
        image = np.empty((intrinsics.height, intrinsics.width, 3), np.uint8)
        buffer = np.empty((intrinsics.height, intrinsics.width), np.float32)
        self._draw_merged(T_W_C, intrinsics, image, buffer)
        return RenderedFrame(np.ascontiguousarray(image[::-1]), self._metres(buffer), self.geom_ids(T_W_C, intrinsics))

    def close(self) -> None:
        """Release the GL context. Further calls have no effect. Other rasters stay usable."""
        self._context.close()

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
        """Render the scene. Write colours to `image` and depths to `buffer` (bottom row first), unless these are None."""
        if not self._context.is_open:
            raise GraphicsError("renderer: it is closed; valid: rendering before close()")
        width, height = self._context.size
        if intrinsics.width > width or intrinsics.height > height:
            wanted, size = f"{intrinsics.width} x {intrinsics.height}", f"{width} x {height}"
            raise GraphicsError(f"renderer: an image of {wanted} px; valid: up to {size} px, which the scene was built for")
        _aim(scene, T_W_C, intrinsics)
        area = mujoco.MjrRect(0, 0, intrinsics.width, intrinsics.height)
        with graphics_errors("rendering"), self._context.as_current():
            mujoco.mjr_render(area, scene, self._context.resources)
            mujoco.mjr_readPixels(image, buffer, area, self._context.resources)

    def _metres(self, buffer: Float32[np.ndarray, "h w"]) -> Float32[np.ndarray, "h w"]:
        """Convert a depth buffer (1 at the near plane, 0 at the far plane, bottom row first) to depth [m], top row first."""
        camera = self._merged.camera[0]
        near, far = np.float32(camera.frustum_near), np.float32(camera.frustum_far)
        return np.asarray(near * far / (near + buffer[::-1] * (far - near)))


def _abstract_scene(scene: Scene, spare: int) -> "mujoco.MjvScene":
    """Build the abstract scene of all geoms in the order of their ids, with lights and sky.

    It has memory for `spare` more geoms.
    """
    model = scene.model
    abstract = mujoco.MjvScene(model, maxgeom=model.ngeom + spare)
    everything = mujoco.mjtCatBit.mjCAT_ALL.value
    mujoco.mjv_updateScene(model, scene.data, mujoco.MjvOption(), None, mujoco.MjvCamera(), everything, abstract)
    for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION, mujoco.mjtRndFlag.mjRND_HAZE):
        abstract.flags[flag] = False
    return abstract


def _merged_scene(scene: Scene, spare: int) -> "mujoco.MjvScene":
    """Build the abstract scene of the merged meshes, with lights and sky, and with memory for `spare` more geoms."""
    abstract, model = _abstract_scene(scene, spare), scene.model
    textures = {geom.matid: geom.texid for geom in abstract.geoms[: abstract.ngeom]}
    abstract.ngeom = len(scene.merged)
    for i, (geom, part) in enumerate(zip(abstract.geoms, scene.merged, strict=False)):
        geom.matid = model.material(part.visual.image).id
        geom.texid = textures[geom.matid]
        mesh = model.ngeom + i
        geom.dataid = 2 * mesh  # MuJoCo numbers each mesh and its convex hull
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.mesh_quat[mesh])
        geom.pos, geom.mat = model.mesh_pos[mesh], rotation.reshape(3, 3)
    return abstract


def _aim(scene: "mujoco.MjvScene", T_W_C: Pose, intrinsics: Intrinsics) -> None:
    """Set the pose and the intrinsics of the scene's cameras. No other function deals with MuJoCo's camera conventions."""
    k = intrinsics
    for camera in scene.camera:  # MuJoCo renders from the mean of a left and a right camera
        near = camera.frustum_near
        left, right = (-0.5 - k.cx) / k.fx * near, (k.width - 0.5 - k.cx) / k.fx * near
        camera.pos, camera.forward, camera.up = T_W_C[:3, 3], T_W_C[:3, 2], -T_W_C[:3, 1]
        camera.frustum_center, camera.frustum_width = (left + right) / 2, (right - left) / 2  # MuJoCo's is half the width
        camera.frustum_bottom, camera.frustum_top = -(k.height - 0.5 - k.cy) / k.fy * near, (k.cy + 0.5) / k.fy * near
