"""The plain adapters estimate what they say and no more; they are right where their rule holds, and wrong elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.documentation import blocks

from lexis.errors import ObservationError
from lexis.floors import NO_FLOOR
from lexis.maths.se3 import between
from lexis.types import Camera, Intrinsics, Observation
from sim.errors import SimError
from sim.faults.delivery import Duplicated
from sim.faults.poses import OdometryNaN
from sim.harness import Scenario, check, run
from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.adapters.geometric_rooms import ROOM_M, floors_by_height, rooms_by_distance
from sim.harness.results import FloorFigures, LabelFigures, LoopFigures, RoomFigures, TrajectoryFigures
from sim.suites.changed_stream import changed
from sim.suites.stream_changes import ReusedArrays
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)
CAMERA = Camera(Intrinsics(8, 6, 5.0, 5.0, 3.5, 2.5), np.eye(4))
BLACK = np.zeros((6, 8, 3), np.uint8)


def observation(index, x, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return Observation(index, 0.1 * index, BLACK, pose, np.zeros((6, 6)))


class Chained(OdometryOnly):
    """Adds up the steps between the poses of the odometry."""

    def finish(self):
        estimate = super().finish()
        poses = estimate.T_W_B[:1]
        for step in between(estimate.T_W_B[:-1], estimate.T_W_B[1:]):
            poses = np.concatenate([poses, poses[-1:] @ step])
        return replace(estimate, T_W_B=poses)


def test_odometry_only_estimates_poses_alone():
    result = check(SCENARIO, OdometryOnly())
    assert result.trajectory.ate_m == result.trajectory.ate_odometry_m > 0.0
    assert (result.labels, result.rooms, result.floors, result.loops) == (
        LabelFigures(), RoomFigures(), FloorFigures(), LoopFigures(),
    )  # fmt: skip
    assert result.planning.success is None and result.encoder is None and result.slam == "OdometryOnly"


@pytest.mark.parametrize("slam", [OdometryOnly, Chained])
def test_the_error_of_poses_that_are_right_up_to_rounding_is_zero(slam):
    result = check(replace(SCENARIO, odometry="perfect"), slam())
    assert result.trajectory == TrajectoryFigures(0.0, 0.0, 0.0, 0.0, None, None)


def test_keyframes_are_half_a_metre_of_path_apart():
    slam = OdometryOnly()
    slam.start(CAMERA, ("kitchen",))
    for k in range(101):
        slam.process(observation(k, 0.1 * k if k < 50 else 10.0 - 0.1 * k))
    steps = np.diff(slam.finish().frames)
    assert (steps[:9] <= 6).all() and (steps >= 5).all() and len(steps) in range(16, 21)


@pytest.mark.parametrize("slam", [OdometryOnly, GeometricRooms])
def test_an_array_that_is_overwritten_after_a_call_does_not_change_the_estimates(slam):
    kept, reused = (run(SCENARIO, tested).estimate for tested in (slam(), changed(slam(), ReusedArrays())))
    np.testing.assert_array_equal(kept.frames, reused.frames)
    np.testing.assert_array_equal(kept.T_W_B, reused.T_W_B)


def test_a_second_run_forgets_the_first():
    slam = GeometricRooms()
    first, second = run(SCENARIO, slam).estimate, run(SCENARIO, slam).estimate
    np.testing.assert_array_equal(first.frames, second.frames)
    np.testing.assert_array_equal(first.rooms, second.rooms)


def test_geometric_rooms_estimates_rooms_and_floors_and_no_labels():
    result = check(SCENARIO, GeometricRooms())
    assert result.labels == LabelFigures() and result.loops == LoopFigures()
    assert result.floors == FloorFigures(1.0, 0) and 0.0 <= result.rooms.pq < 1.0


def test_two_storeys_are_found_and_landings_belong_to_the_stairs(rng):
    flight = np.linspace(0.0, 1.35, 5)[1:-1]
    truth = [0.0] * 60 + [*flight, *[1.35] * 4, *(1.35 + flight)] + [2.7] * 50
    floors = floors_by_height(np.array(truth) + 1.4 + rng.uniform(-0.05, 0.05, len(truth)))
    assert (floors[:59] == 0).all() and (floors[-49:] == 1).all()
    assert (floors[60:-50] == NO_FLOOR).all()


def test_a_climb_without_level_stretches_has_no_floor():
    assert (floors_by_height(0.5 * np.arange(10.0)) == NO_FLOOR).all()


def test_rooms_never_cross_floors_and_are_no_larger_than_the_cut_off(rng):
    positions = rng.uniform(0.0, 12.0, (80, 3)) * [1.0, 1.0, 0.0]
    floors = rng.integers(-1, 2, 80)
    rooms = rooms_by_distance(positions, floors)
    for room in range(rooms.max() + 1):
        members = np.flatnonzero(rooms == room)
        assert len(members) and len(set(floors[members].tolist())) == 1
        assert np.linalg.norm(positions[members, None] - positions[members], axis=2).max() <= ROOM_M


def test_groups_that_are_close_together_are_one_room_and_a_long_room_is_split():
    near, far = np.zeros((5, 3)), np.zeros((5, 3))
    far[:, 0] = 20.0
    assert rooms_by_distance(np.vstack([near, far]), np.zeros(10, int)).tolist().count(0) == 5
    hall = np.zeros((41, 3))
    hall[:, 0] = np.linspace(0.0, 20.0, 41)
    assert len(set(rooms_by_distance(hall, np.zeros(41, int)).tolist())) >= 4
    assert rooms_by_distance(hall[:1], np.zeros(1, int)).tolist() == [0]


@pytest.mark.parametrize("slam", [OdometryOnly, GeometricRooms])
def test_observations_of_the_past_and_unusable_poses_are_refused(slam):
    tested = slam()
    tested.start(CAMERA, ("kitchen",))
    with pytest.raises(SimError, match="was given no usable observation"):
        tested.finish()
    tested.process(observation(3, 0.0))
    with pytest.raises(ObservationError, match="observation 3 comes after 3"):
        tested.process(observation(3, 1.0))
    with pytest.raises(ObservationError, match="T_O_B is unusable"):
        tested.process(observation(4, np.nan))
    assert tested.finish().frames.tolist() == [3]


def test_runs_with_faults_end():
    faulty = Scenario(**{**vars(SCENARIO), "faults": (Duplicated(0.2), OdometryNaN(at_s=3.0, for_s=2.0))})
    assert check(faulty, GeometricRooms()).faults.refused > 5


def test_the_classes_of_the_documentation_can_be_put_under_test():
    names = {}
    for block in blocks("sim/pages/your-slam.md"):
        if block.language == "python":
            exec(compile(block.content, "your-slam.md", "exec"), names)
    assert names["result"].labels.accuracy > 0.7 and names["result"].trajectory.ate_m is None
    result = check(SCENARIO, names["MySlam"]())
    assert result.trajectory.ate_m == result.trajectory.ate_odometry_m
    assert result.rooms.recall < 0.5 and result.floors.accuracy == 1.0 and result.labels.accuracy is None
