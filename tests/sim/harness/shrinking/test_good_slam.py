"""What a good SLAM could have reached in a run: exact truth, or what true loop closures make of the odometry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from lexis.maths.se3 import between
from sim.faults.poses import OdometryNaN
from sim.harness import Estimate, Lexis, Scenario, evaluate, run
from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.shrinking import good_slam
from sim.harness.shrinking.good_slam import GOOD_SLAMS, GoodSlam, GoodSlamChoice, with_true_loops
from worlds.presets import sample_from_rooms

LONG = replace(OPEN_FLAT, length_m=80.0)
ONCE = replace(OPEN_FLAT, length_m=15.0)


@pytest.fixture(scope="module")
def drifting():
    return run(LONG, OdometryOnly())


def test_the_figures_are_those_of_the_truth_but_for_the_stated_error():
    finished = run(ONCE, Lexis("oracle"))
    before, result = evaluate(finished), GoodSlam(0.02).result(finished)
    assert (result.labels.accuracy, result.rooms.pq, result.floors.accuracy) == (1.0, 1.0, 1.0)
    assert (result.trajectory.ate_m, result.trajectory.rpe_8m_m, result.trajectory.rpe_24m_m) == (0.02, 0.02, None)
    assert result.trajectory.ate_odometry_m == before.trajectory.ate_odometry_m
    assert result.labels.accuracy_baseline == before.labels.accuracy_baseline and result.loops == before.loops


def test_estimates_that_the_slam_does_not_make_are_not_added(drifting):
    result = GoodSlam(0.01).result(drifting)
    assert result.labels.accuracy is result.rooms.pq is result.floors.accuracy is None and result.trajectory.ate_m == 0.01
    silent = replace(drifting, estimate=replace(drifting.estimate, T_W_B=None))
    assert all(slam.result(silent).trajectory.ate_m is None for slam in GOOD_SLAMS)


def test_a_storey_of_which_only_the_stairs_are_seen_is_not_estimated_as_a_floor():
    house = sample_from_rooms(("kitchen", "bedroom"), 103, storeys=2)
    finished = run(Scenario(house=house, seed=5, length_m=60.0, frame_rate_hz=4.0, fidelity="features"), GeometricRooms())
    rows = np.flatnonzero(finished.on_stairs | (finished.true_storeys == 0))
    claims = Estimate(finished.estimate.frames[rows], floors=finished.estimate.floors[rows])
    below = replace(finished, estimate=claims)
    assert set(below.true_storeys.tolist()) == {0, 1}
    figures = GoodSlam(0.01).result(below).floors
    assert (figures.accuracy, figures.count_error) == (1.0, 0)


@pytest.mark.parametrize("most", [500, 40])
def test_true_loops_mend_much_of_the_drift(most, drifting, monkeypatch):
    monkeypatch.setattr(good_slam, "_MOST", most)
    figures = evaluate(drifting).trajectory
    error_m = GoodSlam(0.0, uses_odometry=True).result(drifting).trajectory.ate_m
    assert 0.0 < error_m < 0.25 * figures.ate_odometry_m


def test_between_the_poses_that_are_optimised_the_odometry_decides(drifting, monkeypatch):
    count = len(drifting.estimate.frames)
    monkeypatch.setattr(good_slam, "_MOST", math.ceil(count / 2))
    corrected, given = (between(poses[:-1], poses[1:]) for poses in (with_true_loops(drifting), drifting.odometry_poses))
    np.testing.assert_allclose(corrected[::2], given[::2], atol=1e-9)
    assert np.abs(corrected[1::2] - given[1::2]).max() > 1e-4


def test_without_revisits_the_poses_are_those_of_the_odometry():
    finished = run(replace(ONCE, length_m=8.0), OdometryOnly())
    np.testing.assert_array_equal(with_true_loops(finished), finished.odometry_poses)


@pytest.mark.parametrize("faults", [(), (OdometryNaN(0.3),)])
def test_where_the_odometry_is_perfect_its_correction_is_perfect(faults):
    finished = run(replace(LONG, odometry="perfect", faults=faults), OdometryOnly())
    assert GoodSlam(0.0, uses_odometry=True).result(finished).trajectory.ate_m < 1e-6


def limited(limit_m):
    return lambda result: result.trajectory.ate_m <= limit_m * result.trajectory.ate_odometry_m


def test_the_first_good_slam_that_passes_is_the_reference(drifting):
    before = run(replace(LONG, odometry="perfect"), OdometryOnly())
    short = run(replace(LONG, length_m=8.0, odometry="degraded"), OdometryOnly())
    for limit_m, avoids in ((0.5, False), (0.1, True)):  # the second limit is beyond a SLAM that corrects the odometry
        reference = GoodSlamChoice()
        assert reference.avoids(drifting, (), limited(limit_m))
        assert not reference.avoids(before, (), limited(limit_m))
        assert reference.avoids(short, (), limited(limit_m)) == avoids


def test_where_no_good_slam_passes_at_first_nothing_is_avoidable_or_not(drifting):
    reference = GoodSlamChoice()
    assert reference.avoids(drifting, (), lambda result: False)
    assert reference.avoids(drifting, (), lambda result: False)
