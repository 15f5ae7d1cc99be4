"""PnP finds the pose in spite of wrong matches, and the pose of a rig fits all of its cameras."""

import numpy as np
from helpers.box_room import FORWARD_CAMERA, FRONT_REAR

from lexis.maths import se3
from lexis.maths.pnp import inlier_rows, refine_rig_pose, solve_pnp
from lexis.maths.projection import project

POSE = se3.exp(np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6]))


def seen_by(camera, T_B_P, rng, n):
    """Pixels of points ahead of a camera, and the points in P."""
    in_camera = rng.uniform([-2.0, -1.5, 2.0], [2.0, 1.5, 7.0], (n, 3))
    in_p = se3.transform(se3.inverse(T_B_P) @ camera.T_B_C, in_camera)
    return project(in_camera, camera.intrinsics), in_p


def test_wrong_matches_do_not_change_the_pose(rng):
    T_B_P = FORWARD_CAMERA.T_B_C @ POSE
    pixels, points = seen_by(FORWARD_CAMERA, T_B_P, rng, 60)
    pixels[40:] = rng.permutation(pixels[40:])
    T_C_P = solve_pnp(pixels, points, FORWARD_CAMERA.intrinsics, 3.0, 0)
    np.testing.assert_allclose(T_C_P, POSE, atol=1e-6)
    rows = inlier_rows(se3.transform(T_C_P, points), pixels, FORWARD_CAMERA.intrinsics, 3.0)
    assert set(range(40)) <= set(rows.tolist())


def test_points_behind_the_camera_do_not_agree(rng):
    pixels, points = seen_by(FORWARD_CAMERA, FORWARD_CAMERA.T_B_C, rng, 20)
    assert len(inlier_rows(points, pixels, FORWARD_CAMERA.intrinsics, 1.0)) == 20
    assert len(inlier_rows(-points, pixels, FORWARD_CAMERA.intrinsics, 1.0)) == 0


def test_the_refined_pose_of_a_rig_fits_all_of_its_cameras(rng):
    seen = [seen_by(camera, POSE, rng, count) for camera, count in zip(FRONT_REAR.rig, (30, 12), strict=True)]
    start = POSE @ se3.exp(np.full(6, 0.01))
    np.testing.assert_allclose(refine_rig_pose(seen, FRONT_REAR.rig, start), POSE, atol=1e-6)
    alone = [seen[0], (np.zeros((0, 2)), np.zeros((0, 3)))]
    np.testing.assert_allclose(refine_rig_pose(alone, FRONT_REAR.rig, start), POSE, atol=1e-6)
