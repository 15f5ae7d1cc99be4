"""Rigs: cameras that share a body, and a renderer of all of them with one GL context."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType, TracebackType

import numpy as np
from jaxtyping import UInt8
from scipy.spatial.transform import Rotation

from lexis.types import Camera, Pose
from sim.errors import SimError
from sim.render.camera import fovy_deg, wide_camera
from sim.render.fisheye import Fisheye, FisheyeRenderer
from sim.render.raster import Raster, RenderedFrame
from sim.render.scene import Scene, build_scene
from worlds.house import House
from worlds.parts import Vector
from worlds.valid_names import did_you_mean

STEREO_BASELINE_M = 0.11
"""As of the paper's Alphasense and of EuRoC's camera."""
LEVER_ARM_M = 0.15
"""Farthest that `displaced` moves cameras from the IMU [m]."""
FREE_M = 0.24
"""Farthest place of a camera beside the IMU: the body keeps 0.25 m from everything solid [m]."""
_FISHEYE_PX = 480
_FISHEYE_DEG = 180.0


@dataclass(frozen=True, eq=False)
class Rig:
    """Cameras on one body. The first pinhole is the one whose images LEXIS is given."""

    name: str
    cameras: Mapping[str, Camera]
    fisheyes: Mapping[str, Fisheye] = field(default_factory=dict)

    @property
    def front(self) -> Camera:
        """The camera of LEXIS."""
        return next(iter(self.cameras.values()))

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height into which every image fits."""
        images = [*(camera.intrinsics for camera in self.cameras.values()), *(eye.face for eye in self.fisheyes.values())]
        return max(image.width for image in images), max(image.height for image in images)


def displaced(rig: Rig, offset_m: Vector, rpy_deg: Vector = (0.0, 0.0, 0.0)) -> Rig:
    """The rig moved and turned as one on the body, whose frame is the IMU's: the lever arm from the IMU to the cameras.

    The offset is in B [m]; the rotation is `Rz(yaw) Ry(pitch) Rx(roll)` [deg]. Raises `SimError` for values that are not
    finite, and for an offset of more than `LEVER_ARM_M`.
    """
    if not np.isfinite([*offset_m, *rpy_deg]).all() or np.linalg.norm(offset_m) > LEVER_ARM_M:
        raise SimError(
            f"rig: lever arm {offset_m} m, {rpy_deg} deg; valid: finite numbers, cameras up to {LEVER_ARM_M} m from the IMU"
        )
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", rpy_deg, degrees=True).as_matrix()
    T[:3, 3] = offset_m
    cameras = {name: replace(camera, T_B_C=T @ camera.T_B_C) for name, camera in rig.cameras.items()}
    fisheyes = {name: replace(eye, T_B_C=T @ eye.T_B_C) for name, eye in rig.fisheyes.items()}
    return replace(rig, cameras=cameras, fisheyes=fisheyes)


def build_rig_scene(house: House, rig: Rig) -> Scene:
    """A scene that every camera of `rig` can render."""
    return build_scene(house, rig.size_px, fovy_deg(rig.front.intrinsics))


def make_rig(name: str, width: int = 480, height: int = 360, hfov_deg: float = 100.0) -> Rig:
    """A preset of `RIGS` with pinholes of that size [px] and horizontal field of view. Raises `SimError` if unknown."""
    if name not in RIGS:
        raise SimError(f"unknown rig {name!r}{did_you_mean(name, RIGS)}; valid: {', '.join(RIGS)}")
    return RIGS[name](wide_camera(width, height, hfov_deg))


def _wide(camera: Camera) -> Rig:
    return Rig("wide", {"front": camera})


def _stereo(camera: Camera) -> Rig:
    half = STEREO_BASELINE_M / 2
    return Rig("stereo", {"left": _mounted(camera, y_m=half), "right": _mounted(camera, y_m=-half)})


def _front_rear(camera: Camera) -> Rig:
    return Rig("front-rear", {"front": camera, "rear": _mounted(camera, x_m=-0.1, yaw=np.pi)})


def _four(camera: Camera) -> Rig:
    lateral = {
        "lateral left": _mounted(camera, y_m=0.08, yaw=np.pi / 2),
        "lateral right": _mounted(camera, y_m=-0.08, yaw=-np.pi / 2),
    }
    return Rig("four", {**{f"front {side}": eye for side, eye in _stereo(camera).cameras.items()}, **lateral})


def _fisheye(camera: Camera) -> Rig:
    return Rig("fisheye", {"front": camera}, {"fisheye": Fisheye(_FISHEYE_PX, _FISHEYE_DEG, camera.T_B_C)})


RIGS: Mapping[str, Callable[[Camera], Rig]] = MappingProxyType(
    {"wide": _wide, "stereo": _stereo, "front-rear": _front_rear, "four": _four, "fisheye": _fisheye}
)
"""`four` is the paper's: two cameras ahead and one to either side. `front-rear` sees revisits in the opposite direction.
`fisheye` has one of 180 degrees beside the front pinhole, for tests of other software: LEXIS and the formats of recordings
know pinholes only, so that LEXIS sees the pinhole."""


def _mounted(camera: Camera, x_m: float = 0.0, y_m: float = 0.0, yaw: float = 0.0) -> Camera:
    """The same camera at another place of the body, turned about z."""
    T_B_B = np.eye(4)
    T_B_B[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T_B_B[:2, 3] = x_m, y_m
    return replace(camera, T_B_C=T_B_B @ camera.T_B_C)


class RigRenderer:
    """Renders all cameras of a rig from poses of the body, with one GL context. Use it as a context manager or call `close`.

    Raises `GraphicsError` where there is no off-screen OpenGL, or where the scene was built for smaller images.
    """

    def __init__(self, scene: Scene, rig: Rig) -> None:
        self.scene, self._rig = scene, rig
        self._raster = Raster(scene)
        self._fisheyes = {name: FisheyeRenderer(self._raster, eye) for name, eye in rig.fisheyes.items()}

    def rgb(self, T_W_B: Pose) -> dict[str, UInt8[np.ndarray, "h w 3"]]:
        """The images by camera; fisheyes last."""
        images = {name: self._raster.rgb(T_W_B @ eye.T_B_C, eye.intrinsics) for name, eye in self._rig.cameras.items()}
        return images | {name: eye.frame(T_W_B).rgb for name, eye in self._fisheyes.items()}

    def frames(self, T_W_B: Pose) -> dict[str, RenderedFrame]:
        """Pictures, depths and ids by camera. A fisheye's depths run along the rays, a pinhole's along its axis."""
        frames = {name: self._raster.frame(T_W_B @ eye.T_B_C, eye.intrinsics) for name, eye in self._rig.cameras.items()}
        return frames | {name: eye.frame(T_W_B) for name, eye in self._fisheyes.items()}

    def close(self) -> None:
        """Release the GL context."""
        self._raster.close()

    def __enter__(self) -> "RigRenderer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
