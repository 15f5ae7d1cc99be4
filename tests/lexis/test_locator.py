"""A rig is located by all of its cameras together, whichever of them saw the place before."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA, FRONT_REAR

from lexis.config import PoseGraphConfig, VerificationConfig
from lexis.graph.pose_graph import PoseGraph
from lexis.maths import se3
from lexis.maths.projection import project
from lexis.types import NO_LANDMARKS, CameraView, Features, Keyframe, Landmarks
from lexis.verification import verify

CONFIG = VerificationConfig()
STEP = np.diag(np.repeat([0.01, 0.02], 3) ** 2)
HERE = se3.exp(np.array([0.02, -0.03, 0.2, 0.4, -0.3, 0.1]))
BACK = se3.exp(np.array([0.0, 0.0, np.pi - 0.1, 0.0, 0.0, 0.0])) @ HERE
"""Poses of the query relative to its candidate: looking the same way, and looking back."""


def view(camera, T_B_W, points, descriptors, rng, noise_px):
    """What one camera sees of the points in the world: those in its image."""
    in_body = se3.transform(T_B_W, points)
    in_camera = se3.transform(se3.inverse(camera.T_B_C), in_body)
    ahead = np.flatnonzero(in_camera[:, 2] > 0.5)
    pixels = project(in_camera[ahead], camera.intrinsics)
    inside = ((pixels > 0) & (pixels < [camera.intrinsics.width - 1, camera.intrinsics.height - 1])).all(axis=1)
    seen, pixels = ahead[inside], pixels[inside]
    pixels = pixels + rng.normal(0.0, noise_px, pixels.shape)
    features = Features(pixels.astype(np.float32), descriptors[seen])
    return CameraView(np.ones(1, np.float32), features, Landmarks(in_body[seen], np.arange(len(seen))))


def keyframe(i, camera, T_true, world, noise_px=0.0, seed=0):
    """A keyframe of all cameras of a rig at its true pose."""
    rng = np.random.default_rng(seed)
    first, *others = (view(each, se3.inverse(T_true), *world, rng, noise_px) for each in camera.rig)
    own = first.embedding, first.features, first.landmarks
    return Keyframe(i, i, 10.0 * i, T_true, STEP, *own, others=tuple(others))


@pytest.fixture
def world(rng):
    """Points on all sides."""
    points = rng.uniform(-6.0, 6.0, (300, 3)) * [1.0, 1.0, 0.3]
    points = points[np.linalg.norm(points[:, :2], axis=1) > 2.5]
    return points, rng.integers(0, 256, (len(points), 61), np.uint8)


def verified(camera, true, world, config=CONFIG, estimated=None, noise_px=0.0, seed=0, match=None):
    graph = PoseGraph(PoseGraphConfig(), camera)
    graph.add_keyframe(match or keyframe(0, camera, np.eye(4), world))
    query = keyframe(1, camera, true, world, noise_px, seed)
    graph.add_keyframe(query if estimated is None else replace(query, T_O_B=estimated))
    return verify(graph.keyframes[1], [0], graph, camera, config)


@pytest.mark.parametrize("true", [HERE, BACK], ids=["the same way", "back"])
def test_the_edge_of_a_rig_is_the_true_relative_pose(true, world):
    (edge,) = verified(FRONT_REAR, true, world).edges
    np.testing.assert_allclose(edge.T_match_query, true, atol=1e-4)


def test_without_a_rear_camera_the_way_back_is_not_recognised(world):
    assert verified(FORWARD_CAMERA, BACK, world).edges == ()
    assert len(verified(FORWARD_CAMERA, HERE, world).edges) == 1


def test_the_inliers_of_both_cameras_count_and_make_the_edge_more_certain(world):
    (alone,), (both,) = verified(FORWARD_CAMERA, HERE, world).edges, verified(FRONT_REAR, HERE, world).edges
    assert both.inliers > 1.5 * alone.inliers
    assert np.trace(both.covariance) < np.trace(alone.covariance)


def test_a_match_seen_by_another_camera_than_the_query_s_best_is_found_too(world):
    """The candidate has landmarks of its rear camera alone; the query looks back, so that its front camera sees them."""
    whole = keyframe(0, FRONT_REAR, np.eye(4), world)
    blind = replace(whole, landmarks=NO_LANDMARKS)
    (edge,) = verified(FRONT_REAR, BACK, world, match=blind).edges
    np.testing.assert_allclose(edge.T_match_query, BACK, atol=1e-4)


@pytest.mark.parametrize("true", [HERE, BACK], ids=["the same way", "back"])
def test_the_covariance_is_that_of_repeated_measurements(true, world):
    config = replace(CONFIG, ray_sigma_rad=0.5 / FRONT_REAR.intrinsics.fx, rotation_sigma_rad=1e-9, translation_sigma_m=1e-9)
    squared = []
    for seed in range(60):
        (edge,) = verified(FRONT_REAR, true, world, config, noise_px=0.5, seed=seed).edges
        error = se3.log(se3.between(edge.T_match_query, true))
        squared.append(error @ np.linalg.solve(edge.covariance, error))
    assert 4.5 < np.mean(squared) < 8.0  # chi² with 6 degrees of freedom


def test_cameras_that_look_in_other_directions_by_the_estimate_are_not_compared(world):
    """If the estimate is turned by half a turn, no pair of cameras can both overlap by the estimate and in truth."""
    turned = se3.exp(np.array([0.0, 0.0, np.pi / 2, 0.0, 0.0, 0.0])) @ HERE
    (decision,) = verified(FRONT_REAR, HERE, world, estimated=turned).decisions
    assert (decision.outcome, decision.matches) == ("few matches", 0)
    anywhere = replace(CONFIG, gate_rad=4.0, gate_m=1e9)
    assert len(verified(FRONT_REAR, HERE, world, anywhere, estimated=turned).edges) == 1


def test_the_same_key_points_in_another_arrangement_are_refused(world, rng):
    points, descriptors = world
    match = keyframe(0, FRONT_REAR, np.eye(4), (rng.permutation(points), descriptors))
    (decision,) = verified(FRONT_REAR, HERE, world, match=match).decisions
    assert decision.outcome == "few inliers" and decision.matches > 40


def test_one_image_alone_has_to_confirm_a_loop(world):
    """Sixteen inliers in two images are fewer than fifteen in one."""
    whole = keyframe(0, FRONT_REAR, np.eye(4), world)

    def few(view, count):
        kept = np.linspace(0, len(view.landmarks.points) - 1, count).astype(int)
        return Landmarks(view.landmarks.points[kept], view.landmarks.feature_ids[kept])

    def match(front, rear):
        first, second = whole.views
        others = (replace(second, landmarks=few(second, rear)),)
        return replace(whole, landmarks=few(first, front), others=others)

    config = replace(CONFIG, min_cells=1)
    (spread,) = verified(FRONT_REAR, np.eye(4), world, config, match=match(12, 12)).decisions
    (alone,) = verified(FRONT_REAR, np.eye(4), world, config, match=match(18, 2)).decisions
    assert (spread.outcome, alone.outcome) == ("few inliers", "accepted") and spread.inliers > alone.inliers
