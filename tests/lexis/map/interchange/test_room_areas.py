"""Rooms have the area of the true rooms, areas do not overlap, and rectangles and outlines are the same area."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from helpers.two_rooms import ROOMS, two_rooms

from lexis.map.interchange.room_areas import outline, rectangles, room_masks
from lexis.sight.cells import CELL_M
from lexis.sight.storey_grid import storey_grid


@pytest.fixture(scope="module")
def lexis_map():
    return two_rooms(np.random.default_rng(3))


@pytest.fixture(scope="module")
def grid(lexis_map):
    return storey_grid(lexis_map, 0)


def test_areas_are_the_true_rooms(lexis_map, grid):
    masks = room_masks(lexis_map, grid)
    assert sorted(masks) == [0, 1]
    for mask, true in zip(masks.values(), ROOMS.values(), strict=True):
        area, box = outline(mask, grid), shapely.box(*true)
        assert area.is_valid
        assert area.intersection(box).area / area.union(box).area > 0.85
    assert not (masks[0] & masks[1]).any()


def test_cells_that_a_room_encloses_belong_to_it(lexis_map, grid):
    row, column = grid.cells(np.array([[2.0, 2.0]]))[0]
    holed = replace(grid, free=grid.free.copy())
    holed.free[row, column] = False
    assert room_masks(lexis_map, holed)[0][row, column]


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 1.0])
def test_rectangles_cover_each_marked_cell_once(share, rng):
    mask = rng.random((13, 17)) < share
    covered = np.zeros(mask.shape, int)
    for row, column, row_end, column_end in rectangles(mask):
        covered[row:row_end, column:column_end] += 1
    np.testing.assert_array_equal(covered, mask)


def test_an_outline_has_the_area_of_its_cells(grid):
    assert outline(grid.free, grid).area == pytest.approx(grid.free.sum() * CELL_M**2)
