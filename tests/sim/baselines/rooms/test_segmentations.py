"""Laws of all segmentations of a map: doors separate rooms, and nothing depends on the direction of the axes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from lexis.evaluation.partitions import iou, overlap
from sim.baselines.rooms import DistanceTransform, HydraPlaces, Morphological, Voronoi
from sim.baselines.rooms.cells import components
from sim.baselines.rooms.true_map import RESOLUTION_M, TrueMap
from worlds.house import build_house
from worlds.presets import sample_house

ALL = [Morphological(), DistanceTransform(), Voronoi(), HydraPlaces()]
every = pytest.mark.parametrize("method", ALL, ids=lambda each: type(each).__name__)


def rectangles(*sides: Sequence[float], door_m: float = 0.9):
    """Free cells of rectangular rooms (4 m high) side by side, joined by doors in walls of 0.1 m."""
    cells = [round(side / RESOLUTION_M) for side in sides]
    high, door, wall = (round(size / RESOLUTION_M) for size in (4.0, door_m, 0.1))
    free = np.zeros((high + 4, sum(cells) + wall * (len(cells) - 1) + 4), bool)
    middle, at = (high + 4) // 2, 2
    for k, width in enumerate(cells):
        free[2:-2, at : at + width] = True
        at += width
        if k < len(cells) - 1:
            free[middle - door // 2 : middle + door // 2, at : at + wall] = True
            at += wall
    return free


def same_cells(a, b, free):
    """Mean IoU of each segment of `a` with the most similar segment of `b`, over free cells."""
    table = overlap(a[free], b[free])
    return iou(table, table.sum(axis=0, keepdims=True)).max(axis=1).mean() if a[free].max() else 1.0


@every
def test_one_rectangle_is_one_room(method):
    assert set(np.unique(method.segments(rectangles(4.0), RESOLUTION_M))) - {0} == {1}
    assert len(np.unique(method.segments(rectangles(3.0), RESOLUTION_M))) == 2


@every
def test_a_door_separates_two_rooms_at_the_wall(method):
    free = rectangles(5.0, 4.5)
    found = method.segments(free, RESOLUTION_M)
    left, right = found[:, :102][free[:, :102]], found[:, 104:][free[:, 104:]]
    assert len(np.unique(found[free])) == 2
    assert (left == np.bincount(left).argmax()).mean() > 0.97 and (right == np.bincount(right).argmax()).mean() > 0.97


@every
def test_segments_cover_the_free_cells_and_nothing_else(method):
    free = rectangles(4.0, 2.0, 3.0)
    free[:, 0] = True  # a part that no room touches
    assert ((method.segments(free, RESOLUTION_M) > 0) == free).all()


@every
def test_a_map_without_free_cells_has_no_rooms(method):
    assert not method.segments(np.zeros((20, 30), bool), RESOLUTION_M).any()


@every
def test_a_rotated_map_has_the_same_rooms(method):
    free = rectangles(5.0, 4.0, 4.5)
    upright, turned = method.segments(free, RESOLUTION_M), method.segments(np.rot90(free).copy(), RESOLUTION_M)
    assert upright.max() > 0 and len(np.unique(upright)) == len(np.unique(turned))
    assert same_cells(np.rot90(upright), turned, np.rot90(free)) > 0.97


def test_the_methods_agree_where_all_rooms_have_doors():
    free = rectangles(5.0, 4.0, 4.5)
    first, *others = [method.segments(free, RESOLUTION_M) for method in ALL]
    assert all(same_cells(first, other, free) > 0.97 for other in others)


def test_the_true_map_has_the_area_of_the_rooms_less_the_walls():
    house = build_house(sample_house("home", 900))
    true_map = TrueMap.of(house)
    rooms = [room for room in house.rooms if room.label != "stairs"]
    area_m2 = true_map.free.sum() * RESOLUTION_M**2
    total_m2 = sum(room.polygon.area for room in rooms)
    assert 0.8 * total_m2 < area_m2 < total_m2
    assert not true_map.free[:, 0].any() and true_map.free.shape[0] == len(house.storeys)
    bare = replace(house, furniture=())
    assert (TrueMap.of(bare).free == true_map.free).all()


def test_a_passage_belongs_to_the_room_with_the_door_and_not_to_the_room_behind_a_thin_wall():
    free = rectangles(5.0, 0.8, 4.5)
    free[:, 102:104] = False  # the door between the first room and the passage
    found = HydraPlaces().segments(free, RESOLUTION_M)
    room, passage, behind_the_door = (set(found[:, part][free[:, part]]) for part in np.s_[:102, 104:120, 122:])
    assert len(room) == 1 and passage == behind_the_door and passage.isdisjoint(room)


def test_places_that_reach_no_room_become_a_segment_of_their_own():
    free = rectangles(5.0)
    free = np.pad(free, ((0, 0), (0, 30)))
    free[8:12, -20:-4] = True  # a strip that is too narrow to be a room, and has no connection to the room
    found = HydraPlaces().segments(free, RESOLUTION_M)
    strip = set(found[8:12, -20:-4].ravel())
    assert len(strip) == 1 and 0 not in strip and strip.isdisjoint(found[:, :100][free[:, :100]])


def test_no_two_storeys_share_a_segment_even_with_an_empty_storey_between_them():
    free = np.zeros((3, 4, 4), bool)
    free[0, 0, 0] = free[0, 2, 2] = free[2, 3, 3] = True
    axis = RESOLUTION_M * np.arange(4)
    found = TrueMap(build_house(sample_house("home", 900)), axis, axis, free).segmented(lambda cells, _: components(cells))
    assert [np.unique(level).tolist() for level in found] == [[0, 1, 2], [0], [0, 3]]
