"""The plan of a wrong frame shows the claims that the figure is about, and the estimate where the motion is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from lexis.evaluation.trajectory import aligned
from sim.bench.planted_bugs import no_bug, planted
from sim.harness import Scenario
from sim.harness.diagnosis.first_wrong import first_wrong
from sim.harness.failures.claimed_frames import claimed_frames
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)


@pytest.fixture(scope="module")
def true():
    return planted(no_bug)(SCENARIO, None)


def claiming(run, **claims):
    return replace(run, estimate=replace(run.estimate, **claims))


def shown(run, figure):
    return claimed_frames(run, figure, first_wrong(run, figure))


def test_rooms_are_coloured_by_their_instance_and_those_that_are_wrong_are_ringed(true):
    rooms = true.true_rooms + 3
    rooms[5:8], rooms[9] = 17, -1
    claims = shown(claiming(true, rooms=rooms), "rooms.pq")
    assert claims.groups[5] == "claimed room 17" and claims.groups[9] == "in no claimed room"
    assert len(set(claims.colours.values())) == len(set(claims.groups)) == len(claims.colours)
    assert np.flatnonzero(claims.wrong).tolist() == [5, 6, 7, 9]
    np.testing.assert_array_equal(claims.frames, true.estimate.frames)


def test_labels_have_the_colours_of_reports(true):
    labels = true.true_labels.copy()
    labels[4], labels[6] = -1, (labels[6] + 1) % 2
    for figure in ("labels.accuracy", None):
        claims = shown(claiming(true, labels=labels), figure)
        assert claims.groups[4] == "no label" and claims.groups[6].removeprefix("labelled ") in true.room_names
        assert claims.colours["labelled kitchen"] == "#e8891c"
        assert np.flatnonzero(claims.wrong).tolist() == [4, 6]


def test_floors_are_shown_for_figures_of_floors(true):
    floors = true.true_storeys.copy()
    floors[3], floors[4] = 2, -1
    claims = shown(claiming(true, floors=floors), "floors.accuracy")
    assert claims.groups[2:5] == ("claimed floor 0", "claimed floor 2", "claimed to be on stairs")
    assert np.flatnonzero(claims.wrong).tolist() == [3, 4]


def test_figures_of_the_trajectory_show_no_other_claims(true):
    poses = true.true_poses.copy()
    poses[:, 0, 3] *= 1.05
    for figure in ("trajectory.ate_m", None):
        claims = shown(claiming(true, T_W_B=poses), figure)
        assert claims.groups == () and claims.wrong is None
        np.testing.assert_array_equal(claims.T_W_B, aligned(poses, true.true_poses))


def test_figures_that_describe_the_run_as_a_whole_show_no_claims(true):
    run = claiming(true, labels=(true.true_labels + 1) % 2)
    claims = claimed_frames(run, "coverage.path_covered", first_wrong(run))
    assert claims.groups == () and claims.wrong is None and not claims.names_labels


def test_the_estimate_agrees_with_the_truth_where_a_wrong_motion_begins(true):
    poses = true.true_poses.copy()
    poses[20:, 0, 3] += 2.0
    run = claiming(true, T_W_B=np.linalg.inv(poses[0]) @ poses)
    wrong = first_wrong(run, "trajectory.ate_m")
    claims = claimed_frames(run, "trajectory.ate_m", wrong)
    since, end = (int(np.flatnonzero(run.estimate.frames == frame)[0]) for frame in (wrong.since, wrong.frame))
    np.testing.assert_allclose(claims.T_W_B[: since + 1], true.true_poses[: since + 1], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm((claims.T_W_B - true.true_poses)[end, :3, 3]), 2.0)


def test_what_is_not_claimed_is_not_shown(true):
    claims = shown(claiming(true, T_W_B=None, labels=None, rooms=true.true_rooms * 0), "rooms.pq")
    assert claims.T_W_B is None and set(claims.groups) == {"claimed room 0"}
