"""The first wrong frame is the first one at which what a figure measures is wrong."""

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from sim.harness import Estimate, EstimatedLoops, Scenario, evaluate, run
from sim.harness.diagnosis.first_wrong import _position, first_wrong, wrong_labels
from sim.harness.failures.estimated_frames import estimated_frames
from sim.harness.failures.why_page import wrong_frame_page
from sim.harness.report_data import report_data
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)
WRONG = 7
"""The row that is wrong; row 9 is wrong, too."""


class Frames:
    """Takes every frame, and estimates nothing."""

    def start(self, camera, room_names):
        self.frames = []

    def process(self, observation):
        self.frames.append(observation.index)

    def finish(self):
        return Estimate(np.array(self.frames))


@pytest.fixture(scope="module")
def silent():
    return run(SCENARIO, Frames())


@pytest.fixture(scope="module")
def true(silent):
    """A run that estimates the truth."""
    loops = EstimatedLoops(np.array([5]), np.array([3]), np.eye(4)[None], np.ones(1))
    poses = silent.true_poses
    loops = replace(loops, T_match_query=np.linalg.inv(poses[3:4]) @ poses[5:6])
    estimates = Estimate(
        silent.estimate.frames,
        T_W_B=poses,
        labels=silent.true_labels,
        rooms=silent.true_rooms,
        floors=silent.true_storeys,
        loops=loops,
        similarities=np.tile(np.linspace(0.3, 0.1, len(silent.room_names)), (len(poses), 1)),
    )
    return replace(silent, estimate=estimates)


def spoilt(estimate):
    """The estimate with rows `WRONG` and 9 changed."""
    changed = estimate.copy()
    if estimate.ndim == 3:
        changed[[WRONG, 9], 0, 3] += 5.0
    else:
        changed[[WRONG, 9]] = (changed[[WRONG, 9]] + 1) % 2
    return changed


@pytest.mark.parametrize(
    ("name", "figure", "said"),
    [
        ("labels", "labels.accuracy", "labelled "),
        ("labels", "rooms.pq", "labelled "),
        ("labels", None, "labelled "),
        ("rooms", "rooms.pq", "in the estimated room "),
        ("floors", "floors.accuracy", "estimated on floor 1, is on floor 0"),
        ("T_W_B", "trajectory.ate_m", "from 1.2 s to 1.8 s the estimate moves "),
    ],
)
def test_the_first_of_two_wrong_frames_is_found(true, name, figure, said):
    estimates = replace(true.estimate, **{name: spoilt(getattr(true.estimate, name))})
    found = first_wrong(replace(true, estimate=estimates), figure)
    assert found.frame == true.estimate.frames[WRONG] and found.what.startswith(said)
    assert found.time_s == pytest.approx(true.stamps[WRONG] - true.stamps[0])
    assert found.room == true.house.rooms[true.true_rooms[WRONG]].id
    assert bool(found.similarities) == (figure is None or figure.startswith(("labels", "rooms")))


def test_a_false_loop_is_found_at_its_query(true):
    assert first_wrong(true, "loops.precision") is None
    far = np.eye(4)[None].copy()
    far[0, 0, 3] = 9.0
    moved = replace(true.estimate.loops, T_match_query=far)
    found = first_wrong(replace(true, estimate=replace(true.estimate, loops=moved)), "loops.precision")
    assert found.frame == true.estimate.frames[5] and found.what.startswith("a false loop closure with the frame at 0.")


def test_the_truth_has_no_wrong_frame(true):
    for figure in ("labels.accuracy", "rooms.pq", "floors.accuracy", "loops.precision"):
        assert first_wrong(true, figure) is None
    assert first_wrong(true) is None


@pytest.mark.parametrize(
    "figure", ["coverage.path_covered", "place_recognition.1.precision", "time.slam_s", "run.keyframes", "faults.refused"]
)
def test_no_frame_is_named_for_a_figure_that_describes_the_run_as_a_whole(true, figure):
    wrong = replace(true, estimate=replace(true.estimate, labels=spoilt(true.estimate.labels)))
    assert first_wrong(wrong, "planning.success").what.startswith("labelled ")
    assert first_wrong(wrong, figure) is None


