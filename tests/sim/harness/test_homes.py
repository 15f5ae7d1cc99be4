"""Whole runs through five homes that were used neither for training nor for tuning: the acceptance test of a release."""

import numpy as np
import pytest

from sim.bench.segmentation import run_houses
from sim.harness import Scenario

SEEDS = range(500, 505)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def rows():
    return [row for _, row in run_houses(Scenario(preset="home"), SEEDS)]


def test_labels_are_right_and_refinement_helps(rows):
    assert all(row.refined >= 0.45 for row in rows)
    assert np.mean([row.refined for row in rows]) >= np.mean([row.baseline for row in rows])


def test_floors_are_right(rows):
    assert all(row.floors > 0.95 for row in rows)


def test_the_trajectory_is_better_than_the_odometry_on_every_house(rows):
    assert all(row.ate_m < row.odometry_m for row in rows)


def test_no_false_loop_edge_keeps_its_weight(rows):
    assert sum(row.trusted_false_loops for row in rows) == 0


def test_every_plan_reaches_its_room(rows):
    assert all(row.plans == 1.0 for row in rows)
