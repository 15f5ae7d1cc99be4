"""The simulated camera: where it sits, what it projects, and the off-screen renderer."""

from types import TracebackType

import numpy as np
from jaxtyping import Float32, Float64, Int32, UInt8

from lexis.types import Camera, Intrinsics
from sim.gl import mujoco, require_rendering
from sim.scene import CAMERA, Scene

_BODY_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
_CV_FROM_MUJOCO = np.diag([1.0, -1.0, -1.0])


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
        require_rendering()
        self.scene, self._camera = scene, camera
        size = camera.intrinsics.height, camera.intrinsics.width
        self._renderer = mujoco.Renderer(scene.model, *size)
        flags = self._renderer.scene.flags
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION, mujoco.mjtRndFlag.mjRND_HAZE):
            flags[flag] = False

    def rgb(self, T_W_B: Float64[np.ndarray, "4 4"]) -> UInt8[np.ndarray, "h w 3"]:
        """The image seen from a body pose."""
        self._look_from(T_W_B)
        return np.asarray(self._renderer.render())

    def depth(self, T_W_B: Float64[np.ndarray, "4 4"]) -> Float32[np.ndarray, "h w"]:
        """Distance along the optical axis [m]. For tests and training; it never reaches LEXIS."""
        self._renderer.enable_depth_rendering()
        self._look_from(T_W_B)
        image = np.asarray(self._renderer.render())
        self._renderer.disable_depth_rendering()
        return image

    def geom_ids(self, T_W_B: Float64[np.ndarray, "4 4"]) -> Int32[np.ndarray, "h w"]:
        """Index into `Scene.object_of_geom` per pixel, -1 for sky. For tests and training; it never reaches LEXIS."""
        self._renderer.enable_segmentation_rendering()
        self._look_from(T_W_B)
        ids = np.asarray(self._renderer.render())[..., 0].astype(np.int32)
        self._renderer.disable_segmentation_rendering()
        return ids

    def close(self) -> None:
        """Release the GL context."""
        self._renderer.close()

    def __enter__(self) -> "CameraRenderer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _look_from(self, T_W_B: Float64[np.ndarray, "4 4"]) -> None:
        T_W_C = T_W_B @ self._camera.T_B_C
        data = self.scene.data
        data.cam_xpos[0] = T_W_C[:3, 3]
        data.cam_xmat[0] = (T_W_C[:3, :3] @ _CV_FROM_MUJOCO).reshape(-1)
        self._renderer.update_scene(data, camera=CAMERA)
