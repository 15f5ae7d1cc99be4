"""Shortcuts lead through the rooms, and not through walls, over stairs or into the unknown: truth of two rooms."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from helpers.landmarks import without_key_points
from helpers.two_rooms import DOOR, ROOMS, two_rooms, walked_again, with_session_apart

from lexis.config import PlannerConfig
from lexis.errors import ConfigError
from lexis.floors import NO_FLOOR
from lexis.maths.se3 import between, exp, inverse, transform
from lexis.planning import shortcuts as module
from lexis.planning.shortcuts import STAIRWELL_M, points_between, shortcuts
from lexis.sight.cells import CELL_M

INSIDE = shapely.union_all([*(shapely.box(*room) for room in ROOMS.values()), shapely.box(4.0, DOOR[0], 4.1, DOOR[1])])


@pytest.fixture(scope="module")
def lexis_map():
    return two_rooms(np.random.default_rng(3))


def lines(lexis_map, pairs):
    """The shortcuts as seen from above."""
    return shapely.linestrings(lexis_map.T_W_B[pairs, :2, 3])


def test_shortcuts_leave_space_for_the_robot(lexis_map):
    pairs = shortcuts(lexis_map, PlannerConfig())
    margin = PlannerConfig().radius_m - CELL_M
    assert shapely.within(shapely.buffer(lines(lexis_map, pairs), margin), INSIDE).all()
    assert len(pairs) > 50


def test_shortcuts_are_pairs_of_one_floor_within_reach(lexis_map):
    for sight_m in (1.0, 2.0, 4.0):
        pairs = shortcuts(lexis_map, PlannerConfig(sight_m=sight_m))
        assert len(np.unique(pairs, axis=0)) == len(pairs) and (pairs[:, 0] < pairs[:, 1]).all()
        assert (lexis_map.floors[pairs] == 0).all()
        assert shapely.length(lines(lexis_map, pairs)).max() == pytest.approx(sight_m, abs=0.5)


def test_a_reach_that_needs_too_much_memory_is_refused(lexis_map):
    farthest = shortcuts(lexis_map, PlannerConfig(sight_m=20.0))
    assert shapely.length(lines(lexis_map, farthest)).max() < 20.0
    with pytest.raises(ConfigError, match=r"planner\.sight_m is 20\.1; valid: >= 0 and <= 20 m"):
        PlannerConfig(sight_m=20.1)


def test_keyframes_that_have_retired_have_at_most_one_shortcut_each(lexis_map):
    way = [*range(21, -1, -1), *range(22)]
    pairs = shortcuts(walked_again(lexis_map, 2 * way), PlannerConfig())
    active = (pairs < len(lexis_map.keyframes)).all(axis=1)
    assert pairs[active].tolist() == shortcuts(lexis_map, PlannerConfig()).tolist()
    assert 0 < (~active).sum() <= 2 * len(way) and len(np.unique(pairs[~active, 1])) == (~active).sum()


def test_a_shortcut_cuts_off_the_corner_of_the_walk(lexis_map):
    """The walk leads around the corner at (3, 1), from (2.5, 1) to (3, 1.65)."""
    at = lexis_map.T_W_B[:, :2, 3]
    corner = [int(np.linalg.norm(at - place, axis=1).argmin()) for place in ([2.5, 1.0], [3.0, 1.65])]
    assert corner in shortcuts(lexis_map, PlannerConfig()).tolist()


def test_a_robot_wider_than_the_door_has_no_shortcut_through_it(lexis_map):
    wide = lines(lexis_map, shortcuts(lexis_map, PlannerConfig(radius_m=0.6)))
    assert len(wide) > 10 and not shapely.crosses(wide, shapely.LineString([(4.05, 0.0), (4.05, 4.0)])).any()
    slim = lines(lexis_map, shortcuts(lexis_map, PlannerConfig(radius_m=0.2)))
    assert shapely.crosses(slim, shapely.LineString([(4.05, 0.0), (4.05, 4.0)])).any()


def with_landmarks(lexis_map, change):
    """The map with other landmarks: `change` maps the positions (k, 3) in W that keyframe i sees to other positions."""
    keyframes = []
    for i, (keyframe, T_W_B) in enumerate(zip(lexis_map.keyframes, lexis_map.T_W_B, strict=True)):
        points = transform(inverse(T_W_B), change(i, transform(T_W_B, keyframe.landmarks.points)))
        keyframes.append(replace(keyframe, landmarks=without_key_points(points)))
    return replace(lexis_map, keyframes=tuple(keyframes))


def test_without_landmarks_shortcuts_only_follow_the_walk(lexis_map):
    blind = with_landmarks(lexis_map, lambda i, points: points[:0])
    walk = shapely.LineString(lexis_map.T_W_B[lexis_map.floors == 0, :2, 3])
    straight = lines(blind, shortcuts(blind, PlannerConfig()))
    assert shapely.within(straight, walk.buffer(2 * CELL_M)).all()
    assert len(straight) < len(shortcuts(lexis_map, PlannerConfig())) / 2


def test_shortcuts_lead_around_a_table_that_few_images_show(lexis_map):
    """The table stands beside the walk through the office. A third of the keyframes have landmarks on it."""
    table = np.column_stack((np.tile(np.arange(5.5, 6.6, 0.05), 2), np.repeat([2.45, 2.55], 22), np.full(44, 0.75)))
    furnished = with_landmarks(lexis_map, lambda i, points: np.concatenate([points, table]) if i % 3 == 0 else points)
    across = shapely.LineString([(5.5, 2.5), (6.5, 2.5)])
    assert shapely.crosses(lines(lexis_map, shortcuts(lexis_map, PlannerConfig())), across).any()
    assert not shapely.crosses(lines(furnished, shortcuts(furnished, PlannerConfig())), across).any()


@pytest.mark.parametrize(("cells", "filled"), [(1, True), (2, True), (3, False)])
def test_narrow_gaps_in_free_space_are_free(cells, filled):
    """No free cell is lost, and a gap along the border of the grid is none."""
    free = np.zeros((9, 12), bool)
    free[2:7, 2:] = True
    free[:, 4 : 4 + cells] = False
    found = module._filled(free)
    assert (found | ~free).all() and found[3:6, 4 : 4 + cells].all() == found[3:6, 4 : 4 + cells].any() == filled
    assert not found[:2].any() and not found[7:].any() and not found[:, :2].any()


def test_a_gap_that_an_obstacle_fills_is_not_free(lexis_map):
    """A third of the keyframes see a post in the office, which stands between free cells."""
    post = np.column_stack((np.full(40, 6.0), np.full(40, 2.5), np.linspace(0.3, 1.2, 40)))
    with_post = with_landmarks(lexis_map, lambda i, points: np.concatenate([points, post]) if i % 3 == 0 else points)
    near = shapely.distance(lines(with_post, shortcuts(with_post, PlannerConfig())), shapely.Point(6.0, 2.5))
    assert near.min() >= PlannerConfig().radius_m - CELL_M
    assert shapely.distance(lines(lexis_map, shortcuts(lexis_map, PlannerConfig())), shapely.Point(6.0, 2.5)).min() < 0.1


def test_shortcuts_can_be_switched_off(lexis_map):
    assert not len(shortcuts(lexis_map, PlannerConfig(sight_m=0.0)))


def test_shortcuts_keep_away_from_stairs(lexis_map):
    poses = lexis_map.T_W_B.copy()
    poses[lexis_map.floors == NO_FLOOR, :2, 3] = [6.0, 2.5]
    changed = replace(lexis_map, T_W_B=poses)
    pairs = shortcuts(changed, PlannerConfig())
    assert (shapely.distance(lines(changed, pairs), shapely.Point(6.0, 2.5)) >= STAIRWELL_M - CELL_M).all()
    assert 0 < len(pairs) < len(shortcuts(lexis_map, PlannerConfig()))


def test_shortcuts_do_not_depend_on_the_last_bits(lexis_map, rng):
    expected = shortcuts(lexis_map, PlannerConfig())
    for _ in range(5):
        poses = lexis_map.T_W_B.copy()
        poses[:, :3, 3] += rng.uniform(-1e-12, 1e-12, (len(poses), 3))
        found = shortcuts(replace(lexis_map, T_W_B=poses), PlannerConfig())
        assert set(map(tuple, found.tolist())) == set(map(tuple, expected.tolist()))


def test_shortcuts_are_checked_alike_in_parts(lexis_map, monkeypatch):
    expected = shortcuts(lexis_map, PlannerConfig())
    monkeypatch.setattr(module, "_CHUNK", 7)
    assert (shortcuts(lexis_map, PlannerConfig()) == expected).all()


@pytest.mark.parametrize("ahead_m", [4.0, -4.0])
def test_bodies_outside_of_all_that_the_camera_saw_have_no_shortcuts(lexis_map, ahead_m):
    """The camera stays where it is. Cells that no image shows are not free."""
    T_B_C = exp(np.array([0.0, 0.0, 0.0, ahead_m, 0.0, 0.0]))
    upright = np.tile(np.eye(4), (len(lexis_map.T_W_B), 1, 1))
    upright[:, :3, 3] = lexis_map.T_W_B[:, :3, 3]
    poses = upright @ inverse(T_B_C)
    keyframes = []
    for keyframe, old, new in zip(lexis_map.keyframes, lexis_map.T_W_B, poses, strict=True):
        points = transform(between(new, old), keyframe.landmarks.points)
        keyframes.append(replace(keyframe, landmarks=without_key_points(points)))
    camera = replace(lexis_map.camera, T_B_C=T_B_C)
    pairs = shortcuts(replace(lexis_map, camera=camera, T_W_B=poses, keyframes=tuple(keyframes)), PlannerConfig())
    assert shapely.within(lines(replace(lexis_map, T_W_B=poses), pairs), INSIDE.buffer(CELL_M)).all() and len(pairs)


def test_a_session_that_shares_no_frame_with_the_first_changes_no_shortcut(lexis_map):
    """The second session lies half a storey lower, where the first one would take its table tops for a floor."""
    n, alone = len(lexis_map.keyframes), shortcuts(lexis_map, PlannerConfig())
    pairs = shortcuts(with_session_apart(lexis_map, [24.0, 0.0, -1.2]), PlannerConfig())
    assert set(map(tuple, pairs.tolist())) == {(a + k, b + k) for a, b in alone.tolist() for k in (0, n)}


def test_a_floor_too_large_for_a_grid_has_no_shortcuts(lexis_map):
    poses = lexis_map.T_W_B.copy()
    poses[0, :2, 3] = 1e5
    assert not len(shortcuts(replace(lexis_map, T_W_B=poses), PlannerConfig()))


def test_points_are_close_enough_together(rng):
    positions = rng.uniform(0.0, 2.0, (20, 3))
    pairs = rng.integers(0, 20, (30, 2))
    points = points_between(positions, pairs, 4.0)
    assert (points[:, 0] == positions[pairs[:, 0]]).all() and (points[:, -1] == positions[pairs[:, 1]]).all()
    assert np.linalg.norm(np.diff(points, axis=1), axis=2).max() <= module.SPACING_M
