from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely

from sim.errors import SimError
from sim.robot import REACHED_M, drive
from worlds.house import Furniture, build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.walkable import Walkable, polyline_length


def two_rooms(door=True):
    """An office and a kitchen, each 4 x 3 m, with a door in the middle of the wall between them."""
    rooms = tuple(
        RoomSpec(id=name, label=name, polygon_m=((x, 0.0), (x + 4.0, 0.0), (x + 4.0, 3.0), (x, 3.0)))
        for name, x in (("office", 0.0), ("kitchen", 4.0))
    )
    opening = OpeningSpec(rooms=("office", "kitchen"), kind="door", start_m=(4.0, 1.0), end_m=(4.0, 2.0))
    return build_house(HouseSpec(storeys=(StoreySpec(rooms=rooms, openings=(opening,) if door else (), furniture=()),)))


def go(house, *waypoints, height_m=0.0):
    return drive(house, Walkable(house), np.array(waypoints, dtype=float), height_m)


def test_a_free_straight_drive_is_straight_and_ends_in_the_room():
    result = go(two_rooms(), (1.0, 1.5, 1.4), (3.0, 1.5, 1.4), (7.0, 1.5, 1.4), height_m=1.4)
    assert (result.room, result.collisions) == ("kitchen", 0)
    assert 6.0 - 2 * REACHED_M <= result.length_m <= 6.2
    assert result.length_m == pytest.approx(polyline_length(result.path))


def test_waypoints_that_are_off_by_the_maps_error_still_lead_there(rng):
    house = build_house(sample_house("home", 21))
    walkable = Walkable(house)
    kitchen, bathroom = (next(room for room in house.rooms if room.label == label) for label in ("kitchen", "bathroom"))
    exact = walkable.path(*(int(walkable.nodes_in(room.id)[0]) for room in (kitchen, bathroom)))
    dense = [point for a, b in pairwise(exact) for point in np.linspace(a, b, 6)[:-1]]
    waypoints = np.array([*dense, exact[-1]]) + rng.uniform(-0.17, 0.17, (len(dense) + 1, 3))
    result = drive(house, walkable, waypoints)
    assert (result.room, result.collisions) == (bathroom.id, 0)
    assert result.length_m < 1.3 * polyline_length(exact)


def test_the_robot_goes_round_what_the_map_does_not_know_and_touches_nothing():
    table = Furniture("table", "table", "office", 0, (2.0, 1.5, 0.0), 0.3, (0.8, 1.0, 0.7), True)
    house = replace(two_rooms(), furniture=(table,))
    result = go(house, (0.6, 1.5, 0.0), (3.4, 1.5, 0.0), (6.0, 1.5, 0.0))
    assert (result.room, result.collisions) == ("kitchen", 0)
    line = shapely.LineString(result.path[:, :2])
    assert min(line.distance(solid.footprint) for solid in (table, *(w for w in house.walls if w.bottom_m < 1.9))) >= 0.249


def test_a_waypoint_just_behind_a_wall_does_not_lure_the_robot_through_the_door():
    result = go(two_rooms(), (2.0, 0.5, 0.0), (4.15, 0.5, 0.0))
    assert (result.room, result.collisions) == ("office", 0)


def test_a_leg_without_a_way_is_a_collision_that_ends_the_drive():
    result = go(two_rooms(door=False), (1.0, 1.5, 0.0), (2.0, 1.5, 0.0), (6.0, 1.5, 0.0), (7.0, 1.5, 0.0))
    assert (result.room, result.collisions) == ("office", 1)
    np.testing.assert_allclose(result.path[-1], [2.0, 1.5, 0.0], atol=0.4)


def test_a_start_where_nobody_can_stand_is_a_collision():
    result = go(two_rooms(), (-3.0, 1.5, 0.0), (1.0, 1.5, 0.0))
    assert (result.room, result.collisions, result.length_m) == (None, 1, 0.0)


def test_bad_waypoints_are_named():
    with pytest.raises(SimError, match="at least one and finite"):
        go(two_rooms(), (np.nan, 0.0, 0.0))
