"""Camera rigs: several cameras mounted on one body, and a renderer of all of them in one GL context."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from types import MappingProxyType, TracebackType
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Interval
from jaxtyping import UInt8
from scipy.spatial.transform import Rotation

from lexis.settings import Settings
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
"""Baseline of EuRoC's stereo camera, and of the Alphasense camera in the LEXIS paper [m]."""
LEVER_ARM_M = 0.15
"""Largest distance between the IMU and the cameras that `displaced` accepts [m]."""
FREE_M = 0.24
"""Horizontal distance from the IMU within which cameras are free of obstacles [m]: the body keeps 0.25 m away from these."""
_LARGEST = 1e6
"""Largest number in the lever arm of a configuration, in metres or degrees."""
_FISHEYE_PX = 480
_FISHEYE_DEG = 180.0


@dataclass(frozen=True, eq=False)
class Rig:
    """Cameras mounted on one body: pinhole cameras and fisheyes. LEXIS receives the images of all pinhole cameras."""

    name: str
    cameras: Mapping[str, Camera]
    fisheyes: Mapping[str, Fisheye] = field(default_factory=dict)

    @property
    def front(self) -> Camera:
        """The first pinhole camera; its field `others` holds the further ones. LEXIS receives the images of all of them."""
        first, *others = self.cameras.values()
        return replace(first, others=tuple(others))

    @property
    def size_px(self) -> tuple[int, int]:
        """Largest width and largest height of the images that are rendered for the rig [px]."""
        images = [*(camera.intrinsics for camera in self.cameras.values()), *(eye.face for eye in self.fisheyes.values())]
        return max(image.width for image in images), max(image.height for image in images)


def displaced(rig: Rig, offset_m: Vector, rpy_deg: Vector = (0.0, 0.0, 0.0)) -> Rig:
    """Return the rig, moved and rotated on the body, to simulate a lever arm from the origin of B (the IMU) to the cameras.

    The offset is in B [m]; the rotation is `Rz(yaw) Ry(pitch) Rx(roll)` [deg]. Raises `SimError` for values that are not
    finite, and for an offset longer than `LEVER_ARM_M`.
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
    """Compile a house into a scene that every camera of `rig` can render."""
    return build_scene(house, rig.size_px, fovy_deg(rig.front.intrinsics))


@dataclass(frozen=True)
class RigConfig(Settings, place="rig", error=SimError):
    """Settings of a camera rig: a preset of `RIGS`, the size of its images, and its mounting on the body."""

    name: str = "wide"
    width: Annotated[int, Ge(16)] = 480
    """Width of the pinhole images [px]."""
    height: Annotated[int, Ge(16)] = 360
    """Height of the pinhole images [px]."""
    hfov_deg: Annotated[float, Interval(gt=0, lt=180)] = 100.0
    """Horizontal field of view of the pinhole cameras [deg]."""
    lever_arm_m: Vector = (0.0, 0.0, 0.0)
    """Displacement of the whole rig on the body, in B [m]; see `displaced`."""
    lever_arm_rpy_deg: Vector = (0.0, 0.0, 0.0)
    """Rotation of the whole rig on the body: roll, pitch, yaw [deg]."""

    def __post_init__(self) -> None:
        """Raise `SimError` for values that are not valid."""
        super().__post_init__()
        _check_name(self.name)
        for name in ("lever_arm_m", "lever_arm_rpy_deg"):
            value = getattr(self, name)
            if not isinstance(value, Sequence) or len(value) != 3 or not all(map(_is_small, value)):
                self.refuse(name, f"three numbers up to {_LARGEST:g}")
            object.__setattr__(self, name, tuple(map(float, value)))  # JSON has lists


def _is_small(number: Any) -> bool:
    return isinstance(number, Real) and bool(abs(number) <= _LARGEST)  # type: ignore[operator]


def build_rig(config: RigConfig) -> Rig:
    """Build the rig that `config` describes. Raises `SimError` for a lever arm that `displaced` refuses."""
    rig = make_rig(config.name, config.width, config.height, config.hfov_deg)
    at_the_body = not any(config.lever_arm_m + config.lever_arm_rpy_deg)
    return rig if at_the_body else displaced(rig, config.lever_arm_m, config.lever_arm_rpy_deg)


def make_rig(name: str, width: int = 480, height: int = 360, hfov_deg: float = 100.0) -> Rig:
    """Build a preset of `RIGS` with pinhole cameras of this image size and view. Raises `SimError` for an unknown name."""
    _check_name(name)
    return RIGS[name](wide_camera(width, height, hfov_deg))


def _check_name(name: str) -> None:
    if name not in RIGS:
        raise SimError(f"unknown rig {name!r}{did_you_mean(name, RIGS)}; valid: {', '.join(RIGS)}")


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
"""Function that builds each preset from one pinhole camera. `four` is the rig of the LEXIS paper: two cameras look ahead,
one looks to the left and one to the right. The rear camera of `front-rear` recognises revisits in the opposite direction.
`fisheye` adds a fisheye camera of 180 degrees to the front pinhole camera, for tests of other software. LEXIS receives the
images of all pinhole cameras of a rig."""


def _mounted(camera: Camera, x_m: float = 0.0, y_m: float = 0.0, yaw: float = 0.0) -> Camera:
    """Return the camera moved on the body, and rotated about the body's z axis by `yaw` [rad]."""
    T_B_B = np.eye(4)
    T_B_B[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T_B_B[:2, 3] = x_m, y_m
    return replace(camera, T_B_C=T_B_B @ camera.T_B_C)


class RigRenderer:
    """Renders all cameras of a rig from poses of the body. Use it as a context manager, or call `close` at the end.

    It holds one GL context. Raises `GraphicsError` if off-screen OpenGL is missing, or if the scene was built for smaller
    images.
    """

    def __init__(self, scene: Scene, rig: Rig) -> None:
        self.scene, self._rig = scene, rig
        self._raster = Raster(scene)
        self._fisheyes = {name: FisheyeRenderer(self._raster, eye) for name, eye in rig.fisheyes.items()}

    def rgb(self, T_W_B: Pose) -> dict[str, UInt8[np.ndarray, "h w 3"]]:
        """Render the images of all cameras. Return them by the name of the camera, with fisheyes last."""
        images = {name: self._raster.rgb(T_W_B @ eye.T_B_C, eye.intrinsics) for name, eye in self._rig.cameras.items()}
        return images | {name: eye.frame(T_W_B).rgb for name, eye in self._fisheyes.items()}

    def frames(self, T_W_B: Pose) -> dict[str, RenderedFrame]:
        """Render image, depth and geom ids of each camera, by name. A fisheye's depth is the distance along pixels' rays."""
        frames = {name: self._raster.frame(T_W_B @ eye.T_B_C, eye.intrinsics) for name, eye in self._rig.cameras.items()}
        return frames | {name: eye.frame(T_W_B) for name, eye in self._fisheyes.items()}

    def close(self) -> None:
        """Release the GL context."""
        self._raster.close()

    def __enter__(self) -> "RigRenderer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
