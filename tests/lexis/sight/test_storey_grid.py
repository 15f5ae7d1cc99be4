"""Cells are free where the map saw through them, and occupied where it saw something: truth of two rooms, which is exact."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from helpers.landmarks import without_key_points
from helpers.two_rooms import CAMERA_M, DOOR, ROOMS, two_rooms, with_session_apart

from lexis.errors import MapError
from lexis.floors import floor_numbers
from lexis.maths.se3 import between, exp, inverse, transform
from lexis.sight import storey_grid as module
from lexis.sight.cells import CELL_M
from lexis.sight.storey_grid import LOW_M, count_views, storey_grid, storeys
from lexis.types import NO_LANDMARKS, CameraView

INSIDE = shapely.union_all([*(shapely.box(*room) for room in ROOMS.values()), shapely.box(4.0, DOOR[0], 4.1, DOOR[1])])


@pytest.fixture(scope="module")
def lexis_map():
    return two_rooms(np.random.default_rng(3))


@pytest.fixture(scope="module")
def grid(lexis_map):
    return storey_grid(lexis_map, 0)


def centres(grid, cells):
    rows, columns = np.nonzero(cells)
    return grid.origin + CELL_M * (np.stack([columns, rows], axis=1) + 0.5)


def test_free_cells_are_in_the_rooms_and_fill_them(grid):
    free = shapely.points(centres(grid, grid.free))
    assert shapely.within(free, INSIDE.buffer(CELL_M)).all()
    assert len(free) * CELL_M**2 > 0.85 * INSIDE.area


def test_occupied_cells_are_along_the_walls(grid):
    occupied = shapely.points(centres(grid, grid.occupied))
    assert len(occupied) > 200
    assert shapely.dwithin(occupied, INSIDE.boundary, CELL_M).all()
    assert not (grid.free & grid.occupied).any()


def test_floor_and_ceiling_are_no_obstacles(grid):
    """Landmarks at the heights of floor and ceiling are on the walls here; without others, nothing is occupied."""
    low, high = grid.heights
    assert low == pytest.approx(0.02, abs=0.01) and high == pytest.approx(2.48, abs=0.01)


def test_the_walk_is_free_without_any_landmark(lexis_map):
    blind = replace(
        lexis_map,
        keyframes=tuple(replace(k, landmarks=NO_LANDMARKS) for k in lexis_map.keyframes),
    )
    grid = storey_grid(blind, 0)
    assert grid.heights == (CAMERA_M, CAMERA_M)
    assert not grid.occupied.any()
    walk = shapely.LineString(blind.T_W_B[blind.floors == 0, :2, 3])
    points = shapely.points(centres(grid, grid.free))
    assert len(points) > 100 and shapely.dwithin(points, walk, module.WALKED_M + CELL_M).all()


@pytest.mark.parametrize(("sessions", "walked"), [((0, 0), True), ((0, 1), False)])
def test_nobody_walked_from_the_end_of_one_session_to_the_beginning_of_the_next(lexis_map, sessions, walked):
    """The second of two keyframes, which see nothing, is 1 m from the first one."""
    keyframes = tuple(
        replace(keyframe, session=session, landmarks=NO_LANDMARKS)
        for keyframe, session in zip(lexis_map.keyframes, sessions, strict=False)
    )
    T_W_B = lexis_map.T_W_B[:2].copy()
    T_W_B[1, :3, 3] = T_W_B[0, :3, 3] + [1.0, 0.0, 0.0]
    names = ("labels", "baseline_labels", "similarities", "probabilities", "floors")
    first = replace(lexis_map, keyframes=keyframes, T_W_B=T_W_B, **{name: getattr(lexis_map, name)[:2] for name in names})
    grid = storey_grid(first, 0)
    assert grid.free[tuple(grid.cells(T_W_B[:, :3, 3].mean(axis=0)[None])[0])] == walked


def test_sessions_that_share_no_frame_have_storeys_of_their_own(lexis_map, grid):
    """The odometry of the second session began three metres higher, so that its floor 0 is at another height."""
    shift = np.array([24.0, 0.0, 3.0])
    both = with_session_apart(lexis_map, shift)
    assert storeys(both) == [(0, 0), (0, 1)]
    first, second = (storey_grid(both, *storey) for storey in storeys(both))
    for found, moved in ((first, np.zeros(3)), (second, shift)):
        np.testing.assert_allclose(found.origin, grid.origin + moved[:2])
        np.testing.assert_allclose(found.heights, np.add(grid.heights, moved[2]))
        for name in ("free", "occupied", "low"):
            differs = getattr(found, name) != getattr(grid, name)
            assert differs.mean() < 0.01


def test_stairs_have_no_grid(lexis_map):
    assert floor_numbers(lexis_map.floors) == [0]


def test_floors_without_end_are_refused(lexis_map):
    far = lexis_map.T_W_B.copy()
    far[0, 0, 3] = 1e7
    with pytest.raises(MapError, match=r"floor 0 is 1000.* m by .* large; valid: up to 200000 m²"):
        storey_grid(replace(lexis_map, T_W_B=far), 0)


def test_low_views_do_not_pass_above_tables(lexis_map):
    """Without landmarks below twice the height of a table, nothing is seen below the height of a table."""
    keyframes = []
    for keyframe, T_W_B in zip(lexis_map.keyframes, lexis_map.T_W_B, strict=True):
        points = keyframe.landmarks.points
        lowest = points[points[:, 2] + T_W_B[2, 3] < 0.1]  # they tell where the floor is
        high = points[points[:, 2] + T_W_B[2, 3] > 2.0 * LOW_M]
        both = np.concatenate([high, lowest]) if keyframe.id == 0 else high
        keyframes.append(replace(keyframe, landmarks=without_key_points(both)))
    views, high_only = count_views(lexis_map, 0), count_views(replace(lexis_map, keyframes=tuple(keyframes)), 0)
    assert (views.low > 1).sum() > 1000 and high_only.low.max() <= 1
    assert (high_only.passed > 1).sum() > 1000


def with_body_elsewhere(lexis_map, T_C_B):
    """The map with the same cameras and landmarks, but with the body at T_C_B behind the camera."""
    T_B_C = inverse(T_C_B)
    poses = lexis_map.T_W_B @ lexis_map.camera.T_B_C @ T_C_B
    keyframes = []
    for keyframe, old, new in zip(lexis_map.keyframes, lexis_map.T_W_B, poses, strict=True):
        points = transform(between(new, old), keyframe.landmarks.points)
        keyframes.append(replace(keyframe, landmarks=without_key_points(points)))
    return replace(lexis_map, camera=replace(lexis_map.camera, T_B_C=T_B_C), T_W_B=poses, keyframes=tuple(keyframes))


@pytest.mark.parametrize("away_m", [[4.0, 0.0, 0.0], [-4.0, 0.0, 0.0], [1.0, -6.0, 0.5]])
def test_the_grid_holds_a_body_far_from_its_camera_and_is_otherwise_the_same(lexis_map, away_m):
    moved = with_body_elsewhere(lexis_map, exp(np.array([0.0, 0.0, 0.0, *away_m])))
    views, wider = count_views(lexis_map, 0), count_views(moved, 0)
    cells = wider.cells(moved.T_W_B[moved.floors == 0, :3, 3])
    assert (cells >= 0).all() and (cells < wider.passed.shape).all()
    (column, row), (rows, columns) = np.rint((views.origin - wider.origin) / CELL_M).astype(int), views.passed.shape
    for name in ("passed", "hit", "low"):
        counts, part = getattr(wider, name), getattr(wider, name)[row : row + rows, column : column + columns]
        # Landmarks that are moved in their last bits may lose the last sample of a line of sight.
        difference = np.abs(part - getattr(views, name))
        assert difference.max() <= 1 and difference.mean() < 0.01 and part.sum() == counts.sum()


def test_the_grid_holds_all_cameras_of_a_rig(lexis_map):
    behind = replace(lexis_map.camera, T_B_C=lexis_map.camera.T_B_C @ exp(np.array([0.0, 0.0, 0.0, -4.0, 0.0, 0.0])))
    keyframes = [replace(k, others=(CameraView(k.embedding, k.features, k.landmarks),)) for k in lexis_map.keyframes]
    of_rig = replace(lexis_map, camera=replace(lexis_map.camera, others=(behind,)), keyframes=tuple(keyframes))
    views = count_views(of_rig, 0)
    cells = views.cells((of_rig.T_W_B @ behind.T_B_C)[of_rig.floors == 0, :3, 3])
    assert (cells >= 0).all() and (cells < views.passed.shape).all()
