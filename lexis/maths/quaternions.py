"""Rotations as unit quaternions x y z w that can be written and read any number of times without changing a bit.

Usually, each conversion from a matrix to a quaternion and back changes the last digits by rounding. Here, all components of
a quaternion but one are rounded to multiples of 2**-40, which is coarser than the rounding errors of a conversion. The first
conversion thus changes a rotation by at most 1e-12 rad, and further conversions leave it as it is.
"""

import numpy as np
from jaxtyping import Float64
from scipy.spatial.transform import Rotation

from lexis.types import Poses

Quaternions = Float64[np.ndarray, "n 4"]

UNIT_TOLERANCE = 1e-3
"""Largest deviation from 1 of the norm of a quaternion that is read from a recorded run or a trajectory."""
_GRID = 2.0**40
_LARGE = 0.49
"""Every unit quaternion has at least one component that is larger than this in magnitude."""


def as_quaternions(rotations: Float64[np.ndarray, "n 3 3"]) -> Quaternions:
    """Convert rotation matrices that are orthonormal within 1e-6 to unit quaternions x y z w, with w >= 0.

    Three components are rounded to multiples of 2**-40, so that repeated conversions change nothing. The fourth, which is
    large, is computed from the unit norm.
    """
    if not len(rotations):
        return np.zeros((0, 4))
    exact = Rotation.from_matrix(rotations).as_quat(canonical=True)
    row = np.arange(len(exact))
    follows = np.argmax(np.abs(exact[:, ::-1]) >= _LARGE, axis=1)  # w if it is large, else z, else y, else x
    sign = np.copysign(1.0, exact[row, 3 - follows])
    result = np.round(exact * _GRID) / _GRID
    result[row, 3 - follows] = 0.0
    result[row, 3 - follows] = sign * np.sqrt(1.0 - np.square(result).sum(axis=1))
    return result


def as_rotations(quaternions: Quaternions) -> Float64[np.ndarray, "n 3 3"]:
    """Rotation matrices of quaternions x y z w."""
    return Rotation.from_quat(quaternions).as_matrix() if len(quaternions) else np.zeros((0, 3, 3))


def pose_rows(poses: Poses) -> Float64[np.ndarray, "n 7"]:
    """Convert poses to rows of tx ty tz qx qy qz qw [m]."""
    return np.column_stack([poses[:, :3, 3], as_quaternions(poses[:, :3, :3])])


def poses_of(rows: Float64[np.ndarray, "n 7"]) -> Poses:
    """Convert rows of tx ty tz qx qy qz qw [m] to poses.

    If the rows come from `pose_rows`, the inverse conversion by `pose_rows` returns the same rows to the last bit.
    """
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    poses[:, :3, :3] = as_rotations(rows[:, 3:])
    poses[:, :3, 3] = rows[:, :3]
    return poses
