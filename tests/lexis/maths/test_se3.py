import gtsam
import numpy as np
import pytest

from lexis.maths import se3


@pytest.fixture
def twists(rng):
    return rng.normal(size=(20, 6))


def test_a_motion_after_its_inverse_is_no_motion(twists):
    T = se3.exp(twists)
    np.testing.assert_allclose(se3.inverse(T) @ T, np.broadcast_to(np.eye(4), T.shape), atol=1e-12)


def test_between_makes_inner_letters_cancel(twists):
    T_a_b, T_a_c = se3.exp(twists[:10]), se3.exp(twists[10:])
    np.testing.assert_allclose(T_a_b @ se3.between(T_a_b, T_a_c), T_a_c, atol=1e-12)


def test_a_nearly_orthonormal_rotation_becomes_the_nearest_rotation(twists, rng):
    T = se3.exp(twists)
    near = T.copy()
    near[:, :3, :3] += 1e-6 * rng.normal(size=(20, 3, 3))
    u, _, vt = np.linalg.svd(near[:, :3, :3])
    found = se3.orthonormal(near)
    np.testing.assert_allclose(found[:, :3, :3], u @ vt, atol=1e-11)
    np.testing.assert_array_equal(found[:, :, 3], near[:, :, 3])
    np.testing.assert_allclose(se3.orthonormal(T), T, atol=1e-15)


def test_between_broadcasts_one_pose_against_many(twists):
    T = se3.exp(twists)
    np.testing.assert_array_equal(se3.between(T[0], T)[7], se3.between(T[0], T[7]))


def test_exp_log_and_adjoint_agree_with_gtsam(twists):
    T = se3.exp(twists)
    for one, xi, Ad in zip(T, twists, se3.adjoint(T), strict=True):
        pose = gtsam.Pose3.Expmap(xi)
        np.testing.assert_allclose(one, pose.matrix(), atol=1e-12)
        np.testing.assert_allclose(se3.log(one), gtsam.Pose3.Logmap(pose), atol=1e-9)
        np.testing.assert_allclose(Ad, pose.AdjointMap(), atol=1e-12)


def test_adjoint_moves_a_perturbation_from_right_to_left(twists):
    T, xi = se3.exp(twists[0]), 0.1 * twists[1]
    np.testing.assert_allclose(T @ se3.exp(xi), se3.exp(se3.adjoint(T) @ xi) @ T, atol=1e-12)


def test_transform_composes(twists, rng):
    first, second = se3.exp(twists[:2])
    points = rng.normal(size=(5, 3))
    np.testing.assert_allclose(
        se3.transform(first @ second, points), se3.transform(first, se3.transform(second, points)), atol=1e-12
    )


def test_skew_is_the_cross_product(rng):
    v, w = rng.normal(size=(2, 6, 3))
    np.testing.assert_allclose((se3.skew(v) @ w[..., None])[..., 0], np.cross(v, w), atol=1e-12)


def test_compose_covariance_is_that_of_sampled_motions(rng):
    scale = np.diag(rng.uniform(0.5, 2.0, 6)) * 0.01
    first, second = scale @ scale, 4 * scale @ scale
    T_first, T_second = se3.exp(rng.normal(size=(2, 6)))
    noisy_first = T_first @ se3.exp(rng.multivariate_normal(np.zeros(6), first, 20_000))
    noisy_second = T_second @ se3.exp(rng.multivariate_normal(np.zeros(6), second, 20_000))
    errors = se3.log(se3.between(T_first @ T_second, noisy_first @ noisy_second))
    predicted = se3.compose_covariance(first, T_second, second)
    np.testing.assert_allclose(np.cov(errors.T), predicted, atol=0.05 * predicted.max())


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.5, np.pi - 1e-9, np.pi])
def test_rotation_angle_is_exact_to_both_ends(angle, rng):
    axis = rng.normal(size=3)
    T = se3.exp(np.append(angle * axis / np.linalg.norm(axis), rng.normal(size=3)))
    assert se3.rotation_angle(T) == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize("spoil", [np.diag([-1.0, 1, 1, 1]), np.diag([1.01, 1, 1, 1]), np.full((4, 4), np.nan)])
def test_is_rigid_refuses_reflections_scale_and_nan(spoil, twists):
    T = se3.exp(twists)
    assert se3.is_rigid(T).all()
    assert not se3.is_rigid(T @ spoil).any()


@pytest.mark.parametrize(
    ("entry", "value", "rigid"),
    [((0, 0), np.inf, False), ((1, 3), np.inf, False), ((3, 1), 1e-3, False), ((3, 3), 2.0, False), ((2, 3), 1e7, True)],
)
def test_one_matrix_is_rigid_if_it_is_in_a_batch(entry, value, rigid, twists):
    T = se3.exp(twists)
    T[:, *entry] = value
    assert se3.is_rigid(T).tolist() == [rigid] * len(T) == [bool(se3.is_rigid(each)) for each in T]
