"""`Distortion` and `Lens`: a pinhole image, distorted as by a radial-tangential lens.

MuJoCo renders pinhole images only. The caller therefore renders a wider pinhole image, and `Lens` resamples it: each pixel
of the distorted image is undistorted, by Newton's method, to find its place in the pinhole image.
"""

from dataclasses import astuple, dataclass

import cv2
import numpy as np
from jaxtyping import Float64, Shaped, UInt8

from lexis.types import Camera, Intrinsics
from sim.errors import SimError

_ITERATIONS = 30
"""Number of steps of Newton's method."""
_RESIDUAL = 1e-9
"""Largest error of an undistorted point after it is distorted again, on the image plane at distance 1."""
_MARGIN_PX = 2
"""Margin that the pinhole image has around all points that are looked up in it [px], for interpolation."""
_WIDEST = 4
"""Largest width and height of the rendered pinhole image, as multiples of the distorted image's width and height."""
_STEPS = 50
"""Number of points between centre and border at which the distortion is tested for folds (parts that are seen twice)."""


@dataclass(frozen=True)
class Distortion:
    """Coefficients of the radial-tangential model of OpenCV and EuRoC. Raises `SimError` unless they are finite.

    `bool(distortion)` is False if all coefficients are zero.
    """

    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0

    def __post_init__(self) -> None:
        if not all(map(np.isfinite, astuple(self))):
            raise SimError(f"distortion: coefficients are {astuple(self)}; valid: finite numbers")

    @property
    def coefficients(self) -> tuple[float, float, float, float]:
        """The coefficients in OpenCV's order."""
        return self.k1, self.k2, self.p1, self.p2

    @property
    def decimals(self) -> tuple[str, str, str, str]:
        """The coefficients as text without exponents, because some YAML readers take 1e-05 as a string."""
        k1, k2, p1, p2 = (np.format_float_positional(value, trim="0") for value in self.coefficients)
        return k1, k2, p1, p2

    def __bool__(self) -> bool:
        return any(self.coefficients)

    def distort(self, points: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, "n 2"]:
        """Return the distorted positions of points; all points are on the image plane at distance 1."""
        square = (points**2).sum(axis=1, keepdims=True)
        twice = 2.0 * points.prod(axis=1, keepdims=True)
        tangential = twice * [self.p1, self.p2] + (square + 2.0 * points**2) * [self.p2, self.p1]
        return np.asarray(points * (1.0 + square * (self.k1 + square * self.k2)) + tangential)

    def undistort(self, points: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, "n 2"]:
        """Return the inverse of `distort`, computed by Newton's method. Raises `SimError` if that does not converge."""
        straight = points
        with np.errstate(all="ignore"):
            for _ in range(_ITERATIONS):
                straight = straight - self._newton_step(straight, self.distort(straight) - points)
            found = np.abs(self.distort(straight) - points).max(axis=1) < _RESIDUAL
        if not found.all():
            raise self._too_strong()
        return straight

    def check_no_fold(self, straight: Float64[np.ndarray, "n 2"]) -> None:
        """Raise `SimError` if the distorted image folds over between its centre and any of the points `straight`.

        `straight` are undistorted points. Where an image folds over, it shows parts of the view twice. It does so where the
        Jacobian of the distortion is not positive definite.
        """
        for share in np.linspace(0.0, 1.0, _STEPS).tolist():
            along_x, mixed, along_y = self._slopes(share * straight)
            if (along_x * along_y <= mixed**2).any() or (along_x <= 0.0).any():
                raise self._too_strong()

    def _newton_step(
        self, points: Float64[np.ndarray, "n 2"], error: Float64[np.ndarray, "n 2"]
    ) -> Float64[np.ndarray, "n 2"]:
        along_x, mixed, along_y = self._slopes(points)
        x, y = error.T
        solved = np.stack([along_y * x - mixed * y, along_x * y - mixed * x], axis=-1)
        return np.asarray(solved / (along_x * along_y - mixed**2)[:, None])

    def _slopes(self, points: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, "3 n"]:
        """Return three entries of the Jacobian of `distort`, which is symmetric: dx/dx, dx/dy = dy/dx, and dy/dy."""
        x, y = points.T
        square = x**2 + y**2
        radial, slope = 1.0 + square * (self.k1 + square * self.k2), 2.0 * (self.k1 + 2.0 * self.k2 * square)
        mixed = slope * x * y + 2.0 * (self.p1 * x + self.p2 * y)
        along_x = radial + slope * x**2 + 2.0 * self.p1 * y + 6.0 * self.p2 * x
        along_y = radial + slope * y**2 + 6.0 * self.p1 * y + 2.0 * self.p2 * x
        return np.stack([along_x, mixed, along_y])

    def _too_strong(self) -> SimError:
        return SimError(
            f"distortion: {self.coefficients} shows parts of the view twice or not at all; valid: weaker coefficients, or "
            "a narrower field of view"
        )