def test_where_nothing_is_estimated_nothing_is_wrong(silent):
    for figure in (None, "labels.accuracy", "rooms.pq", "floors.accuracy", "loops.precision", "trajectory.ate_m"):
        assert first_wrong(silent, figure) is None


def test_a_frame_in_no_estimated_room_is_said_to_be_in_none(true):
    rooms = true.true_rooms.copy()
    rooms[WRONG] = -1
    found = first_wrong(replace(true, estimate=replace(true.estimate, rooms=rooms)), "rooms.pq")
    assert (found.frame, found.what) == (true.estimate.frames[WRONG], "in no estimated room")


def test_a_room_has_the_same_name_in_words_on_the_plan_and_in_the_report(true):
    rooms = true.true_rooms.copy()
    rooms[WRONG] = 8
    wrong = replace(true, estimate=replace(true.estimate, rooms=rooms))
    found = first_wrong(wrong, "rooms.pq")
    name = f"estimated room 8 ({true.room_names[true.true_labels[WRONG]]})"
    assert found.what.startswith(f"in the {name}, though most of this room is the estimated room ")
    assert estimated_frames(wrong, "rooms.pq", found).groups[WRONG] == name
    assert name == f"estimated {report_data(wrong, evaluate(wrong)).keyframes.predicted_rooms[WRONG]}"


def test_a_frame_without_a_label_is_said_to_have_none(true):
    labels = true.true_labels.copy()
    labels[WRONG] = -1
    found = first_wrong(replace(true, estimate=replace(true.estimate, labels=labels)))
    assert found.what == f"no label, is {true.room_names[true.true_labels[WRONG]]}"


@pytest.mark.parametrize("figure", ["labels.accuracy", "labels.accuracy_graded"])
def test_a_figure_of_labels_and_the_wrong_frames_agree(figure):
    silent = run(OPEN_FLAT, Frames())
    late = np.concatenate([silent.true_labels[:1], silent.true_labels[:-1]])  # wrong only at borders, where both may count
    late[[-3, -1]] = -1
    wrong = replace(silent, estimate=Estimate(silent.estimate.frames, labels=late))
    rows = np.flatnonzero(wrong_labels(wrong, figure))
    found = first_wrong(wrong, figure)
    assert len(rows) == round((1.0 - evaluate(wrong)[figure]) * len(late)) > 0
    assert found.frame == wrong.estimate.frames[rows[0]]
    np.testing.assert_array_equal(np.flatnonzero(estimated_frames(wrong, figure, found).wrong), rows)
    assert f" of {len(rows)} frames with a wrong label." in "".join(wrong_frame_page(wrong, figure).lines)
    assert (rows[0] < np.flatnonzero(wrong_labels(wrong, "labels.accuracy_graded"))[0]) == (figure == "labels.accuracy")


def estimating(run, poses):
    return replace(run, estimate=replace(run.estimate, T_W_B=poses))


def with_odometry(run, poses):
    frames = run.estimate.frames.tolist()
    given = {frame: run.given[frame]._replace(T_O_B=T) for frame, T in zip(frames, poses, strict=True)}
    return replace(run, given=given)


def step_of(x=0.0, y=0.0, yaw=0.0):
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:2, 3] = x, y
    return T


def spliced(poses, row, step):
    """The poses with an additional step, in the body frame, before the pose in a row; all later motion is unchanged."""
    before = poses[row - 1]
    later = before @ step @ np.linalg.inv(before) @ poses[row:]
    return np.concatenate([poses[:row], later])


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (step_of(x=-2.0), r"the estimate moves \d\.\d\d m back.*, but the robot moves 0\.\d\d m ahead.*"),
        (step_of(y=-2.0), r"the estimate moves .*[12]\.\d\d m to the right, but the robot moves .*"),
        (step_of(yaw=1.5), r"the estimate.* turns \d+° to the left, but the robot.* turns \d+° to the (left|right)"),
    ],
)
def test_the_first_wrong_motion_is_found_and_not_the_frame_that_alignment_moves_most(true, step, said):
    found = first_wrong(estimating(true, spliced(true.true_poses, 20, step)), "trajectory.ate_m")
    frames = true.estimate.frames
    assert (found.frame, found.since) == (frames[20], frames[18])
    assert re.fullmatch(r"from 4\.5 s to 5\.0 s " + said, found.what)


