"""Figures of a run: what depends on time depends on the true time, whatever the clock of the robot says."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from lexis.evaluation.loops import true_revisits
from lexis.maths.se3 import between
from sim.faults.poses import Kidnap
from sim.faults.stamps import StampJitter, StampJump
from sim.harness import evaluate, run
from sim.harness.adapters import OdometryOnly
from sim.harness.estimate import EstimatedLoops

LONG = replace(OPEN_FLAT, length_m=80.0)


def with_half_of_the_loops(*faults):
    """A run of 80 m whose estimate has a true loop at every second revisit, and asks for a match at every frame."""
    finished = run(replace(LONG, faults=faults), OdometryOnly())
    count, truth = len(finished.estimate.frames), finished.true_poses
    query = true_revisits(truth, finished.session.tour.stamps[finished.estimate.frames])[::2]
    match = np.zeros_like(query)
    loops = EstimatedLoops(query, match, between(truth[match], truth[query]))
    estimate = replace(finished.estimate, loops=loops, candidates=tuple((k, (0,)) for k in range(count)))
    return replace(finished, estimate=estimate)


@pytest.fixture(scope="module")
def usual():
    return with_half_of_the_loops()


@pytest.mark.parametrize("fault", [StampJump(back_s=60.0, at_s=60.0), StampJitter(sigma_s=8.0)])
def test_a_wrong_clock_changes_no_revisit(fault, usual):
    finished, expected = with_half_of_the_loops(fault), evaluate(usual)
    assert np.abs(finished.stamps - usual.stamps).max() > 10.0
    result = evaluate(finished)
    assert result.place_recognition == expected.place_recognition and result.loops == expected.loops
    assert expected.place_recognition["1"].possible > 0 and 0.4 < expected.loops.recall < 0.6


def test_true_stamps_are_those_of_the_clock_unless_a_fault_of_the_clock_changes_these(usual):
    np.testing.assert_array_equal(usual.true_stamps, usual.stamps)
    kidnapped = run(replace(LONG, faults=(Kidnap(at_s=10.0, skip_s=5.0),)), OdometryOnly())
    np.testing.assert_array_equal(kidnapped.true_stamps, kidnapped.stamps)
    assert np.diff(kidnapped.true_stamps).max() < 4.0
