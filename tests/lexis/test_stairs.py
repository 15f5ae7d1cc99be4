"""Stairs recognised from height alone: U-shaped flights with a landing, spirals, ramps, rides in a lift, drift."""

import numpy as np
import pytest
from helpers.climbs import drifting, profile, wound
from hypothesis import given
from hypothesis import strategies as st

from lexis.config import LabelConfig
from lexis.floors import assign_floors
from lexis.stairs import lift_rides, on_stairs


@given(pitch=st.floats(28.0, 40.0), spacing=st.floats(0.25, 0.7), landing=st.floats(0.0, 2.0), sign=st.sampled_from([-1, 1]))
def test_flights_and_their_landing_are_stairs_and_nothing_else(pitch, spacing, landing, sign):
    run = 1.4 / np.tan(np.radians(pitch))
    positions, leg = profile((8, 0), (run, sign * 1.4), (landing + 0.01, 0), (run, sign * 1.4), (8, 0), spacing=spacing)
    stairs = on_stairs(positions, LabelConfig())
    truly = (leg >= 1) & (leg <= 3)
    at_border = np.zeros(len(stairs), bool)
    for border in np.flatnonzero(np.diff(truly)):
        at_border[border : border + 2] = True
    np.testing.assert_array_equal(stairs[~at_border], truly[~at_border])


@given(pitch=st.floats(28.0, 42.0), spacing=st.floats(0.1, 0.7), sign=st.sampled_from([-1, 1]))
def test_no_keyframe_on_a_level_floor_is_on_the_stairs(pitch, spacing, sign):
    positions, leg = profile((8, 0), (2.8 / np.tan(np.radians(pitch)), sign * 2.8), (8, 0), spacing=spacing)
    stairs = on_stairs(positions, LabelConfig())
    assert not stairs[leg != 1].any()
    assert stairs[leg == 1][1:-1].all()


@given(pitch=st.floats(36.0, 42.0), spacing=st.floats(0.3, 0.7), error=st.sampled_from([-0.06, 0.06]))
def test_a_keyframe_on_a_floor_may_be_measured_six_centimetres_too_low_or_too_high(pitch, spacing, error):
    positions, leg = profile((8, 0), (2.8 / np.tan(np.radians(pitch)), 2.8), (8, 0), spacing=spacing)
    positions[np.flatnonzero(leg == 2)[0], 2] += error
    assert not on_stairs(positions, LabelConfig())[leg != 1].any()


@pytest.mark.parametrize("spacing", [0.25, 0.3, 0.45, 0.55])
def test_floors_stay_apart_if_the_images_of_the_stairs_between_them_are_lost(spacing):
    positions, leg = profile((8, 0), (1.5, 1.1), (8, 0), spacing=spacing)
    seen = positions[leg != 1]
    assert np.unique(assign_floors(on_stairs(seen, LabelConfig()), seen)).tolist() == [-1, 0, 1]


@given(pitch=st.floats(28.0, 42.0), length=st.floats(1.6, 6.0), spacing=st.floats(0.1, 0.7), sign=st.sampled_from([-1, 1]))
def test_a_floor_between_two_flights_is_a_floor_to_its_ends(pitch, length, spacing, sign):
    """A long level stretch elsewhere has the same height, so this one is a floor and not a landing."""
    run, rise = 2.8 / np.tan(np.radians(pitch)), sign * 2.8
    positions, leg = profile((5, 0), (run, rise), (length, 0), (run, rise), (5, 0), (run, -rise), (6, 0), spacing=spacing)
    stairs = on_stairs(positions, LabelConfig())
    assert not stairs[(leg == 2) | (leg == 6)].any()
    assert stairs[(leg == 1) | (leg == 3) | (leg == 5)].mean() > 0.5


def test_turning_back_at_the_top_is_no_landing():
    positions, leg = profile((6, 0), (4.2, 2.9), (2.5, 0), (4.2, -2.9), (6, 0))
    assert not on_stairs(positions, LabelConfig())[leg == 2].all()


@pytest.mark.parametrize("slope", [0.05, -0.08])
def test_drift_and_bobbing_are_no_stairs(rng, slope):
    x = np.arange(0.0, 100.0, 0.4)
    positions = np.stack([x, np.sin(x), slope * x + rng.normal(0.0, 0.05, len(x))], axis=1)
    assert not on_stairs(positions, LabelConfig()).any()


def test_up_and_down_are_the_same_stairs():
    positions, _ = profile((6, 0), (4.2, 2.9), (6, 0))
    np.testing.assert_array_equal(on_stairs(positions[::-1], LabelConfig()), on_stairs(positions, LabelConfig())[::-1])


def near_a_change(values, metres, spacing):
    """Whether each value is within some metres of path of a change of the values."""
    near = np.zeros(len(values), bool)
    reach = int(np.ceil(metres / spacing))
    for change in np.flatnonzero(np.diff(values)):
        near[max(change + 1 - reach, 0) : change + 1 + reach] = True
    return near


SIGNS, SPACINGS, SEEDS = st.sampled_from([-1, 1]), st.floats(0.3, 0.7), st.integers(0, 10_000)