def test_increments_that_are_composed_on_the_wrong_side_are_wrong_where_the_robot_has_turned(true):
    steps = np.linalg.inv(true.true_poses[:-1]) @ true.true_poses[1:]
    poses = [np.eye(4)]
    for step in steps:
        poses.append(step @ poses[-1])
    found = first_wrong(estimating(true, np.array(poses)), "trajectory.ate_m")
    assert 0.0 < found.time_s < 5.0 and "the estimate moves" in found.what


def test_what_the_odometry_has_wrong_as_well_does_not_stand_out(true):
    poses = spliced(true.true_poses, 20, step_of(x=-2.0))
    found = first_wrong(with_odometry(estimating(true, poses), poses), "trajectory.ate_m")
    assert found.since is None and "m off after alignment of the whole path, more than anywhere else" in found.what


def test_a_slow_drift_is_reported_where_the_error_is_largest(true):
    poses = true.true_poses.copy()
    poses[:, 0, 3] *= 1.05
    found = first_wrong(estimating(true, poses), "trajectory.ate_m")
    assert found.since is None and re.fullmatch(
        r"the position is 0\.\d\d m off after alignment of the whole path, .*", found.what
    )


@pytest.mark.parametrize(("axis", "scale", "how"), [(0, 1.0, "off"), (2, 1.0, "too high"), (2, -1.0, "too low")])
def test_an_error_in_height_is_called_too_high_or_too_low(true, axis, scale, how):
    poses = true.true_poses.copy()
    poses[WRONG, axis, 3] += scale
    *_, found = _position(estimating(true, poses))  # after the wrong motion
    assert found.row == WRONG and f" m {how} after alignment" in found.what


def test_an_error_too_small_to_see_from_frame_to_frame_is_seen_over_half_a_second(true):
    poses = true.true_poses.copy()
    poses[10:, :3, 3] = poses[10, :3, 3] + 0.5 * (poses[10:, :3, 3] - poses[10, :3, 3])
    steps_m = np.linalg.norm(np.diff(poses[:, :3, 3] - true.true_poses[:, :3, 3], axis=0), axis=1)
    found = first_wrong(estimating(true, poses), "trajectory.rpe_8m_m")
    assert steps_m.max() < 0.1
    assert re.fullmatch(
        r"from 2\.5 s to 3\.0 s the estimate moves 0\.1\d m ahead, but the robot moves 0\.3\d m ahead", found.what
    )


def test_poses_without_any_error_are_not_said_to_be_wrong(true):
    assert first_wrong(true, "trajectory.ate_m") is None
    one = Estimate(true.estimate.frames[:1], T_W_B=true.true_poses[:1])
    assert first_wrong(replace(true, estimate=one), "trajectory.ate_m") is None


def test_without_a_figure_the_trajectory_counts_once_no_label_is_wrong(true):
    poses = spliced(true.true_poses, 20, step_of(x=-2.0))
    assert first_wrong(estimating(true, poses)).what.startswith("no label is wrong; from 4.5 s to 5.0 s the estimate moves ")
    silent = replace(estimating(true, poses), estimate=Estimate(true.estimate.frames, T_W_B=poses))
    assert first_wrong(silent).what.startswith("from 4.5 s to 5.0 s the estimate moves ")


def test_a_room_is_named_by_its_label_too_where_labels_are_at_stake_and_by_its_id_alone_elsewhere(true):
    rooms = tuple(replace(room, id=f"hall 0.{k}") for k, room in enumerate(true.house.rooms))
    renamed = replace(true, house=replace(true.house, rooms=rooms))
    estimates = {name: spoilt(getattr(true.estimate, name)) for name in ("labels", "rooms", "floors", "T_W_B")}
    wrong = replace(renamed, estimate=replace(true.estimate, **estimates))
    k = int(true.true_rooms[WRONG])
    for figure in ("labels.accuracy", "rooms.pq", None):
        assert first_wrong(wrong, figure).room == f"hall 0.{k} ({rooms[k].label})"
    unlabelled = replace(wrong, estimate=replace(wrong.estimate, labels=None))
    for run_, figure in ((wrong, "floors.accuracy"), (wrong, "trajectory.ate_m"), (unlabelled, "rooms.pq")):
        found = first_wrong(run_, figure)
        assert found.room == f"hall 0.{k}" and "(" not in found.what
