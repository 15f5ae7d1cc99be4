"""Stairs recognised from height alone: U-shaped flights with a landing, drift, bobbing, floors on the way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexis.config import LabelConfig
from lexis.stairs import on_stairs


def profile(*legs, spacing=0.5):
    """Positions every `spacing` [m] along legs of (horizontal length, climb) [m], and the leg of each position."""
    ends = np.cumsum([(0.0, 0.0), *legs], axis=0)
    path = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
    at = np.arange(0.0, path[-1], spacing)
    x, z = (np.interp(at, path, ends[:, k]) for k in (0, 1))
    return np.stack([x, np.zeros_like(x), z], axis=1), np.searchsorted(path, at, side="right") - 1


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


def test_a_floor_between_two_flights_stays_a_floor():
    """A long level stretch elsewhere has the same height, so this one is a floor and not a landing."""
    upstairs = ((5, 0), (4.2, 2.9), (2.5, 0), (4.2, 2.9), (5, 0), (4.2, -2.9), (6, 0))
    positions, leg = profile(*upstairs)
    stairs = on_stairs(positions, LabelConfig())
    assert not stairs[leg == 6].any()
    assert not stairs[leg == 2][1:-1].all()


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
