from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA, BoxRoom, walk
from scipy.spatial.transform import Rotation

from lexis.config import LandmarkConfig
from lexis.features import FeatureExtractor
from lexis.landmarks import View, triangulate
from lexis.maths import se3
from lexis.maths.projection import project
from lexis.types import NO_FEATURES, Camera, Features, Intrinsics

CONFIG = LandmarkConfig()


def views_of(points, T_O_B, camera=FORWARD_CAMERA):
    """Noise-free images of points, each with a descriptor of its own."""
    descriptors = np.random.default_rng(0).integers(0, 256, (len(points), 61), np.uint8)
    views = []
    for T in T_O_B:
        in_camera = se3.transform(se3.inverse(T @ camera.T_B_C), points)
        views.append(View(T, Features(project(in_camera, camera.intrinsics).astype(np.float32), descriptors)))
    return views


@pytest.fixture
def sideways():
    """Five poses 0.25 m apart along y; the third is the keyframe."""
    T = np.tile(np.eye(4), (5, 1, 1))
    T[:, 1, 3] = 0.25 * np.arange(5)
    return T


@pytest.fixture
def points(rng):
    return rng.uniform([3.0, -1.5, -1.0], [8.0, 2.5, 1.5], (60, 3))


def test_perfect_images_give_the_exact_points(sideways, points):
    reference, *supports = (views_of(points, sideways)[i] for i in (2, 0, 1, 3, 4))
    landmarks = triangulate(reference, supports, FORWARD_CAMERA, CONFIG)
    assert len(landmarks.points) == len(points)
    truth = se3.transform(se3.inverse(reference.T_O_B), points[landmarks.feature_ids])
    np.testing.assert_allclose(landmarks.points, truth, rtol=1e-3)


def test_landmarks_do_not_depend_on_where_odometry_starts(sideways, points, rng):
    elsewhere = se3.exp(rng.normal(size=6))
    here = triangulate(*_split(views_of(points, sideways)), FORWARD_CAMERA, CONFIG)
    moved = views_of(se3.transform(elsewhere, points), elsewhere @ sideways)
    there = triangulate(*_split(moved), FORWARD_CAMERA, CONFIG)
    np.testing.assert_array_equal(here.feature_ids, there.feature_ids)
    np.testing.assert_allclose(here.points, there.points, atol=1e-3)


def test_a_view_that_disagrees_is_dropped_and_the_point_kept(sideways, points):
    reference, *supports = _split_list(views_of(points, sideways))
    spoilt = supports[1].features.keypoints.copy()
    spoilt[:10, 0] += 12.0  # moved along the epipolar lines, where the epipolar constraint cannot detect it
    supports[1] = replace(supports[1], features=replace(supports[1].features, keypoints=spoilt))
    landmarks = triangulate(reference, supports, FORWARD_CAMERA, CONFIG)
    truth = se3.transform(se3.inverse(reference.T_O_B), points[landmarks.feature_ids])
    np.testing.assert_allclose(landmarks.points, truth, rtol=1e-3)
    assert len(set(range(10)) & set(landmarks.feature_ids.tolist())) >= 8


def test_far_points_have_too_little_parallax(sideways, points):
    assert len(triangulate(*_split(views_of(points + [60.0, 0.0, 0.0], sideways)), FORWARD_CAMERA, CONFIG).points) == 0


def test_a_camera_that_only_turns_sees_no_depth(points):
    yaw = np.linspace(-0.2, 0.2, 5)
    lever = se3.inverse(FORWARD_CAMERA.T_B_C)
    turns = se3.exp(np.stack([0 * yaw, 0 * yaw, yaw, 0 * yaw, 0 * yaw, 0 * yaw], axis=1))
    T_O_C = FORWARD_CAMERA.T_B_C @ lever @ turns @ FORWARD_CAMERA.T_B_C
    T_O_C[:, :3, 3] = T_O_C[0, :3, 3]
    landmarks = triangulate(*_split(views_of(points, T_O_C @ lever)), FORWARD_CAMERA, CONFIG)
    assert landmarks.points.shape == (0, 3)


def test_no_features_and_no_supports_give_no_landmarks(sideways):
    empty = View(sideways[0], NO_FEATURES)
    assert triangulate(empty, [empty, empty], FORWARD_CAMERA, CONFIG).points.shape == (0, 3)
    assert triangulate(empty, [], FORWARD_CAMERA, CONFIG).points.shape == (0, 3)


def test_landmarks_of_a_textured_room_lie_on_its_walls(rng):
    room = BoxRoom((7.0, 6.0, 2.8), rng)
    bend = np.linspace(0.0, 1.0, 40)
    poses = walk(np.stack([3.5 + 2 * np.cos(bend), 3 + 2 * np.sin(bend)], axis=1), 0.25)
    extractor = FeatureExtractor(CONFIG)
    views = [View(T, extractor.extract(room.render(T))) for T in poses[1:6]]
    landmarks = triangulate(*_split(views), FORWARD_CAMERA, CONFIG)
    T_W_B, features = poses[3], views[2].features
    truth = room.points(T_W_B, features.keypoints[landmarks.feature_ids].astype(float))
    camera = (T_W_B @ FORWARD_CAMERA.T_B_C)[:3, 3]
    errors = np.linalg.norm(se3.transform(T_W_B, landmarks.points) - truth, axis=1) / np.linalg.norm(truth - camera, axis=1)
    assert len(errors) > 100
    assert np.median(errors) < 0.03
    assert (errors > 0.1).mean() < 0.1


def _split_list(views):
    return [views[2], views[0], views[1], views[3], views[4]]


def _split(views):
    reference, *supports = _split_list(views)
    return reference, supports


def test_a_false_match_whose_depth_is_that_of_a_camera_stops_nothing(rng):
    """The linear estimate puts such a match into the plane of a camera that saw it, where the projection is singular."""
    turn = Rotation.from_rotvec(np.radians([[0.0, 0.0, 0.0], [0.0, 18.51, 0.0], [0.0, -55.12, 0.0]]))
    T_V_R = np.tile(np.eye(4), (3, 1, 1))
    T_V_R[:, :3, :3] = turn.as_matrix()
    T_V_R[1:, :3, 3] = [[-0.048343, 0.000139, 0.234008], [0.152942, -0.014453, -0.179848]]
    pixels = np.array([[369.25036621, 141.45582581], [170.92623901, 184.57714844], [164.18553162, 141.71463013]])
    intrinsics = Intrinsics(480, 360, 201.3839, 201.3839, 239.5, 179.5)
    camera = Camera(intrinsics, np.eye(4))
    many = (pixels + rng.normal(0.0, 0.5, (2000, 3, 2))).astype(np.float32)
    descriptors = rng.integers(0, 256, (2000, 61), np.uint8)
    views = [View(se3.inverse(T), Features(many[:, i], descriptors)) for i, T in enumerate(T_V_R)]
    everything = replace(CONFIG, epipolar_px=1000.0, max_reprojection_px=1e9, min_parallax_rad=1e-9)
    landmarks = triangulate(views[0], views[1:], camera, everything)
    assert landmarks.points.shape == (len(landmarks.feature_ids), 3)
