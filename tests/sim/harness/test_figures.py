"""Figures of a run: what depends on time depends on the true time, whatever the clock of the robot says."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from lexis.evaluation.loops import true_revisits
from lexis.maths.se3 import between
from sim.faults.poses import Kidnap
from sim.faults.stamps import StampJitter, StampJump
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.diagnosis.usual_mistakes import usual_mistakes
from sim.harness.estimate import EstimatedLoops
from sim.harness.scenario_sessions import picture_session
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms
from worlds.truth import room_at

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


def test_floors_are_numbered_from_the_lowest_that_the_walk_visits():
    """No SLAM can know of a storey below it on which it has never been."""
    house = sample_from_rooms(("kitchen", "bedroom", "bathroom"), 103, storeys=2)
    upstairs = Scenario(house=house, tour_kind="random", length_m=15.0, frame_rate_hz=2.0, fidelity="features", seed=0)
    finished = run(upstairs, GeometricRooms())
    assert set(finished.true_storeys.tolist()) == {1} and set(finished.estimate.floors.tolist()) == {0}
    floors = evaluate(finished).floors
    assert (floors.accuracy, floors.count_error) == (1.0, 0)
    assert not list(usual_mistakes(finished))


def test_a_frame_belongs_to_the_room_of_its_camera_also_if_the_camera_is_in_front_of_the_body():
    ahead = replace(OPEN_FLAT, rig=RigConfig(lever_arm_m=(0.15, 0.0, 0.0)))
    session = picture_session(ahead)
    bodies = session.tour.T_W_B
    cameras = (bodies @ session.camera.T_B_C)[:, :3, 3]
    rooms = np.array([truth.room for truth in session.truths])
    np.testing.assert_array_equal(rooms, room_at(session.house, cameras))
    assert (rooms != room_at(session.house, bodies[:, :3, 3])).any()
