"""Rigid motions as 4x4 matrices, vectorised over leading axes. Tangent vectors are rotation first, as in GTSAM."""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial.transform import RigidTransform

Transforms = Float64[np.ndarray, "*batch 4 4"]
_Entries: TypeAlias = Any
"""One entry of a single matrix (a number), or of each matrix of a batch (an array)."""


def inverse(T_a_b: Transforms) -> Transforms:
    """The inverse ``T_b_a``, computed by transposing the rotation instead of a general matrix inversion."""
    rotation = T_a_b[..., :3, :3].swapaxes(-1, -2)
    result = np.zeros(T_a_b.shape)
    result[..., :3, :3] = rotation
    result[..., :3, 3:] = -(rotation @ T_a_b[..., :3, 3:])
    result[..., 3, 3] = 1.0
    return result


def between(
    T_a_b: Float64[np.ndarray, "*first 4 4"], T_a_c: Float64[np.ndarray, "*second 4 4"]
) -> Float64[np.ndarray, "*out 4 4"]:
    """The relative pose ``T_b_c`` of the second pose in the frame of the first. Leading axes broadcast."""
    return np.asarray(inverse(T_a_b) @ T_a_c)


def orthonormal(T: Transforms) -> Transforms:
    """Return rigid motions whose rotations are orthonormal to the last digits, for rotations that nearly are.

    This is one Newton step towards the nearest rotation (polar decomposition), which squares the deviation. Without it, a
    product of many poses adds up the deviations that `is_rigid` tolerates.
    """
    rotation, result = T[..., :3, :3], T.copy()
    result[..., :3, :3] = rotation @ (1.5 * np.eye(3) - 0.5 * rotation.swapaxes(-1, -2) @ rotation)
    return result


def transform(T_a_b: Float64[np.ndarray, "4 4"], points: Float64[np.ndarray, "*n 3"]) -> Float64[np.ndarray, "*n 3"]:
    """Transform points from frame b to frame a."""
    return np.asarray(points @ T_a_b[:3, :3].T + T_a_b[:3, 3])


def skew(vectors: Float64[np.ndarray, "*batch 3"]) -> Float64[np.ndarray, "*batch 3 3"]:
    """The skew-symmetric matrix ``[v]x`` with ``skew(v) @ w == cross(v, w)``."""
    matrix = np.zeros((*vectors.shape, 3))
    for row, column, entry in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
        matrix[..., row, column] = vectors[..., entry]
        matrix[..., column, row] = -vectors[..., entry]
    return matrix


def exp(tangents: Float64[np.ndarray, "*batch 6"]) -> Transforms:
    """The exponential map: the motion of a constant twist ``(rotation [rad], translation [m])`` in unit time."""
    return RigidTransform.from_exp_coords(tangents).as_matrix()


def upright(yaw_rad: float, position: Sequence[float] | Float64[np.ndarray, "3"]) -> Float64[np.ndarray, "4 4"]:
    """Return the pose that is turned about the vertical axis by `yaw_rad` [rad], at a position [m]."""
    T = exp(np.array([0.0, 0.0, yaw_rad, 0.0, 0.0, 0.0]))
    T[:3, 3] = position
    return T


def log(T: Transforms) -> Float64[np.ndarray, "*batch 6"]:
    """The logarithm map, the inverse of `exp`. Tangents are ``(rotation [rad], translation [m])``."""
    return RigidTransform.from_matrix(T).as_exp_coords()


def adjoint(T: Transforms) -> Float64[np.ndarray, "*batch 6 6"]:
    """The adjoint matrix ``Ad`` with ``T @ exp(x) == exp(Ad @ x) @ T``."""
    rotation = T[..., :3, :3]
    result = np.zeros((*T.shape[:-2], 6, 6))
    result[..., :3, :3] = result[..., 3:, 3:] = rotation
    result[..., 3:, :3] = skew(T[..., :3, 3]) @ rotation
    return result


def compose_covariance(
    first: Float64[np.ndarray, "6 6"], T_second: Float64[np.ndarray, "4 4"], second: Float64[np.ndarray, "6 6"]
) -> Float64[np.ndarray, "6 6"]:
    """Covariance of ``T_first @ T_second`` to first order, for independent perturbations on the right [rad², m²]."""
    Ad = adjoint(inverse(T_second))
    return np.asarray(Ad @ first @ Ad.T + second)


def rotation_angle(T: Float64[np.ndarray, "*batch k k"]) -> Float64[np.ndarray, "*batch"]:
    """Angle of the rotation, in [0, pi] [rad]. The matrices are rigid motions (4x4) or rotations (3x3)."""
    x, y, z = T[..., 2, 1] - T[..., 1, 2], T[..., 0, 2] - T[..., 2, 0], T[..., 1, 0] - T[..., 0, 1]
    trace = T[..., 0, 0] + T[..., 1, 1] + T[..., 2, 2]
    return np.asarray(np.arctan2(np.sqrt(x * x + y * y + z * z), trace - 1.0))


def is_rigid(T: Transforms, tolerance: float = 1e-6) -> Bool[np.ndarray, "*batch"]:
    """Whether each matrix is finite, with 0 0 0 1 as last row and a right-handed rotation, orthonormal within tolerance."""
    # The formulas work on arrays of entries and on numbers; for a single matrix, numbers are several times faster.
    columns = T.T.tolist() if T.ndim == 2 else np.moveaxis(T, (-1, -2), (0, 1))
    with np.errstate(over="ignore", invalid="ignore"):  # huge values and NaN must give False, not a warning
        (*x, x3), (*y, y3), (*z, z3), (*t, t3) = columns
        rigid = (x3 == 0.0) & (y3 == 0.0) & (z3 == 0.0) & (t3 == 1.0)
        rigid &= (abs(t[0]) < np.inf) & (abs(t[1]) < np.inf) & (abs(t[2]) < np.inf)
        for a, b, product in ((x, x, 1.0), (y, y, 1.0), (z, z, 1.0), (x, y, 0.0), (y, z, 0.0), (z, x, 0.0)):
            rigid &= abs(_dot(a, b) - product) <= tolerance
        cross = y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]
        return np.asarray(rigid & (_dot(x, cross) > 0.0))


def _dot(a: Sequence[_Entries], b: Sequence[_Entries]) -> _Entries:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
