"""The summary of a map, as numbers and as a picture."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from helpers.map_builder import corridor_with_offices

from lexis.inputs import MAX_VARIANCE
from lexis.map.info import info_text, map_info
from lexis.map.picture import map_svg
from lexis.types import LexisMap

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def lexis_map(rng):
    return corridor_with_offices(rng, loops=[(25, 3), (38, 12)], weights=[1.0, 0.25])


def test_figures_are_those_of_the_map(lexis_map):
    info = map_info(lexis_map)
    assert (info["keyframes"], info["floors"], info["loops"], info["trusted_loops"]) == (40, [0], 2, 1)
    assert info["path_m"] == pytest.approx(np.linalg.norm(np.diff(lexis_map.T_W_B[:, :3, 3], axis=0), axis=1).sum())
    assert info["duration_s"] == pytest.approx(19.5)
    assert [(room["name"], room["label"], room["floor"], room["keyframes"]) for room in info["rooms"]] == [
        ("corridor", "corridor", 0, 20),
        ("office 1", "office", 0, 10),
        ("office 2", "office", 0, 10),
    ]
    assert info["unused_room_names"] == ["kitchen"] and info["encoder"]["name"] == "test"


def test_the_path_is_without_the_step_in_which_the_robot_was_carried(lexis_map):
    T_W_B = lexis_map.T_W_B.copy()
    T_W_B[20:, 1, 3] += 2.0
    keyframes = list(lexis_map.keyframes)
    keyframes[20] = replace(keyframes[20], step_covariance=MAX_VARIANCE * np.eye(6))
    before, after = map_info(lexis_map), map_info(replace(lexis_map, T_W_B=T_W_B, keyframes=tuple(keyframes)))
    step_m = np.linalg.norm(lexis_map.T_W_B[20, :3, 3] - lexis_map.T_W_B[19, :3, 3])
    assert (before["carried_before"], after["carried_before"]) == ([], [20])
    assert after["path_m"] == pytest.approx(before["path_m"] - step_m)
    assert "carried     elsewhere before keyframe 20" in info_text(after).splitlines()
    assert not any(line.startswith("carried") for line in info_text(before).splitlines())


def test_the_text_names_every_room_with_its_floor_and_keyframes(lexis_map):
    stairs = replace(lexis_map, rooms=(*lexis_map.rooms[:2], replace(lexis_map.rooms[2], floor=None)))
    lines = info_text(map_info(stairs)).splitlines()
    probable = [f"{stairs.probability_of(room):.0%}" for room in stairs.rooms]
    assert [line.split() for line in lines[-3:]] == [
        ["corridor", "0", "20", probable[0]],
        ["office", "1", "0", "10", probable[1]],
        ["office", "2", "stairs", "10", probable[2]],
    ]
    assert "loop edges  2, of which 1 trusted (weight at least 0.5)" in lines


def test_the_picture_has_a_dot_per_keyframe_an_edge_per_loop_and_the_names_of_rooms(lexis_map):
    svg = ElementTree.fromstring(map_svg(lexis_map))
    assert len([*svg.iter(f"{SVG}circle")]) == 40
    kinds = [path.get("class") for path in svg.iter(f"{SVG}path")]
    assert (kinds.count("walk"), kinds.count("loop"), kinds.count("doubted")) == (39, 1, 1)
    names = [text.text for text in svg.iter(f"{SVG}text") if text.get("class") == "name"]
    assert names == ["corridor", "office 1", "office 2"]
    colours = {dot.find(f"{SVG}title").text.split(": ")[1]: dot.get("fill") for dot in svg.iter(f"{SVG}circle")}
    assert len(set(colours.values())) == 3


def test_the_picture_has_no_step_between_two_sessions(lexis_map):
    keyframes = tuple(replace(keyframe, session=int(keyframe.id >= 20)) for keyframe in lexis_map.keyframes)
    paths = ElementTree.fromstring(map_svg(replace(lexis_map, keyframes=keyframes))).iter(f"{SVG}path")
    assert [path.get("class") for path in paths].count("walk") == 38


def test_every_dot_lies_in_the_picture_with_x_to_the_right_and_y_up(lexis_map):
    svg = ElementTree.fromstring(map_svg(lexis_map))
    width, height = (float(value) for value in svg.get("viewBox").split()[2:])
    dots = np.array([[float(dot.get("cx")), float(dot.get("cy"))] for dot in svg.iter(f"{SVG}circle")])
    assert (dots > 1).all() and (dots < [width - 1, height - 1]).all()
    offset = dots - lexis_map.T_W_B[:, :2, 3] * [1, -1]
    np.testing.assert_allclose(offset, np.broadcast_to(offset[0], offset.shape), atol=0.011)


def test_floors_stand_side_by_side_and_keyframes_on_stairs_on_each(lexis_map):
    floors = np.repeat([0, -1, 1], [10, 10, 20])
    svg = ElementTree.fromstring(map_svg(replace(lexis_map, floors=floors)))
    plans = [group for group in svg.iter(f"{SVG}g")]
    assert [next(plan.iter(f"{SVG}text")).text for plan in plans] == ["floor 0", "floor 1"]
    assert [len([*plan.iter(f"{SVG}circle")]) for plan in plans] == [20, 30]


def test_a_map_of_stairs_alone_and_names_with_markup_can_be_drawn(lexis_map):
    odd = replace(lexis_map.rooms[0], label="<b>&")
    svg = ElementTree.fromstring(map_svg(replace(lexis_map, floors=np.full(40, -1), rooms=(odd, *lexis_map.rooms[1:]))))
    texts = [text.text for text in svg.iter(f"{SVG}text")]
    assert "stairs alone" in texts and "<b>&" in texts


def test_the_rooms_of_all_keyframes_are_collected_once_for_each_floor(lexis_map, monkeypatch):
    room_of, reads = LexisMap.room_of.fget, []
    monkeypatch.setattr(LexisMap, "room_of", property(lambda lexis_map: reads.append(lexis_map) or room_of(lexis_map)))
    map_svg(lexis_map)
    assert len(reads) <= 1
