"""The plan of a wrong frame shows the estimates that the figure is about, and the estimate where the motion is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from lexis.evaluation.trajectory import aligned
from sim.bench.planted_bugs import no_bug, planted
from sim.harness import Scenario
from sim.harness.diagnosis.first_wrong import first_wrong
from sim.harness.failures.estimated_frames import estimated_frames
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)


@pytest.fixture(scope="module")
def true():
    return planted(no_bug)(SCENARIO, None)


def estimating(run, **estimates):
    return replace(run, estimate=replace(run.estimate, **estimates))


def shown(run, figure):
    return estimated_frames(run, figure, first_wrong(run, figure))


def test_rooms_are_coloured_by_their_instance_and_those_that_are_wrong_are_ringed(true):
    rooms = true.true_rooms + 3
    rooms[5:8], rooms[9] = 17, -1
    estimates = shown(estimating(true, rooms=rooms), "rooms.pq")
    label = true.room_names[true.true_labels[5]]
    assert estimates.groups[5] == f"estimated room 17 ({label})" and estimates.groups[9] == "in no estimated room"
    assert len(set(estimates.colours.values())) == len(set(estimates.groups)) == len(estimates.colours)
    assert np.flatnonzero(estimates.wrong).tolist() == [5, 6, 7, 9]
    np.testing.assert_array_equal(estimates.frames, true.estimate.frames)


def test_labels_have_the_colours_of_reports(true):
    labels = true.true_labels.copy()
    labels[4], labels[6] = -1, (labels[6] + 1) % 2
    for figure in ("labels.accuracy", None):
        estimates = shown(estimating(true, labels=labels), figure)
        assert estimates.groups[4] == "no label" and estimates.groups[6].removeprefix("labelled ") in true.room_names
        assert estimates.colours["labelled kitchen"] == "#e8891c"
        assert np.flatnonzero(estimates.wrong).tolist() == [4, 6]


def test_floors_are_shown_for_figures_of_floors(true):
    floors = true.true_storeys.copy()
    floors[3], floors[4] = 2, -1
    estimates = shown(estimating(true, floors=floors), "floors.accuracy")
    assert estimates.groups[2:5] == ("estimated floor 0", "estimated floor 2", "estimated on no floor")
    assert np.flatnonzero(estimates.wrong).tolist() == [3, 4]


def test_figures_of_the_trajectory_show_no_other_estimates(true):
    poses = true.true_poses.copy()
    poses[:, 0, 3] *= 1.05
    for figure in ("trajectory.ate_m", None):
        estimates = shown(estimating(true, T_W_B=poses), figure)
        assert estimates.groups == () and estimates.wrong is None
        np.testing.assert_array_equal(estimates.T_W_B, aligned(poses, true.true_poses))


def test_figures_that_describe_the_run_as_a_whole_show_no_estimates(true):
    run = estimating(true, labels=(true.true_labels + 1) % 2)
    estimates = estimated_frames(run, "coverage.path_covered", first_wrong(run))
    assert estimates.groups == () and estimates.wrong is None and not estimates.names_labels


def test_the_estimate_agrees_with_the_truth_where_a_wrong_motion_begins(true):
    poses = true.true_poses.copy()
    poses[20:, 0, 3] += 2.0
    run = estimating(true, T_W_B=np.linalg.inv(poses[0]) @ poses)
    wrong = first_wrong(run, "trajectory.ate_m")
    estimates = estimated_frames(run, "trajectory.ate_m", wrong)
    since, end = (int(np.flatnonzero(run.estimate.frames == frame)[0]) for frame in (wrong.since, wrong.frame))
    np.testing.assert_allclose(estimates.T_W_B[: since + 1], true.true_poses[: since + 1], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm((estimates.T_W_B - true.true_poses)[end, :3, 3]), 2.0)


def test_what_is_not_estimated_is_not_shown(true):
    estimates = shown(estimating(true, T_W_B=None, labels=None, rooms=true.true_rooms * 0), "rooms.pq")
    assert estimates.T_W_B is None and set(estimates.groups) == {"estimated room 0"}
