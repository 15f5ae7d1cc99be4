"""A rotation matrix that has been written as a quaternion is read back identically, bit by bit."""

import numpy as np
from scipy.spatial.transform import Rotation

from lexis.maths.quaternions import as_quaternions, as_rotations, pose_rows, poses_of


def rotations(rng):
    """Rotations in general, and common special ones: quarter turns, rotations about z, the identity."""
    yaw = np.append(rng.uniform(-4, 4, 5000), np.radians(np.arange(-360, 361, 15)))
    level = Rotation.from_rotvec(yaw[:, None] * [0.0, 0.0, 1.0])
    tilted = level * Rotation.from_rotvec(rng.normal(0.0, 0.01, (len(yaw), 3)))
    cube = Rotation.create_group("O")
    parts = Rotation.random(20_000, random_state=3), level, tilted, cube, Rotation.identity(1)
    return np.concatenate([part.as_matrix() for part in parts])


def test_the_second_time_nothing_changes(rng):
    once = as_rotations(as_quaternions(rotations(rng)))
    np.testing.assert_array_equal(as_rotations(as_quaternions(once)), once)
    np.testing.assert_array_equal(as_quaternions(once), as_quaternions(as_rotations(as_quaternions(once))))


def test_the_first_time_changes_next_to_nothing(rng):
    given = rotations(rng)
    quaternions = as_quaternions(given)
    np.testing.assert_allclose(as_rotations(quaternions), given, atol=1e-11)
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-15)
    assert (quaternions[:, 3] >= 0).all()


def test_poses_keep_their_positions(rng):
    poses = np.tile(np.eye(4), (50, 1, 1))
    poses[:, :3, :3] = rotations(rng)[:50]
    poses[:, :3, 3] = rng.normal(0, 100, (50, 3))
    rows = pose_rows(poses)
    np.testing.assert_array_equal(poses_of(rows)[:, :3, 3], poses[:, :3, 3])
    np.testing.assert_array_equal(pose_rows(poses_of(rows)), rows)
    assert pose_rows(poses[:0]).shape == (0, 7) and poses_of(rows[:0]).shape == (0, 4, 4)
