"""Door leaves hang at their hinge, swing into their room, and are obstacles."""

import math
import pickle

import numpy as np
import pytest
import shapely
from helpers.opening_rooms import WALL_X, every_kind
from hypothesis import given
from hypothesis import strategies as st

from worlds.free_space import solid_obstacles
from worlds.house import build_house
from worlds.openings.door_swings import resting_box
from worlds.openings.opening_draft import OpeningDraft
from worlds.spec import HouseSpec, LeafSpec, OpeningSpec, RoomSpec, StoreySpec


def one_door(axis, backwards, leaf):
    """Two rooms of 4 x 4 m, side by side along x or y, with a door in the wall between them."""
    squares = (((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)), ((4.0, 0.0), (8.0, 0.0), (8.0, 4.0), (4.0, 4.0)))
    ends = [(4.0, 1.5), (4.0, 2.4)]
    if axis == 0:  # rotated by a quarter turn
        squares = tuple(tuple((-y, x) for x, y in square) for square in squares)
        ends = [(-y, x) for x, y in ends]
    rooms = tuple(RoomSpec(id=i, label="office", polygon_m=square) for i, square in zip("ab", squares, strict=True))
    start, end = ends[::-1] if backwards else ends
    door = OpeningSpec(rooms=("a", "b"), kind="door", start_m=start, end_m=end, leaf=leaf)
    return build_house(HouseSpec(clutter=0.0, storeys=(StoreySpec(rooms=rooms, openings=(door,)),)))


@given(
    axis=st.sampled_from([0, 1]),
    backwards=st.booleans(),
    hinge=st.sampled_from(["start", "end"]),
    into=st.sampled_from("ab"),
    angle=st.floats(0.0, 2.0),
)
def test_a_leaf_hangs_at_its_hinge_and_swings_into_its_room(axis, backwards, hinge, into, angle):
    house = one_door(axis, backwards, LeafSpec(hinge=hinge, into=into, angle_rad=angle))
    (leaf,), (door,) = house.leaves, house.spec.storeys[0].openings
    assert leaf.hinge == (door.start_m if hinge == "start" else door.end_m)
    free = np.array(leaf.arc(leaf.turn))
    shut = door.end_m if hinge == "start" else door.start_m
    np.testing.assert_allclose(free[0], shut, atol=1e-9)
    room = house.room_by_id[into].polygon
    assert room.buffer(1e-9).covers(leaf.swing)
    np.testing.assert_allclose(np.linalg.norm(free - leaf.hinge, axis=1), door.width_m)
    middle = (free[-1] + leaf.hinge) / 2
    np.testing.assert_allclose(leaf.position[:2], middle, atol=1e-9)
    assert leaf.footprint.buffer(1e-9).covers(shapely.LineString([leaf.hinge, free[-1]]))
    assert room.buffer(leaf.size[1]).covers(leaf.footprint)
    area = 0.5 * door.width_m**2 * max(angle, math.pi / 2)
    assert leaf.swing.area == pytest.approx(area, rel=0.02)


@pytest.mark.parametrize("angle", [0.0, 0.6, math.pi / 2, 1.9])
@pytest.mark.parametrize("hinge", ["start", "end"])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_leaf_is_built_in_the_place_that_was_planned_for_it(axis, hinge, angle):
    """Along the wall, the planned rectangle holds the built leaf, and at a right angle no more than the leaf."""
    house = one_door(axis, False, LeafSpec(hinge=hinge, into="b", angle_rad=angle))
    (leaf,), storey = house.leaves, house.spec.storeys[0]
    door = OpeningDraft.of(storey.openings[0], {room.id: room for room in storey.rooms})
    planned, built = np.array(resting_box(door, door.leaf)), np.array(leaf.footprint.bounds)
    low, high = (planned - built)[[axis, axis + 2]]
    assert low <= 1e-9 and high >= -1e-9
    if angle == math.pi / 2:
        assert (low, high) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_leaves_stand_in_the_way_unless_they_are_left_out():
    house = build_house(every_kind())
    with_leaves, without = solid_obstacles(house), solid_obstacles(house, leaves=False)
    assert len(with_leaves.yaw) == len(without.yaw) + len(house.leaves) == len(house.walls) + 2
    leaf = house.leaves[0]
    place = np.array([[WALL_X + 0.4, leaf.position[1], 0.0]])
    assert not with_leaves.clear(place - [0, 0.6, 0], place + [0, 0.6, 0], 0.1)[0]
    assert without.clear(place - [0, 0.6, 0], place + [0, 0.6, 0], 0.1)[0]


def test_parts_are_made_when_looked_at_and_lie_in_the_leafs_box():
    house = pickle.loads(pickle.dumps(build_house(every_kind())))
    for leaf in house.leaves:
        assert "parts" not in vars(leaf)
        width, _, height = leaf.size
        for part in leaf.parts:
            assert abs(part.centre[0]) + part.size[0] / 2 <= width / 2 + 1e-9
            assert 0.0 <= part.centre[2] - part.size[2] / 2 <= part.centre[2] + part.size[2] / 2 <= height + 1e-9


def test_doors_without_leaf_have_none():
    assert one_door(1, False, None).leaves == ()
