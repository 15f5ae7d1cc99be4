"""Table III: the same walks for every method, and errors relative to the odometry of the same walk."""

from dataclasses import replace

import pytest

from sim.bench.peers.trajectories import METHODS, TrajectoryRow, compare_trajectories, means


def test_true_loops_leave_a_smaller_error_than_odometry_on_the_same_walk():
    rows = {row.method: row for row in compare_trajectories(("home",), (901,), "features")}
    assert list(rows) == list(METHODS) and len({row.odometry_m for row in rows.values()}) == 1
    assert rows["LEXIS, true loops"].ate_m < rows["odometry"].ate_m and rows["LEXIS"].ate_m < rows["odometry"].ate_m


def test_the_share_is_averaged_over_walks_and_not_taken_of_the_averages():
    rows = [TrajectoryRow("home", seed, "LEXIS", *errors) for seed, errors in ((1, (0.5, 1.0)), (2, (1.0, 4.0)))]
    found = means(rows)["LEXIS"]["home"]
    assert (found.ate_m, found.std_m) == (0.75, 0.25) and found.ratio_to_odometry == pytest.approx(0.375)


def test_a_walk_without_an_error_is_left_out():
    row = TrajectoryRow("home", 1, "LEXIS", 0.5, 1.0)
    found = means([row, replace(row, seed=2, ate_m=None, odometry_m=None)])["LEXIS"]["home"]
    assert (found.ate_m, found.std_m, found.ratio_to_odometry) == (0.5, None, 0.5)
