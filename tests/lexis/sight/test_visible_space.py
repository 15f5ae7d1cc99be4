"""Visible space lies between camera and landmarks, and who sees whom depends on relative poses alone."""

import numpy as np
import pytest
from helpers.landmarks import without_key_points
from hypothesis import given
from hypothesis import strategies as st

from lexis.config import SightConfig
from lexis.maths.se3 import exp, inverse, transform
from lexis.sight.visible_space import OBSTACLE_RANGE_M, VisibleSpace, sight, space_in_view
from lexis.types import NO_FEATURES, Keyframe

FORWARD = np.array([[0.0, 0.0, 1.0, 0.1], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.2], [0.0, 0.0, 0.0, 1.0]])
"""A camera on a body with x forward and z up that looks forward."""
NEAR_M = 0.7


def keyframe(points, T_O_B=None):
    """A keyframe that has these landmarks in its body frame."""
    points = np.asarray(points, float).reshape(-1, 3)
    landmarks = without_key_points(points)
    pose = np.eye(4) if T_O_B is None else T_O_B
    return Keyframe(0, 0, 0.0, pose, np.eye(6), np.ones(2, np.float32), NO_FEATURES, landmarks)


def scattered(rng, n):
    """Poses of upright bodies in a room of 6 m, and the spaces of their cameras."""
    poses = exp(np.stack([np.r_[0.0, 0.0, yaw, np.zeros(3)] for yaw in rng.uniform(-3, 3, n)]))
    poses[:, :3, 3] = rng.uniform(0.0, 6.0, (n, 3)) * [1.0, 1.0, 0.1]
    spaces = [space_in_view(keyframe(rng.normal(size=(20, 3)) * 2.0), FORWARD, SightConfig()) for _ in range(n)]
    return poses, spaces


def slow_sight(spaces, T_W_B):
    """The definition, place by place."""
    T_W_C = T_W_B @ FORWARD
    n = len(spaces)
    shares = np.zeros((n, n))
    for j, space in enumerate(spaces):
        for place, weight in zip(transform(T_W_C[j], space.places), space.weights, strict=True):
            shares[np.linalg.norm(T_W_C[:, :3, 3] - place, axis=1) <= NEAR_M, j] += weight
    return shares


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 60))
def test_places_lie_at_the_height_of_the_camera_on_the_way_to_landmarks(seed, n):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-5.0, 5.0, (n, 3))
    space = space_in_view(keyframe(points), FORWARD, SightConfig(range_m=6.0, reach_m=2.0))
    places = transform(FORWARD, space.places)
    assert space.weights.sum() == pytest.approx(1.0) and (space.weights > 0).all()
    np.testing.assert_allclose(places[:, 2], FORWARD[2, 3], atol=1e-12)
    near = points[np.linalg.norm(points - FORWARD[:3, 3], axis=1) <= 6.0]
    farthest_m = np.linalg.norm((near - FORWARD[:3, 3])[:, :2], axis=1).max(initial=0.0)
    reached_m = np.linalg.norm((places - FORWARD[:3, 3])[:, :2], axis=1).max()
    assert reached_m <= min(0.5 * farthest_m, 2.0) + 1e-9


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 60))
def test_obstacles_are_the_near_landmarks_at_about_the_height_of_the_camera(seed, n):
    points = np.random.default_rng(seed).uniform(-4.0, 4.0, (n, 3))
    obstacles = transform(FORWARD, space_in_view(keyframe(points), FORWARD, SightConfig()).obstacles)
    higher = points[:, 2] - FORWARD[2, 3]
    expected = (higher > -0.4) & (higher < 0.6) & (np.linalg.norm(points - FORWARD[:3, 3], axis=1) < OBSTACLE_RANGE_M)
    np.testing.assert_allclose(obstacles, points[expected], atol=1e-12)


@pytest.mark.parametrize(("distance_m", "visible_m"), [(2.0, 1.0), (3.0, 1.5), (4.0, 1.5)])
@pytest.mark.parametrize("bearing", np.linspace(-3.0, 3.0, 5).tolist())
def test_a_single_landmark_gives_the_first_part_of_the_way_to_it(distance_m, visible_m, bearing):
    camera, way = FORWARD[:3, 3], np.array([np.cos(bearing), np.sin(bearing), 0.0])
    landmark = camera + distance_m * way + [0.0, 0.0, 0.8]
    space = space_in_view(keyframe([landmark]), FORWARD, SightConfig(range_m=5.0, reach_m=1.5))
    places = transform(FORWARD, space.places)
    order = np.argsort(places @ way)
    np.testing.assert_allclose(places[order], [camera + visible_m * share * way for share in (0.0, 0.5, 1.0)], atol=1e-12)
    np.testing.assert_allclose(space.weights, 1.0 / 3.0)


