"""A textured box-shaped room, rendered from inside by ray casting: exact geometry for tests without the simulator."""

from dataclasses import replace

import cv2
import numpy as np
from jaxtyping import Float64

from lexis.maths.projection import rays
from lexis.types import Camera, Image, Intrinsics

_PIXELS_PER_M = 80
_FACE_AXES = ((1, 2), (0, 2), (0, 1))

FORWARD_CAMERA = Camera(
    Intrinsics(320, 240, 140.0, 140.0, 159.5, 119.5),
    np.array([[0.0, 0.0, 1.0, 0.1], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.2], [0.0, 0.0, 0.0, 1.0]]),
)
"""A camera with a field of view of about 98°; it looks forward and sits slightly ahead of and above the body's origin."""

_BACKWARDS = np.diag([-1.0, -1.0, 1.0, 1.0])
FRONT_REAR = replace(FORWARD_CAMERA, others=(replace(FORWARD_CAMERA, T_B_C=_BACKWARDS @ FORWARD_CAMERA.T_B_C),))
"""A rig of `FORWARD_CAMERA` and a camera that looks back, 0.2 m behind it."""


class BoxRoom:
    """The box from the origin to `size` [m]; every face has a texture of its own."""

    def __init__(self, size: tuple[float, float, float], rng: np.random.Generator) -> None:
        self.size = np.array(size)
        self._faces = {
            (axis, side): _texture(self.size[list(_FACE_AXES[axis])], rng) for axis in range(3) for side in (0, 1)
        }

    def render(self, T_W_B: Float64[np.ndarray, "4 4"], camera: Camera = FORWARD_CAMERA) -> Image:
        """The image seen from a body pose inside the box."""
        axis, hit = self._cast(T_W_B @ camera.T_B_C, camera.intrinsics)
        image = np.zeros((*axis.shape, 3), np.uint8)
        for (face, side), texture in self._faces.items():
            on_face = (axis == face) & ((hit[..., face] > self.size[face] / 2) == bool(side))
            v, u = (np.float32(hit[..., i] * _PIXELS_PER_M - 0.5) for i in _FACE_AXES[face])
            seen = cv2.remap(texture, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
            image[on_face] = seen[on_face]
        return image

    def points(
        self, T_W_B: Float64[np.ndarray, "4 4"], pixels: Float64[np.ndarray, "n 2"], camera: Camera = FORWARD_CAMERA
    ) -> Float64[np.ndarray, "n 3"]:
        """The points at which the rays through pixels hit the walls, in W [m]."""
        T_W_C = T_W_B @ camera.T_B_C
        return self._meet(T_W_C[:3, 3], rays(pixels, camera.intrinsics) @ T_W_C[:3, :3].T)[1]

    def _cast(
        self, T_W_C: Float64[np.ndarray, "4 4"], intrinsics: Intrinsics
    ) -> tuple[np.ndarray, Float64[np.ndarray, "h w 3"]]:
        v, u = np.mgrid[: intrinsics.height, : intrinsics.width]
        directions = rays(np.stack([u, v], axis=-1).astype(float), intrinsics) @ T_W_C[:3, :3].T
        return self._meet(T_W_C[:3, 3], directions)

    def _meet(self, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The axis normal to the wall that each ray hits first, and the point where it hits."""
        with np.errstate(divide="ignore"):
            reach = np.where(directions > 0, self.size - origin, -origin) / directions
        reach = np.where(directions == 0, np.inf, reach)
        axis = reach.argmin(axis=-1)
        return axis, origin + directions * reach.min(axis=-1)[..., None]


def walk(waypoints: np.ndarray, step_m: float, height_m: float = 1.0) -> Float64[np.ndarray, "n 4 4"]:
    """Body poses along a polyline in the plane at `height_m`, facing a smoothed direction of travel."""
    lengths = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    s = np.arange(0.0, along[-1], step_m)
    x, y = np.interp(s, along, waypoints[:, 0]), np.interp(s, along, waypoints[:, 1])
    yaw = np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))
    poses = np.tile(np.eye(4), (len(s), 1, 1))
    poses[:, 0, 0] = poses[:, 1, 1] = np.cos(yaw)
    poses[:, 1, 0] = np.sin(yaw)
    poses[:, 0, 1] = -np.sin(yaw)
    poses[:, :3, 3] = np.stack([x, y, np.full(len(s), height_m)], axis=1)
    return poses


def _texture(size_m: np.ndarray, rng: np.random.Generator) -> Image:
    """A texture of blobs at several scales: rich in corners and without repetition."""
    shape = tuple(np.ceil(size_m * _PIXELS_PER_M).astype(int))
    image = np.zeros((*shape, 3), np.float32)
    for cell in (4, 8, 24, 64):
        coarse = rng.random((shape[0] // cell + 2, shape[1] // cell + 2, 3), np.float32)
        image += cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_NEAREST)
    image = cv2.GaussianBlur(image, (0, 0), 1.0)
    return np.uint8(255 * (image - image.min()) / np.ptp(image))
