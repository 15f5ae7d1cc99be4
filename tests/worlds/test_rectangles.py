"""Rectangles that tile a rectilinear polygon, compared with the areas and the unions that shapely computes."""

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon, box

from worlds.presets import PRESETS, sample_house
from worlds.rectangles import cells_inside, notches, tiles

U_SHAPE = ((0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (4.0, 4.0), (4.0, 1.5), (1.0, 1.5), (1.0, 5.0), (0.0, 5.0))


def polygons():
    houses = (sample_house(preset, 77) for preset in PRESETS)
    return [U_SHAPE, *(room.polygon_m for house in houses for storey in house.storeys for room in storey.rooms)]


def test_tiles_make_up_the_polygon_and_notches_the_rest_of_its_bounding_box():
    assert len({len(corners) for corners in polygons()}) >= 3
    for corners in polygons():
        polygon = Polygon(corners)
        inside, outside = ([box(*each) for each in rectangles] for rectangles in (tiles(polygon), notches(corners)))
        assert shapely.equals_exact(shapely.union_all(inside).symmetric_difference(polygon).buffer(-1e-6), Polygon())
        assert sum(each.area for each in inside) == pytest.approx(polygon.area)
        assert sum(each.area for each in outside) == pytest.approx(polygon.envelope.area - polygon.area)
        assert shapely.union_all(outside).intersection(polygon).area == 0.0


@pytest.mark.parametrize("corners", [U_SHAPE, U_SHAPE[::-1]])
def test_cells_are_inside_whichever_way_the_polygon_turns(corners):
    x, y = np.array([-1.0, 0.0, 1.0, 2.0, 4.0, 6.0, 7.0]), np.array([0.0, 1.0, 1.5, 4.0, 5.0])
    i, j = (np.searchsorted(lines, values) for lines, values in zip((x, y), zip(*corners, strict=True), strict=True))
    middles = np.meshgrid((x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2, indexing="ij")
    np.testing.assert_array_equal(cells_inside(i, j, (6, 4)), shapely.contains_xy(Polygon(corners), *middles))
