"""Keyframes are connected where a robot can travel between them."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import build_map, corridor_with_offices

from lexis.planning import PathPlanner


def test_rooms_are_joined_where_the_robot_walked_and_not_through_a_wall(rng):
    """The paths in two rooms run 0.4 m apart, with a wall between them; the door is at the far end."""
    x = np.arange(0, 5, 0.5)
    positions = np.concatenate([np.stack([x, 0 * x, 0 * x], 1), np.stack([x[::-1], 0 * x + 0.4, 0 * x], 1)])
    rooms = [("office", range(10)), ("kitchen", range(10, 20))]
    lexis_map = build_map(positions, np.repeat([0, 1], 10), rooms, ("office", "kitchen"), rng)
    assert PathPlanner(lexis_map).graph[0, 19] == 0.0
    assert PathPlanner(replace(lexis_map, rooms=())).graph[9, 10] > 0.0


def test_keyframes_of_no_room_are_not_those_of_one_room(rng):
    """An imported map may have keyframes of no room: here on both sides of the wall between two paths, 0.4 m apart."""
    x = np.arange(0, 5, 0.5)
    positions = np.concatenate([np.stack([x, 0 * x, 0 * x], 1), np.stack([x[::-1], 0 * x + 0.4, 0 * x], 1)])
    lexis_map = build_map(positions, np.zeros(20, int), [("office", [9, 10])], ("office",), rng)
    assert PathPlanner(lexis_map).graph[0, 19] == 0.0


@pytest.mark.parametrize(("weight", "joined"), [(1.0, True), (0.1, False)])
def test_only_trusted_loops_join_rooms(rng, weight, joined):
    lexis_map = corridor_with_offices(rng, loops=[(20, 10)], weights=[weight])
    assert (PathPlanner(lexis_map).graph[20, 10] > 0) == joined


@pytest.mark.parametrize(("step", "joined"), [((0.0, 0.0, 6.0), True), ((4.0, 0.0, 3.0), False), ((3.5, 0.0, 0.0), False)])
def test_a_ride_in_a_lift_joins_floors_and_a_gap_in_the_recording_does_not(rng, step, joined):
    """Between keyframes 4 and 5 no images arrive, while the robot moves by `step` [m]."""
    positions = np.stack([0.5 * np.arange(10), np.zeros(10), np.zeros(10)], axis=1)
    positions[5:] += step
    lexis_map = build_map(
        positions, np.repeat([0, 1], 5), [("hall", range(5)), ("attic", range(5, 10))], ("hall", "attic"), rng
    )
    assert (PathPlanner(lexis_map).graph[4, 5] > 0) == joined
