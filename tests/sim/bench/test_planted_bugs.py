"""Planted bugs change the estimate of a run, and never its truth."""

from dataclasses import replace

import numpy as np
import pytest

from sim.bench.planted_bugs import BUGS, no_bug, planted
from sim.harness import Scenario
from worlds.presets import sample_from_rooms

TRUTH = ("true_poses", "odometry_poses", "true_labels", "true_rooms", "true_floors")
OPEN_HOME = Scenario(
    house=sample_from_rooms(("kitchen", "living room", "pantry", "bedroom"), seed=4, openness=0.9),
    seed=5,
    length_m=25.0,
    frame_rate_hz=2.0,
    fidelity="features",
    encoder="oracle",
)
"""A walk through an open home with a small room and a loop of rooms."""


@pytest.fixture(scope="module")
def finished():
    return planted(no_bug)(OPEN_HOME)


@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_leaves_the_truth_of_the_run_as_it_is(finished, bug):
    run = replace(finished)  # without cached arrays
    before = {name: getattr(run, name).copy() for name in TRUTH}
    BUGS[bug](run)
    for name, truth in before.items():
        np.testing.assert_array_equal(getattr(run, name), truth, err_msg=name)
