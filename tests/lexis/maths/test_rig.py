"""Angles between cameras follow from where they look."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexis.maths.rig import camera_angles
from lexis.maths.se3 import between, exp, rotation_angle


def turned(yaw):
    return exp(np.array([0.0, 0.0, yaw, 0.0, 0.0, 0.0]))


def test_a_rear_camera_looks_where_the_front_camera_looks_after_half_a_turn():
    rotations = np.stack([turned(0.0), turned(np.pi)])[:, :3, :3]
    np.testing.assert_allclose(camera_angles(np.eye(4), rotations), [[0.0, np.pi], [np.pi, 0.0]], atol=1e-12)
    np.testing.assert_allclose(camera_angles(turned(np.pi), rotations), [[np.pi, 0.0], [0.0, np.pi]], atol=1e-12)


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 5), cameras=st.integers(1, 4))
def test_an_angle_is_that_between_the_poses_of_two_cameras(seed, n, cameras):
    rng = np.random.default_rng(seed)
    T_m_q, T_B_C = exp(rng.normal(size=(n, 6))), exp(rng.normal(size=(cameras, 6)))
    found = camera_angles(T_m_q, T_B_C[:, :3, :3])
    for j in range(cameras):
        for i in range(cameras):
            expected = rotation_angle(between(T_B_C[j], T_m_q @ T_B_C[i]))
            np.testing.assert_allclose(found[:, j, i], expected, atol=1e-6)


def test_one_camera_turns_exactly_as_the_body_does(rng):
    T_m_q = exp(rng.normal(size=(9, 6)))
    found = camera_angles(T_m_q, exp(rng.normal(size=(1, 6)))[:, :3, :3])
    assert (found[:, 0, 0] == rotation_angle(T_m_q)).all()
    assert found.shape == (9, 1, 1) and found.max() == pytest.approx(rotation_angle(T_m_q).max(), abs=0.0)
