"""The simulated pinhole camera: its intrinsics and pose on the body, and a renderer of images, depth and geom ids."""

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
    """Make a pinhole camera at the body's origin that looks forward. Its pixels are square."""
    f = float(width / 2 / np.tan(np.radians(hfov_deg) / 2))
    T_B_C = np.eye(4)
    T_B_C[:3, :3] = _BODY_FROM_CAMERA
    # MuJoCo's principal point lies between the two middle pixels.
    return Camera(Intrinsics(width, height, f, f, width / 2 - 0.5, height / 2 - 0.5), T_B_C)


def fovy_deg(intrinsics: Intrinsics) -> float:
    """Return a camera's vertical field of view [deg]. MuJoCo describes cameras by this angle instead of a focal length."""
    return float(np.degrees(2 * np.arctan(intrinsics.height / 2 / intrinsics.fy)))


class CameraRenderer:
    """Renders a scene with one camera, or its rig, from poses of the body. Use it as a context manager, or call `close`.

    It holds a GL context. Raises `GraphicsError` if there is no off-screen OpenGL.
    """

    def __init__(self, scene: Scene, camera: Camera) -> None:
        self.scene, self._camera = scene, camera
        self._raster = Raster(scene)

    def place(self, solids: Sequence[Solid]) -> None:
        """Draw `solids` (moving things) in all further images, in place of the previous solids. Their geom id is -1."""
        self._raster.place(solids)

    def rgb(self, T_W_B: Pose) -> UInt8[np.ndarray, "h w 3"]:
        """Render the image from a body pose."""
        return self._raster.rgb(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def rig(self, T_W_B: Pose) -> tuple[UInt8[np.ndarray, "h w 3"], ...]:
        """Render the images of all cameras of the rig from a body pose."""
        return tuple(self._raster.rgb(T_W_B @ camera.T_B_C, camera.intrinsics) for camera in self._camera.rig)

    def depth(self, T_W_B: Pose) -> Float32[np.ndarray, "h w"]:
        """Render the depth along the optical axis [m], for tests and training. It is never given to LEXIS."""
        return self._raster.depth(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def geom_ids(self, T_W_B: Pose) -> Int32[np.ndarray, "h w"]:
        """Render, for each pixel, the index of its geom in `Scene.object_of_geom`; -1 for sky and moving things.

        Geom ids are for tests and training. They are never given to LEXIS.
        """
        return self._raster.geom_ids(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def frame(self, T_W_B: Pose) -> RenderedFrame:
        """Render image, depth and geom ids from a body pose, faster than in separate calls."""
        return self._raster.frame(T_W_B @ self._camera.T_B_C, self._camera.intrinsics)

    def close(self) -> None:
        """Release the GL context."""
        self._raster.close()

    def __enter__(self) -> "CameraRenderer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
