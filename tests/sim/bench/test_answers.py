"""The benchmark of everyday questions judges the rooms of a map by where its images were truly taken."""

from dataclasses import replace

from helpers.open_flat import OPEN_FLAT

from sim.bench.answers import true_rooms
from sim.harness import run
from sim.harness.adapters import Lexis
from worlds.truth import room_at


def test_the_true_room_of_a_mapped_room_is_that_of_the_camera():
    rig, slam = replace(OPEN_FLAT.rig, lever_arm_m=(0.15, 0.0, 0.0)), Lexis("oracle")
    finished = run(replace(OPEN_FLAT, seed=6, frame_rate_hz=5.0, rig=rig), slam)
    assert (finished.true_rooms != room_at(finished.house, finished.true_poses[:, :3, 3])).any()
    single = [replace(slam.map.rooms[0], id=k, keyframes=(k,)) for k in range(len(slam.map.keyframes))]
    assert true_rooms(finished, replace(slam.map, rooms=tuple(single))).tolist() == finished.true_rooms.tolist()