class Lens:
    """Distorts images of a wider pinhole camera, as if they were taken with the given intrinsics and distortion.

    Raises `SimError` if the distortion cannot be inverted in the image, or if `pinhole` would be too wide.
    """

    def __init__(self, intrinsics: Intrinsics, distortion: Distortion) -> None:
        k = intrinsics
        border = distortion.undistort(_border(k))
        distortion.check_no_fold(border)
        border = border * [k.fx, k.fy] + [k.cx, k.cy]
        (left, top), (right, bottom) = np.floor(border.min(axis=0)) - _MARGIN_PX, np.ceil(border.max(axis=0)) + _MARGIN_PX
        width, height = int(right - left) + 1, int(bottom - top) + 1
        if width > _WIDEST * k.width or height > _WIDEST * k.height:
            raise SimError(
                f"distortion: {distortion.coefficients} needs a pinhole of {width} x {height} px; valid: weaker coefficients"
            )
        self.pinhole = Intrinsics(width, height, k.fx, k.fy, float(k.cx - left), float(k.cy - top))
        """Intrinsics of the image to render: the camera's focal lengths, but another image size and principal point."""
        v, u = np.mgrid[: k.height, : k.width]
        pixels = np.stack([u.ravel(), v.ravel()], axis=-1).astype(np.float64)
        straight = distortion.undistort((pixels - [k.cx, k.cy]) / [k.fx, k.fy])
        at = straight * [k.fx, k.fy] + [self.pinhole.cx, self.pinhole.cy]
        self._at = at.astype(np.float32).reshape(k.height, k.width, 2)

    def image(self, image: UInt8[np.ndarray, "h w 3"]) -> UInt8[np.ndarray, "i j 3"]:
        """Distort an image that was rendered with `pinhole`, by bicubic interpolation."""
        return np.asarray(cv2.remap(image, self._at[..., 0], self._at[..., 1], cv2.INTER_CUBIC), np.uint8)

    def nearest(self, values: Shaped[np.ndarray, "h w"]) -> Shaped[np.ndarray, "i j"]:
        """Distort a depth image or an image of ids. Pixels get the nearest value; interpolated values would be wrong."""
        u, v = np.moveaxis(np.rint(self._at).astype(int), -1, 0)
        return np.asarray(values[v, u])


def rendered_camera(camera: Camera, distortion: Distortion) -> Camera:
    """Return the wider pinhole camera to render for a camera with a distortion. Raises `SimError` as `Lens` does.

    The further cameras of a rig have the same distortion.
    """
    others = tuple(rendered_camera(other, distortion) for other in camera.others)
    return Camera(Lens(camera.intrinsics, distortion).pinhole, camera.T_B_C, others)


def _border(k: Intrinsics) -> Float64[np.ndarray, "n 2"]:
    """Return the image's border pixels as points of the image plane at distance 1."""
    across, down = np.arange(k.width), np.arange(k.height)
    sides = [np.stack(np.broadcast_arrays(across, v), axis=-1) for v in (0, k.height - 1)]
    sides += [np.stack(np.broadcast_arrays(u, down), axis=-1) for u in (0, k.width - 1)]
    return np.asarray((np.concatenate(sides) - [k.cx, k.cy]) / [k.fx, k.fy])
