"""Houses that cannot be: each is refused with the room and the rule."""

import json

import numpy as np
import pytest

from worlds.errors import HouseError
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec
from worlds.validation import validate


def two_rooms(**change):
    storey = {
        "rooms": [
            {"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [4, 0], [4, 3], [0, 3]]},
            {"id": "b", "label": "bedroom", "polygon_m": [[4, 0], [8, 0], [8, 3], [4, 3]]},
        ],
        "openings": [{"rooms": ["a", "b"], "kind": "door", "start_m": [4, 1], "end_m": [4, 1.9]}],
    }
    return HouseSpec.from_json(json.dumps({"storeys": [storey | change]}))


def refusal(spec):
    with pytest.raises(HouseError) as error:
        validate(build_house(spec))
    assert "\n" not in str(error.value)
    return str(error.value)


def test_the_house_itself_stands():
    validate(build_house(two_rooms()))


def test_no_door_no_way():
    assert "not reachable on foot" in refusal(two_rooms(openings=[]))


def test_a_door_too_narrow_for_the_body():
    assert "0.50 m wide" in refusal(
        two_rooms(openings=[{"rooms": ["a", "b"], "kind": "door", "start_m": [4, 1], "end_m": [4, 1.5]}])
    )


def test_a_door_wider_than_its_wall():
    assert "lie in the wall" in refusal(
        two_rooms(openings=[{"rooms": ["a", "b"], "kind": "door", "start_m": [4, 1], "end_m": [4, 9]}])
    )


@pytest.mark.parametrize(
    "polygon", [[[3, 0], [8, 0], [8, 3], [3, 3]], [[1, 1], [2, 1], [2, 2], [1, 2]], [[2, 0], [6, 0], [6, 3], [2, 3]]]
)
def test_overlapping_rooms_are_named(polygon):
    rooms = [
        {"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [4, 0], [4, 3], [0, 3]]},
        {"id": "b", "label": "bedroom", "polygon_m": polygon},
    ]
    message = refusal(two_rooms(rooms=rooms, openings=[]))
    assert "'a'" in message and "'b'" in message and "overlap" in message


@pytest.mark.parametrize(("low", "high"), [(1, 1.9), (1.5, 2.5), (0.9, 2.9)])
def test_openings_do_not_overlap(low, high):
    first = {"rooms": ["a", "b"], "kind": "door", "start_m": [4, 1], "end_m": [4, 1.9]}
    second = {"rooms": ["b", "a"], "kind": "open", "start_m": [4, high], "end_m": [4, low]}
    assert "openings[0] and openings[1]" in refusal(two_rooms(openings=[first, second]))


def home(change):
    data = json.loads(sample_house("uh2-apt", 1).to_json())
    for level, storey in enumerate(data["storeys"]):
        change(level, storey, next(room for room in storey["rooms"] if room["label"] == "stairs"))
    return HouseSpec.from_json(json.dumps(data))


def test_stairs_are_rectangles():
    def cut_a_corner(level, storey, stairs):
        (x0, y0), (x1, y1) = np.min(stairs["polygon_m"], axis=0), np.max(stairs["polygon_m"], axis=0)
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        stairs["polygon_m"] = [[x0, y0], [x1, y0], [x1, y], [x, y], [x, y1], [x0, y1]]

    with pytest.raises(HouseError, match="must be a rectangle"):
        build_house(home(cut_a_corner))


def test_stairs_skip_no_storey():
    def leave_out(level, storey, stairs):
        if level == 1:
            stairs["label"] = "storage room"

    with pytest.raises(HouseError, match=r"storeys\[1\] has none"):
        build_house(home(leave_out))


def test_stairs_lead_somewhere():
    rooms = [
        {"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [4, 0], [4, 3], [0, 3]]},
        {"id": "b", "label": "stairs", "polygon_m": [[4, 0], [8, 0], [8, 3], [4, 3]]},
    ]
    assert "stairs 'b' join no storeys" in refusal(two_rooms(rooms=rooms))


@pytest.mark.parametrize("position", [[6, 1.5, 2.2], [6, 1.5, -0.2], [6, 1.5, 90]])
def test_furniture_is_between_floor_and_ceiling(position):
    piece = {"id": "f", "kind": "sofa", "room": "b", "position_m": position, "yaw_rad": 0, "size_m": [2, 1, 0.8], "seed": 1}
    assert "furniture 'f' (sofa) reaches from" in refusal(two_rooms(furniture=[piece]))


def test_furniture_that_sticks_out():
    piece = {
        "id": "f",
        "kind": "double bed",
        "room": "b",
        "position_m": [8, 1, 0],
        "yaw_rad": 0,
        "size_m": [1.6, 2.0, 0.5],
        "seed": 1,
    }
    assert "'f'" in refusal(two_rooms(furniture=[piece]))


def test_clockwise_rooms_are_refused():
    rooms = [{"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [0, 3], [4, 3], [4, 0]]}]
    assert "counter-clockwise" in refusal(two_rooms(rooms=rooms, openings=[]))
