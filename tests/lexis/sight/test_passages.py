"""A doorway on the path is found where it is, and neither a wide opening, nor low furniture, nor a single point is one."""

from functools import cache

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from lexis.config import SightConfig
from lexis.floors import NO_FLOOR
from lexis.maths.se3 import exp, transform
from lexis.room_labels import certain
from lexis.sight.passages import lines_of_sight, narrow_passages
from lexis.sight.room_clusters import cluster_by_sight
from lexis.sight.visible_space import OBSTACLE_RANGE_M, VisibleSpace, sight_of_cameras
from lexis.types import Camera, Intrinsics

CAMERA = Camera(Intrinsics(480, 360, 200.0, 200.0, 239.5, 179.5), np.eye(4))
"""A camera whose frame is that of the body. Only its pose matters here."""
DOOR_X, HALF_DOOR_M, HALF_WIDTH_M, LENGTH_M = 12.0, 0.45, 1.0, 24.0
WIDEST_M = SightConfig().passage_m


@cache
def corridor(half_door_m=HALF_DOOR_M, seed=0, first_m=0.5):
    """Two corridors in a row with a door between them, from x = 0 to `LENGTH_M`, walked to and fro.

    The first keyframe is at x = `first_m`. Returns the poses of the keyframes, whose z axis points upwards, and what the
    camera, which looks along the x axis of the body, sees of the walls.
    """
    walls = shapely.union_all(
        [
            shapely.box(0.0, -HALF_WIDTH_M, LENGTH_M, HALF_WIDTH_M).boundary,
            shapely.box(DOOR_X - 0.05, -HALF_WIDTH_M, DOOR_X + 0.05, -half_door_m).boundary,
            shapely.box(DOOR_X - 0.05, half_door_m, DOOR_X + 0.05, HALF_WIDTH_M).boundary,
        ]
    )
    phase, x = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi), np.arange(first_m, LENGTH_M - 0.4, 0.5)
    there = [(at, 0.2 * np.sin(0.5 * at + phase), 0.0) for at in x]
    poses = [pose(*each) for each in (*there, *((at, y, np.pi) for at, y, _ in reversed(there)))]
    spaces = [space(seen(each, walls)) for each in poses]
    return np.array(poses), spaces


def pose(x, y, yaw):
    T = exp(np.array([0.0, 0.0, yaw, 0.0, 0.0, 0.0]))
    T[:3, 3] = x, y, 1.2
    return T


def space(obstacles):
    """What a single camera sees that looks 1.5 m, or half of the way to an obstacle."""
    half = obstacles * np.minimum(0.5, 1.5 / np.maximum(np.linalg.norm(obstacles, axis=1), 1e-9))[:, None]
    places = np.concatenate([np.zeros((1, 3)), 0.5 * half, half])
    near = np.linalg.norm(obstacles, axis=1) <= OBSTACLE_RANGE_M
    return (VisibleSpace(places, np.full(len(places), 1.0 / len(places)), obstacles[near]),)


def seen(T, walls, range_m=6.0):
    """Where 80 lines of sight from a body meet the walls, in the frame of the body."""
    angles = np.linspace(-0.9, 0.9, 80)
    ahead = np.stack([np.cos(angles), np.sin(angles), np.zeros(80)], axis=1) @ T[:3, :3].T
    here = np.broadcast_to(T[:2, 3], (80, 2))
    met = shapely.intersection(shapely.linestrings(np.stack([here, here + range_m * ahead[:, :2]], axis=1)), walls)
    distances = shapely.distance(shapely.Point(T[:2, 3]), met)  # NaN where a line meets no wall
    return (ahead * distances[:, None])[np.isfinite(distances)] @ T[:3, :3]


def find(poses, spaces, widest_m=WIDEST_M, floors=None, sessions=None):
    n = len(poses)
    floors, sessions = (np.zeros(n, int) if each is None else each for each in (floors, sessions))
    lines = lines_of_sight(spaces, poses, CAMERA)
    return narrow_passages(lines, floors, poses[:, :3, 3], sessions, widest_m)


@pytest.mark.parametrize("seed", range(5))
def test_a_doorway_is_found_where_it_is_and_nothing_else(seed):
    found = find(*corridor(seed=seed))
    assert len(found.ends) == 2  # the robot goes through the door twice
    np.testing.assert_allclose(found.ends[:, :, 0], DOOR_X, atol=0.15)
    expected = np.tile([-HALF_DOOR_M, HALF_DOOR_M], (len(found.ends), 1))
    np.testing.assert_allclose(np.sort(found.ends[:, :, 1]), expected, atol=0.15)


@pytest.mark.parametrize("first_m", np.arange(0.5, 1.0, 0.05))
def test_a_doorway_is_one_passage_wherever_the_keyframes_beside_it_are(first_m):
    """If a keyframe is in the doorway, both of its steps go through narrow space, but only one of them through the wall."""
    found = find(*corridor(first_m=first_m))
    assert len(found.ends) == 2
    np.testing.assert_allclose(found.ends[:, :, 0], DOOR_X, atol=0.15)