@given(height=st.floats(2.3, 12.0), spacing=SPACINGS, sign=SIGNS, stops=st.booleans(), seed=SEEDS)
def test_only_keyframes_inside_a_moving_lift_count_as_on_stairs(height, spacing, sign, stops, seed):
    """`stops`: images stop during the ride, so that the height changes in one step."""
    positions, leg = profile((6, 0), (0, sign * height), (6, 0), spacing=spacing)
    if stops:
        positions, leg = positions[leg != 1], leg[leg != 1]
    stairs = on_stairs(drifting(positions, np.random.default_rng(seed)), LabelConfig())
    assert not stairs[leg != 1][~near_a_change(leg, spacing, spacing)[leg != 1]].any()
    assert stairs.sum() >= (leg == 1).sum() - 2 and stairs.sum() <= (leg == 1).sum()


def test_a_ride_begins_and_ends_on_a_floor_even_if_steps_are_partly_walked():
    """Keyframes 2 and 8 are the last and the first on a floor; from 2 to 3 and from 7 to 8, the robot walks and rides."""
    x = [0.0, 0.5, 1.0, 1.3, 1.3, 1.3, 1.3, 1.3, 1.6, 2.1]
    z = [0.0, 0.0, 0.0, 0.3, 0.8, 1.3, 1.8, 2.3, 2.6, 2.6]
    positions = np.stack([x, np.zeros(10), z], axis=1)
    assert lift_rides(positions) == [(2, 9)]
    assert np.flatnonzero(on_stairs(positions, LabelConfig())).tolist() == [3, 4, 5, 6, 7]


def test_a_ride_without_images_may_include_some_walking():
    positions, _ = profile((12, 0))
    positions[10:] += [0.6, 0.0, 2.3]
    assert lift_rides(positions) == [(9, 11)] and not on_stairs(positions, LabelConfig()).any()


def test_stairs_before_and_after_a_ride_stay_stairs():
    positions, leg = profile((6, 0), (4.2, 2.9), (5, 0), (0, 2.9), (5, 0), (4.2, -2.9), (6, 0))
    stairs = on_stairs(positions, LabelConfig())
    truly = np.isin(leg, [1, 3, 5])
    np.testing.assert_array_equal(stairs[~near_a_change(leg, 0.5, 0.5)], truly[~near_a_change(leg, 0.5, 0.5)])


@given(slope=st.floats(28.0, 45.0), radius=st.floats(0.6, 1.2), spacing=SPACINGS, sign=SIGNS, seed=SEEDS)
def test_a_spiral_flight_is_stairs_and_no_lift(slope, radius, spacing, sign, seed):
    positions, leg = profile((6, 0), (2.9 / np.tan(np.radians(slope)), sign * 2.9), (6, 0), spacing=spacing)
    measured = drifting(wound(positions, radius), np.random.default_rng(seed))
    certain = ~near_a_change(leg, 0.6, spacing)
    np.testing.assert_array_equal(on_stairs(measured, LabelConfig())[certain], (leg == 1)[certain])
    assert lift_rides(measured) == []


@given(rise=st.floats(1.3, 2.0), slope=st.floats(28.0, 38.0), spacing=SPACINGS, sign=SIGNS, seed=SEEDS)
def test_a_short_flight_to_a_mezzanine_is_stairs(rise, slope, spacing, sign, seed):
    positions, leg = profile((6, 0), (rise / np.tan(np.radians(slope)), sign * rise), (6, 0), spacing=spacing)
    measured = drifting(positions, np.random.default_rng(seed))
    certain = ~near_a_change(leg, 0.6, spacing)
    np.testing.assert_array_equal(on_stairs(measured, LabelConfig())[certain], (leg == 1)[certain])


@given(slope=st.floats(1 / 12, 1 / 8), spacing=SPACINGS, sign=SIGNS, seed=SEEDS)
def test_a_ramp_is_no_stairs(slope, spacing, sign, seed):
    positions, _ = profile((6, 0), (2.0 / slope, sign * 2.0), (6, 0), spacing=spacing)
    assert not on_stairs(drifting(positions, np.random.default_rng(seed)), LabelConfig()).any()


def test_a_jump_of_the_odometry_to_the_side_is_no_ride():
    positions, leg = profile((6, 0), (8, 0))
    positions[leg == 1] += [0.3, 1.5, 0.4]
    assert lift_rides(positions) == [] and not on_stairs(positions, LabelConfig()).any()


@pytest.mark.parametrize("metres", [0.0, 0.5])
def test_a_step_in_height_between_two_sessions_is_neither_a_climb_nor_a_ride(metres):
    x = np.concatenate([np.arange(0.0, 8.0, 0.5), 7.5 + metres + np.arange(0.0, 8.0, 0.5)])
    positions = np.stack([x, np.zeros(32), np.repeat([0.0, 1.4], 16)], axis=1)
    sessions = np.repeat([0, 1], 16)
    assert on_stairs(positions, LabelConfig()).any() or lift_rides(positions)
    assert not on_stairs(positions, LabelConfig(), sessions).any() and lift_rides(positions, sessions) == []
