"""LEXIS in a house with a lift: floors, labels, plans; with images during the ride and without."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from lexis.floors import NO_FLOOR
from lexis.stairs import lift_rides
from sim.faults.fault import StreamFault
from sim.harness import Scenario, run, try_plans
from worlds.presets import sample_from_rooms
from worlds.variant import variant


@dataclass(frozen=True)
class NoImagesInALift(StreamFault):
    """No images arrive while the body rises or sinks."""

    name = "no-images-in-a-lift"

    def apply(self, stream, rng):
        """Yield the stream without the frames during a ride."""
        height = None
        for observation, truth in stream:
            still = height is None or abs(truth.T_W_B[2, 3] - height) < 1e-3
            height = truth.T_W_B[2, 3]
            if still:
                yield observation, truth


@pytest.fixture(scope="module", params=[(), (NoImagesInALift(),)], ids=["images", "no images"])
def finished(request):
    rooms = ("kitchen", "living room", "bedroom", "office", "bathroom")
    house = variant(sample_from_rooms(rooms, 103, storeys=2, clutter=0.5), climb="lift")
    return run(replace(Scenario(seed=103, fidelity="features", frame_rate_hz=5.0, house=house), faults=request.param))


def test_every_ride_changes_the_floor(finished):
    lexis_map = finished.slam.map
    rides = lift_rides(lexis_map.T_W_B[:, :3, 3])
    assert len(rides) == 2 and set(lexis_map.floors.tolist()) <= {NO_FLOOR, 0, 1}
    assert [lexis_map.floors[[ride.start, ride.stop - 1]].tolist() for ride in rides] == [[0, 1], [1, 0]]
    right = lexis_map.floors == finished.true_storeys
    assert right[~finished.on_stairs].all()


def test_only_keyframes_in_the_moving_lift_are_labelled_as_stairs(finished):
    lexis_map = finished.slam.map
    moving = np.zeros(len(lexis_map.floors), bool)
    for ride in lift_rides(lexis_map.T_W_B[:, :3, 3]):
        moving[ride.start + 1 : ride.stop - 1] = True
    stairs = np.array([lexis_map.label_of(i) == "stairs" for i in range(len(moving))])
    np.testing.assert_array_equal(stairs, moving)
    assert moving.any() == (finished.scenario.faults == ())


def test_a_robot_drives_plans_through_the_lift(finished):
    trials = try_plans(finished)
    rides = [trial for trial in trials if len(trial.planned) and np.ptp(trial.planned[:, 2]) > 1.0]
    assert rides and np.mean([trial.success for trial in rides]) >= 0.8
