"""Evidence for a room comes from the images that show a place, and not from those that were taken there."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import build_map, random_pose, with_retired_copies

from lexis.maths.se3 import exp
from lexis.planning.evidence import LOOK_AHEAD_M, evidence_at, shown_places
from lexis.types import Camera

NAMES = ("office", "kitchen")


def facing_walk(rng):
    """A map of a walk along x whose camera looks along x; at x > 0 lies an office, before it a kitchen."""
    x = np.arange(-4.0, 4.1, 0.25)
    labels = (x + LOOK_AHEAD_M > 0.0).astype(int)
    rooms = [(name, np.flatnonzero(labels == i).tolist()) for i, name in enumerate(("kitchen", "office"))]
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], labels, rooms, ("kitchen", "office"), rng)
    T_B_C = np.eye(4)
    T_B_C[:3, :3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    poses = np.tile(np.eye(4), (len(x), 1, 1))
    poses[:, :3, 3] = lexis_map.T_W_B[:, :3, 3]
    return replace(lexis_map, T_W_B=poses, camera=replace(lexis_map.camera, T_B_C=T_B_C))


def test_images_show_the_place_ahead_of_the_camera(rng):
    lexis_map = facing_walk(rng)
    ahead = shown_places(lexis_map) - lexis_map.T_W_B[:, :3, 3]
    assert np.allclose(ahead, [LOOK_AHEAD_M, 0.0, 0.0])


def test_the_images_of_a_rig_show_the_mean_of_the_places_ahead_of_its_cameras(rng):
    """The similarities of a keyframe are the mean over its cameras, here to the front, the rear and the left."""
    lexis_map = facing_walk(rng)
    front = lexis_map.camera
    rear, left = (Camera(front.intrinsics, turned(yaw) @ front.T_B_C) for yaw in (np.pi, np.pi / 2))
    for others, ahead in (((rear,), [0, 0, 0]), ((rear, left), [0, LOOK_AHEAD_M / 3, 0])):
        of_rig = replace(lexis_map, camera=replace(front, others=others))
        np.testing.assert_allclose(shown_places(of_rig) - of_rig.T_W_B[:, :3, 3], np.tile(ahead, (33, 1)), atol=1e-12)


def turned(yaw):
    """A rotation about z [rad]."""
    return exp(np.array([0.0, 0.0, yaw, 0.0, 0.0, 0.0]))


def test_evidence_changes_its_sign_at_the_boundary_of_the_places_and_not_of_the_images(rng):
    lexis_map = facing_walk(rng)
    x, everywhere = lexis_map.T_W_B[:, 0, 3], np.arange(len(lexis_map.keyframes))
    evidence = evidence_at(lexis_map, "office", everywhere)
    assert (evidence[x > 0.5] > 0.0).all() and (evidence[x < -0.5] < 0.0).all()
    assert np.allclose(evidence, -evidence_at(lexis_map, "kitchen", everywhere))


def test_evidence_does_not_depend_on_the_frame_of_the_map(rng):
    lexis_map = facing_walk(rng)
    moved = replace(lexis_map, T_W_B=random_pose(rng, (3.0, -7.0, 1.0)) @ lexis_map.T_W_B)
    some = np.arange(0, len(lexis_map.keyframes), 3)
    assert (evidence_at(moved, "office", some) == evidence_at(lexis_map, "office", some)).all()


def test_a_room_is_no_more_in_doubt_the_more_often_its_neighbour_is_visited(rng):
    """Keyframes of later visits have retired, and have the images of their anchors, which count once."""
    often = [with_retired_copies(two_images(rng), 1, copies) for copies in (0, 1, 10)]
    evidence = [evidence_at(each, "office", np.array([0]))[0] for each in often]
    assert evidence == [evidence[0]] * 3 and evidence[0] > 0.0


def test_a_retired_keyframe_far_from_what_its_anchor_sees_has_the_evidence_of_the_nearest_image(rng):
    lexis_map = with_retired_copies(two_images(rng), 1, 1)
    poses = lexis_map.T_W_B.copy()
    poses[2, 0, 3] = 50.0
    far = replace(lexis_map, T_W_B=poses)
    nearest = lexis_map.similarities[1]
    assert evidence_at(far, "office", np.array([2]))[0] == pytest.approx(nearest[0] - nearest[1])


def two_images(rng):
    """An image of an office and one of a kitchen, half a metre ahead of it."""
    lexis_map = build_map([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]], [0, 1], [("office", [0]), ("kitchen", [1])], NAMES, rng)
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 0, 3] = 0.5
    return replace(lexis_map, T_W_B=poses, similarities=np.array([[0.5, 0.1], [0.1, 0.5]]))
