"""The simulated camera: where it sits, what it projects, and what it sees."""

from collections.abc import Sequence
from types import TracebackType

import numpy as np
from jaxtyping import Float32, Int32, UInt8

from lexis.types import Camera, Intrinsics, Pose
from sim.render.raster import Raster, RenderedFrame
from sim.render.scene import Scene
from worlds.visuals.meshes import Solid

_BODY_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def wide_camera(width: int = 480, height: int = 360, hfov_deg: float = 100.0) -> Camera:
    """A pinhole looking forward from the body's origin, `hfov_deg` wide; square pixels."""
    f = float(width / 2 / np.tan(np.radians(hfov_deg) / 2))
    T_B_C = np.eye(4)
    T_B_C[:3, :3] = _BODY_FROM_CAMERA
    # MuJoCo's raster has its principal point between the two middle pixels.
    return Camera(Intrinsics(width, height, f, f, width / 2 - 0.5, height / 2 - 0.5), T_B_C)


def fovy_deg(intrinsics: Intrinsics) -> float:
    """The vertical field of view that MuJoCo is given [deg]."""
    return float(np.degrees(2 * np.arctan(intrinsics.height / 2 / intrinsics.fy)))


class CameraRenderer:
    """Renders a scene from poses of the body. Holds a GL context: use it as a context manager or call `close`.

    Raises `GraphicsError` where there is no off-screen OpenGL.
    """

    def __init__(self, scene: Scene, camera: Camera) -> None:
        self.scene, self._camera = scene, camera
        self._raster = Raster(scene)

    def place(self, solids: Sequence[Solid]) -> None:
        """Draw these, too, from now on, instead of those placed before; in ids they are -1."""
        self._raster.place(solids)

    def rgb(self, T_W_B: Pose) -> UInt8[np.ndarray, "h w 3"]:
        """The image seen from a body pose."""
        return self._raster.rgb(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def depth(self, T_W_B: Pose) -> Float32[np.ndarray, "h w"]:
        """Distance along the optical axis [m]. For tests and training; it never reaches LEXIS."""
        return self._raster.depth(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def geom_ids(self, T_W_B: Pose) -> Int32[np.ndarray, "h w"]:
        """Index into `Scene.object_of_geom` per pixel, -1 for sky. For tests and training; it never reaches LEXIS."""
        return self._raster.geom_ids(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def frame(self, T_W_B: Pose) -> RenderedFrame:
        """All three of a pose, at less than their single costs."""
        return self._raster.frame(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def close(self) -> None:
        """Release the GL context."""
        self._raster.close()

    def __enter__(self) -> "CameraRenderer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
