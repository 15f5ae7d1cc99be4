import numpy as np

from lexis.floors import floor_levels


def test_a_short_level_stretch_half_way_up_is_no_floor_of_its_own():
    stairs = np.array([0] * 8 + [1] * 5 + [0] * 2 + [1] * 5 + [0] * 8, bool)
    height = np.interp(np.arange(28), [7, 13, 14, 20], [0.0, 1.45, 1.45, 2.9])
    floors = floor_levels(stairs, height)
    assert set(floors[:8]) == {0} and set(floors[20:]) == {1} and set(floors[13:15]) <= {0, 1}


def test_the_lowest_floor_is_zero_wherever_the_walk_begins():
    stairs = np.array([0] * 5 + [1] * 5 + [0] * 5, bool)
    down = np.interp(np.arange(15), [4, 10], [10.0, 7.0])
    assert floor_levels(stairs, down).tolist() == [1] * 5 + [-1] * 5 + [0] * 5


def test_all_stairs_and_no_stairs():
    assert floor_levels(np.ones(3, bool), np.arange(3.0)).tolist() == [-1] * 3
    assert floor_levels(np.zeros(3, bool), np.arange(3.0)).tolist() == [0] * 3
    assert floor_levels(np.zeros(0, bool), np.zeros(0)).tolist() == []
