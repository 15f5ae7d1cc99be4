"""Calibrated predictions have no calibration error, and the error of others is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexis.evaluation import calibration_error, reliability

EDGES = (0.0, 0.5, 0.9, 1.0)


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 50))
def test_every_prediction_is_in_one_interval_and_the_means_are_those_of_all_predictions(seed, n):
    rng = np.random.default_rng(seed)
    stated, right = rng.random(n), rng.random(n) < 0.5
    rows = [row for row in reliability(stated, right, EDGES) if row.predictions]
    assert sum(row.predictions for row in rows) == n
    assert sum(row.predictions * row.stated for row in rows) == pytest.approx(stated.sum())
    assert sum(row.predictions * row.right for row in rows) == pytest.approx(right.sum())
    assert all(row.low <= row.stated <= row.high for row in rows)


def test_a_bound_belongs_to_the_interval_above_it_and_one_to_the_last():
    stated = np.array([0.0, 0.5, 0.9, 1.0])
    assert [row.predictions for row in reliability(stated, np.ones(4, bool), EDGES)] == [1, 1, 2]


def test_the_error_is_the_gap_between_what_is_stated_and_what_is_right():
    stated = np.repeat([0.2, 0.8], 50)
    calibrated = np.concatenate([np.arange(50) < 10, np.arange(50) < 40])
    assert calibration_error(stated, calibrated) == pytest.approx(0.0)
    assert calibration_error(stated, np.ones(100, bool)) == pytest.approx(0.5 * 0.8 + 0.5 * 0.2)
