import numpy as np

from lexis.maths.projection import project, project_jacobian, rays
from lexis.types import Intrinsics

K = Intrinsics(320, 240, 150.0, 140.0, 161.0, 118.0)


def points(rng):
    return rng.uniform([-2, -2, 1], [2, 2, 6], (30, 3))


def test_projection_is_the_calibration_matrix_and_a_division(rng):
    p = points(rng)
    homogeneous = p @ K.matrix.T
    np.testing.assert_allclose(project(p, K), homogeneous[:, :2] / homogeneous[:, 2:])


def test_rays_undo_projection(rng):
    p = points(rng)
    np.testing.assert_allclose(rays(project(p, K), K) * p[:, 2:], p)


def test_jacobian_is_the_finite_difference(rng):
    p, step = points(rng), 1e-6
    numeric = [(project(p + e, K) - project(p - e, K)) / (2 * step) for e in step * np.eye(3)]
    np.testing.assert_allclose(project_jacobian(p, K), np.stack(numeric, axis=-1), atol=1e-5)
