"""Floors from stairs, rides in a lift, ramps and mezzanines; drift and landings are no floors."""

import numpy as np
from helpers.climbs import drifting, profile
from hypothesis import given
from hypothesis import strategies as st

from lexis.config import LabelConfig
from lexis.floors import assign_floors
from lexis.stairs import on_stairs

SIGNS, SPACINGS, SEEDS = st.sampled_from([-1, 1]), st.floats(0.3, 0.7), st.integers(0, 10_000)


def along(height):
    """Positions half a metre apart with these heights [m]."""
    return np.stack([0.5 * np.arange(len(height)), np.zeros(len(height)), height], axis=1)


def floors_of(positions):
    return assign_floors(on_stairs(positions, LabelConfig()), positions)


def only(floors):
    """The floor that all keyframes have, apart from the outermost three of the stretch."""
    assert len(set(floors[3:-3].tolist())) == 1
    return int(floors[3])


def test_keyframes_that_are_all_on_rides_have_a_floor_unless_they_are_labelled_as_stairs():
    heights = np.array([0.0, 1.5, 3.0])
    positions = np.column_stack([np.zeros((3, 2)), heights])
    assert assign_floors(np.array([True, False, True]), positions).tolist() == [-1, 0, -1]


def test_a_short_level_stretch_half_way_up_is_no_floor_of_its_own():
    stairs = np.array([0] * 8 + [1] * 5 + [0] * 2 + [1] * 5 + [0] * 8, bool)
    height = np.interp(np.arange(28), [7, 13, 14, 20], [0.0, 1.45, 1.45, 2.9])
    floors = assign_floors(stairs, along(height))
    assert set(floors[:8]) == {0} and set(floors[20:]) == {1} and set(floors[13:15]) <= {0, 1}


def test_the_lowest_floor_is_zero_wherever_the_walk_begins():
    stairs = np.array([0] * 5 + [1] * 5 + [0] * 5, bool)
    down = np.interp(np.arange(15), [4, 10], [10.0, 7.0])
    assert assign_floors(stairs, along(down)).tolist() == [1] * 5 + [-1] * 5 + [0] * 5


def test_all_stairs_and_no_stairs():
    assert assign_floors(np.ones(3, bool), along(np.arange(3.0))).tolist() == [-1] * 3
    assert assign_floors(np.zeros(3, bool), along(0.1 * np.arange(3.0))).tolist() == [0] * 3
    assert assign_floors(np.zeros(0, bool), along(np.zeros(0))).tolist() == []


@given(height=st.floats(2.3, 12.0), spacing=SPACINGS, sign=SIGNS, stops=st.booleans(), named=st.booleans(), seed=SEEDS)
def test_a_lift_changes_the_floor(height, spacing, sign, stops, named, seed):
    """`stops`: images stop during the ride; `named`: the room names contain stairs, so that the ride has their label."""
    positions, leg = profile((6, 0), (0, sign * height), (6, 0), spacing=spacing)
    if stops:
        positions, leg = positions[leg != 1], leg[leg != 1]
    measured = drifting(positions, np.random.default_rng(seed))
    floors = floors_of(measured) if named else assign_floors(np.zeros(len(leg), bool), measured)
    assert (only(floors[leg == 0]), only(floors[leg == 2])) == ((0, 1) if sign > 0 else (1, 0))
    assert set(floors.tolist()) <= ({-1, 0, 1} if named else {0, 1})


@given(spacing=SPACINGS, seed=SEEDS)
def test_a_floor_is_the_same_by_lift_and_by_stairs(spacing, seed):
    legs = (6, 0), (0, 2.9), (6, 0), (0, 2.9), (6, 0), (4.2, -2.9), (6, 0), (4.2, -2.9), (6, 0)
    positions, leg = profile(*legs, spacing=spacing)
    floors = floors_of(drifting(positions, np.random.default_rng(seed)))
    assert [only(floors[leg == k]) for k in (0, 2, 4, 6, 8)] == [0, 1, 2, 1, 0]


@given(slope=st.floats(1 / 12, 1 / 8), rise=st.floats(2.0, 3.0), spacing=SPACINGS, sign=SIGNS, seed=SEEDS)
def test_a_ramp_changes_the_floor_once_on_its_way(slope, rise, spacing, sign, seed):
    half = 0.5 * rise / slope
    positions, leg = profile((8, 0), (half, sign * rise / 2), (1.5, 0), (half, sign * rise / 2), (8, 0), spacing=spacing)
    floors = floors_of(drifting(positions, np.random.default_rng(seed), walk_m=0.015, tilt=0.002))
    assert (only(floors[leg == 0]), only(floors[leg == 4])) == ((0, 1) if sign > 0 else (1, 0))
    assert np.abs(np.diff(floors_of(positions))).sum() == 1


@given(rise=st.floats(1.3, 2.0), spacing=SPACINGS, sign=SIGNS, seed=SEEDS)
def test_a_mezzanine_is_a_floor(rise, spacing, sign, seed):
    positions, leg = profile((6, 0), (1.5 * rise, sign * rise), (6, 0), (1.5 * rise, -sign * rise), (6, 0), spacing=spacing)
    floors = floors_of(drifting(positions, np.random.default_rng(seed), walk_m=0.026))
    low, high = (0, 1) if sign > 0 else (1, 0)
    assert [only(floors[leg == k]) for k in (0, 2, 4)] == [low, high, low]


@given(tilt=st.floats(-0.01, 0.01), spacing=SPACINGS, seed=SEEDS)
def test_drift_on_a_long_walk_is_no_floor(tilt, spacing, seed):
    positions, _ = profile((150, 0), spacing=spacing)
    assert set(floors_of(drifting(positions, np.random.default_rng(seed), tilt=tilt))) == {0}


def test_a_jump_of_the_odometry_to_the_side_is_no_other_floor():
    positions, leg = profile((6, 0), (8, 0))
    positions[leg == 1] += [0.3, 1.5, 0.4]
    assert set(floors_of(positions)) == {0}


def test_a_step_in_height_between_two_sessions_is_no_ramp():
    height = np.concatenate([np.zeros(8), [0.15, 0.3], [1.1, 1.25], np.full(8, 1.4)])
    level = np.zeros(20, bool)
    assert len(set(assign_floors(level, along(height)).tolist())) == 2
    assert not assign_floors(level, along(height), np.repeat([0, 1], 10)).any()


def test_a_walk_may_have_any_number_of_ramps():
    """Up and down by turns, each a little lower than the one before, so that the steepest one is always the first."""
    height = np.linspace(0.9, 0.6, 6000) * np.tile([0.0, 0.5, 1.0, 0.5], 1500)
    assert not assign_floors(np.zeros(len(height), bool), along(height)).any()
