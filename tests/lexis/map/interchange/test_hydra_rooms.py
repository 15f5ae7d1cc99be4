"""The room file has the form that Hydra's `room_io.cpp` parses, and its boxes are the rooms."""

import numpy as np
import pytest
import yaml
from helpers.map_builder import build_map
from helpers.two_rooms import two_rooms

from lexis.map.export import export_map
from lexis.map.interchange.hydra_rooms import hydra_rooms

POINTS = {(2.0, 3.0, 1.0): 0, (6.0, 1.0, 1.0): 1, (9.0, 2.0, 3.0): 2, (2.0, 3.0, 9.0): None, (-1.0, 2.0, 1.0): None}


@pytest.fixture
def rooms(tmp_path):
    export_map(two_rooms(np.random.default_rng(3)), "hydra", tmp_path / "rooms.yaml")
    return yaml.safe_load((tmp_path / "rooms.yaml").read_text())


def room_at(rooms, point):
    """The first room with a box that contains the point, as Hydra's `RoomGeometry::findRoomIndex`."""
    for room, boxes in sorted(rooms.items()):
        for box in boxes:
            if (np.abs(np.array(point) - box["center"]) <= np.array(box["extents"]) / 2 + 1e-6).all():
                return room
    return None


def test_the_form_is_hydras(rooms):
    assert list(rooms) == [0, 1, 2]
    for boxes in rooms.values():
        for box in boxes:
            assert len(box["center"]) == len(box["extents"]) == 3 and min(box["extents"]) > 0
            assert box["rotation"] == {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}


def test_points_lie_in_their_rooms(rooms):
    assert {point: room_at(rooms, point) for point in POINTS} == POINTS


def test_every_keyframe_lies_in_its_room(rooms):
    lexis_map = two_rooms(np.random.default_rng(3))
    assert [room_at(rooms, T[:3, 3]) for T in lexis_map.T_W_B] == lexis_map.room_of.tolist()


def test_a_room_whose_only_keyframe_shares_its_cell_with_another_room_has_a_box_too(rng):
    rooms = [("kitchen", [0, 1]), ("office", [2])]
    positions = [[1.0, 2.0, 1.4], [3.04, 2.04, 1.4], [3.06, 2.06, 1.4]]
    lexis_map = build_map(positions, [0, 0, 1], rooms, ("kitchen", "office"), rng)
    boxes = hydra_rooms(lexis_map)
    assert len(boxes[1]) == 1
    assert room_at({1: boxes[1]}, (3.06, 2.06, 1.4)) == 1
    assert room_at({1: boxes[1]}, (3.2, 2.06, 1.4)) is None