def test_a_landmark_straight_above_the_camera_shows_the_place_of_the_camera():
    space = space_in_view(keyframe([FORWARD[:3, 3] + [0.0, 0.0, 1.0]]), FORWARD, SightConfig())
    np.testing.assert_allclose(space.places, np.zeros((1, 3)), atol=1e-12)


def test_without_landmarks_in_range_the_camera_s_own_place_is_all_that_is_seen():
    for points in ([], [[100.0, 0.0, 0.0]]):
        space = space_in_view(keyframe(points), FORWARD, SightConfig())
        np.testing.assert_array_equal(space.places, np.zeros((1, 3)))
        np.testing.assert_array_equal(space.weights, [1.0])


def test_neither_the_axes_of_the_body_nor_the_place_in_o_change_the_visible_space(rng):
    points = rng.uniform(-4.0, 4.0, (50, 3))
    T_B_N, T_O_B = exp(rng.normal(size=6)), exp(np.array([0.02, -0.03, 2.0, 5.0, 1.0, 0.5]))
    here = space_in_view(keyframe(points, T_O_B), FORWARD, SightConfig())
    moved = exp(np.array([0.0, 0.0, 1.0, 9.0, 9.0, 9.0])) @ T_O_B @ T_B_N
    there = space_in_view(keyframe(transform(inverse(T_B_N), points), moved), inverse(T_B_N) @ FORWARD, SightConfig())
    np.testing.assert_allclose(there.places, here.places, atol=1e-9)
    np.testing.assert_allclose(there.weights, here.weights, atol=1e-12)


@given(seed=st.integers(0, 2**32 - 1), level=st.booleans())
def test_the_last_bits_of_a_pose_change_nothing_but_last_bits(seed, level):
    rng = np.random.default_rng(seed)
    points, lean = rng.uniform(-4.0, 4.0, (60, 3)).round(2), np.zeros(3) if level else rng.normal(size=3) * 0.1
    T_O_B = exp(np.r_[lean[:2], rng.uniform(-3, 3), 1.0, 2.0, 0.5])
    here = space_in_view(keyframe(points, T_O_B), FORWARD, SightConfig())
    shaken = space_in_view(keyframe(points, T_O_B @ exp(rng.normal(size=6) * 1e-15)), FORWARD, SightConfig())
    assert len(here.places) == len(shaken.places)
    np.testing.assert_allclose(shaken.places, here.places, atol=1e-9)


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 12))
def test_sight_is_the_share_of_places_nearby(seed, n):
    poses, spaces = scattered(np.random.default_rng(seed), n)
    np.testing.assert_allclose(sight(spaces, poses, FORWARD, NEAR_M).toarray(), slow_sight(spaces, poses), atol=1e-12)


def test_sight_does_not_depend_on_the_world_s_frame(rng):
    poses, spaces = scattered(rng, 30)
    here = sight(spaces, poses, FORWARD, NEAR_M).toarray()
    there = sight(spaces, exp(np.array([0.3, -0.1, 2.0, 40.0, -9.0, 3.0])) @ poses, FORWARD, NEAR_M).toarray()
    assert here.any() and not here.all()
    np.testing.assert_allclose(there, here, atol=1e-9)


def test_a_camera_that_looks_straight_down_sees_space_around_it():
    down = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.0], [0.0, 0.0, 0.0, 1.0]])
    space = space_in_view(keyframe([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]), down, SightConfig())
    places = transform(down, space.places)
    np.testing.assert_allclose(places[:, 2], 1.0, atol=1e-12)
    assert places[:, 0].max() == pytest.approx(1.0) and places[:, 1].max() == pytest.approx(1.0)


def test_nobody_sees_through_a_wall():
    facing_the_wall = space_in_view(keyframe([[0.6, y, 0.0] for y in (-0.4, 0.0, 0.4)]), FORWARD, SightConfig())
    through_a_door = space_in_view(keyframe([[5.0, y, 0.0] for y in (-0.4, 0.0, 0.4)]), FORWARD, SightConfig())
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 0, 3] = 0.0, 0.0, 1.5  # the third keyframe stands 1.5 m ahead of the others
    sees = sight([facing_the_wall, through_a_door, VisibleSpace(np.zeros((1, 3)), np.ones(1))], poses, FORWARD, NEAR_M)
    assert sees[[2], [0]] == 0.0 and sees[[2], [1]] > 0.2
