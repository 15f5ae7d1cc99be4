"""The pinhole camera model: conversions between pixels and points in the camera frame C."""

import numpy as np
from jaxtyping import Float, Float64

from lexis.types import Intrinsics


def project(points: Float64[np.ndarray, "*batch 3"], intrinsics: Intrinsics) -> Float64[np.ndarray, "*batch 2"]:
    """Project points in C to pixels. Points behind the camera get pixels too, mirrored, so check ``z > 0`` as well."""
    focal, centre = _calibration(intrinsics)
    return np.asarray(points[..., :2] / points[..., 2:] * focal + centre)


def project_jacobian(points: Float64[np.ndarray, "*batch 3"], intrinsics: Intrinsics) -> Float64[np.ndarray, "*batch 2 3"]:
    """Jacobian of `project` with respect to the point [px/m]."""
    x, y, z = np.moveaxis(points, -1, 0)
    zero = np.zeros_like(x)
    u = np.stack([1 / z, zero, -x / z**2], axis=-1) * intrinsics.fx
    v = np.stack([zero, 1 / z, -y / z**2], axis=-1) * intrinsics.fy
    return np.stack([u, v], axis=-2)


def rays(pixels: Float[np.ndarray, "*batch 2"], intrinsics: Intrinsics) -> Float64[np.ndarray, "*batch 3"]:
    """Viewing rays of pixels in C, scaled to depth 1 (not to unit length)."""
    focal, centre = _calibration(intrinsics)
    plane = (pixels.astype(np.float64) - centre) / focal
    return np.concatenate([plane, np.ones((*plane.shape[:-1], 1))], axis=-1)


def _calibration(intrinsics: Intrinsics) -> tuple[Float64[np.ndarray, "2"], Float64[np.ndarray, "2"]]:
    return np.array([intrinsics.fx, intrinsics.fy]), np.array([intrinsics.cx, intrinsics.cy])