def test_an_opening_wider_than_the_limit_is_no_passage():
    assert not len(find(*corridor(half_door_m=0.7)).ends)
    assert len(find(*corridor(half_door_m=0.7), widest_m=1.6).ends)
    assert not len(find(*corridor(), widest_m=0.0).ends)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_passages_do_not_depend_on_the_frame(seed):
    rng = np.random.default_rng(seed)
    poses, spaces = corridor(seed=1)
    moved = exp(np.r_[0.0, 0.0, rng.uniform(-3.0, 3.0), rng.uniform(-50.0, 50.0, 3)])
    here, there = find(poses, spaces), find(moved @ poses, spaces)
    flat = np.concatenate([here.ends, np.zeros((*here.ends.shape[:2], 1))], axis=2)
    np.testing.assert_allclose(transform(moved, flat.reshape(-1, 3))[:, :2], there.ends.reshape(-1, 2), atol=1e-5)


def test_points_that_only_one_image_shows_make_no_passage():
    poses = np.array([pose(x, 0.0, 0.0) for x in (0.0, 0.5, 1.0, 1.5)])
    on_both_sides = np.array([[1.2, -0.4, 0.0], [1.2, 0.4, 0.0]])
    nothing = space(np.zeros((0, 3)))
    assert not len(find(poses, [space(on_both_sides), nothing, nothing, nothing]).ends)
    twice = [space(on_both_sides), space(on_both_sides - [0.5, 0.0, 0.0]), nothing, nothing]
    assert len(find(poses, twice).ends) == 1


def test_places_that_most_images_look_through_are_not_occupied():
    poses = np.array([pose(x, 0.0, 0.0) for x in (0.0, 0.3, 0.6, 1.5)])
    on_both_sides, behind = np.array([[1.2, -0.4, 0.0], [1.2, 0.4, 0.0]]), np.array([[2.4, -0.8, 0.0], [2.4, 0.8, 0.0]])
    wrong = [space(on_both_sides - [x, 0.0, 0.0]) for x in (0.0, 0.3)]
    assert len(find(poses, [*wrong, *[space(np.zeros((0, 3)))] * 2]).ends) == 1
    more = np.concatenate([np.tile(poses[:1], (3, 1, 1)), poses])  # three more images from the first place
    assert not len(find(more, [*[space(behind)] * 3, *wrong, *[space(np.zeros((0, 3)))] * 2]).ends)


@pytest.mark.parametrize(("degrees", "is_passage"), [(90, True), (75, True), (45, False), (30, False)])
def test_a_passage_lies_across_the_path(degrees, is_passage):
    poses = np.array([pose(x, 0.0, 0.0) for x in (0.0, 1.0, 2.0)])
    side = 0.45 * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    round_a_pillar = 0.07 * np.array([(x, y, 0.0) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])
    pillars = np.array([1.5, 0.0, 0.0]) + np.concatenate([side + round_a_pillar, -side + round_a_pillar])
    seen_twice = [space(pillars), space(pillars - [1.0, 0.0, 0.0]), space(np.zeros((0, 3)))]
    assert (len(find(poses, seen_twice).ends) > 0) == is_passage


def test_nobody_goes_through_a_door_on_stairs_or_between_sessions():
    poses, spaces = corridor()
    n = len(poses)
    assert not len(find(poses, spaces, floors=np.full(n, NO_FLOOR)).ends)
    assert not len(find(poses, spaces, sessions=np.arange(n)).ends)
    assert set(find(poses, spaces, floors=np.full(n, 3)).floor.tolist()) == {3}


def test_without_landmarks_there_are_no_passages():
    poses, spaces = corridor()
    assert not len(find(poses, [space(np.zeros((0, 3)))] * len(spaces)).ends)


def test_two_corridors_with_a_door_between_them_are_two_rooms_and_one_corridor_is_one():
    def rooms(half_door_m, config):
        poses, spaces = corridor(half_door_m)
        n, lines = len(poses), lines_of_sight(spaces, poses, CAMERA)
        (seen_by,) = sight_of_cameras(spaces, poses, CAMERA, config.near_m)
        labels = np.zeros(n, int)
        found, _ = cluster_by_sight(labels, labels, poses[:, :3, 3], labels, certain(labels, 1), seen_by, lines, config)
        return found, poses[:, 0, 3]

    found, x = rooms(HALF_DOOR_M, SightConfig())
    assert len(np.unique(found)) == 2
    assert len({(room, at > DOOR_X) for room, at in zip(found, x, strict=True) if abs(at - DOOR_X) > 0.6}) == 2
    assert len(np.unique(rooms(HALF_WIDTH_M, SightConfig())[0])) == 1
    assert len(np.unique(rooms(HALF_DOOR_M, SightConfig(passage_m=0.0))[0])) == 1
