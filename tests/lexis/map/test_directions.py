"""Directions of plans along walks with known turns, rooms and stairs."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.map_builder import build_map

from lexis.map.path_directions import directions, plan_summary
from lexis.planning import Plan
from lexis.types import LexisMap


def walked(rng, corners, rooms, floors=None):
    """A map along straight lines between corners (x, y, z) [m], and the plan from its first to its last keyframe."""
    corners = np.asarray(corners, float)
    lines = [a + (b - a) * np.linspace(0, 1, 9)[:-1, None] for a, b in pairwise(corners)]
    positions = np.concatenate([*lines, corners[-1:]])
    names = tuple(dict.fromkeys(label for label, _ in rooms))
    labels = np.zeros(len(positions), int)
    for label, members in rooms:
        labels[members] = names.index(label)
    lexis_map = build_map(positions, labels, rooms, names, rng)
    if floors is not None:
        on = tuple(replace(r, floor=None if r.label == "stairs" else int(floors[r.keyframes[0]])) for r in lexis_map.rooms)
        lexis_map = replace(lexis_map, floors=np.asarray(floors), rooms=on)
    length = float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
    return lexis_map, Plan(lexis_map.rooms[0], lexis_map.rooms[-1], tuple(range(len(positions))), length)


@pytest.mark.parametrize(
    ("corner", "turn"),
    [
        ((4, 4, 0), "turn left"),
        ((4, -4, 0), "turn right"),
        ((0, 0.1, 0), "turn around"),
        ((8, 3, 0), None),
        ((7, 4, 0), "turn left"),
    ],
)
def test_a_change_of_heading_by_more_than_45_degrees_is_a_turn(rng, corner, turn):
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0), corner], [("hall", range(17))])
    turns = [step for step in directions(lexis_map, plan) if step.text.startswith("turn")]
    assert [step.text for step in turns] == ([turn] if turn else [])
    assert not turns or turns[0].at_m == pytest.approx(4.0, abs=0.1)


def test_every_room_on_the_way_is_named_where_it_is_entered(rng):
    rooms = [("office", range(8)), ("corridor", range(8, 17)), ("office", range(17, 25))]
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0), (8, 0, 0), (12, 0, 0)], rooms)
    assert [(step.at_m, step.text) for step in directions(lexis_map, plan)] == [
        (0.0, "start in office 1 (floor 0)"),
        (4.0, "enter corridor (floor 0)"),
        (8.5, "enter office 2 (floor 0)"),
        (12.0, "arrive in office 2 (floor 0)"),
    ]


@pytest.mark.parametrize(("rise", "way"), [(3.0, "up"), (-3.0, "down")])
def test_stairs_are_climbed_or_descended_to_a_floor(rng, rise, way):
    rooms = [("hall", range(8)), ("stairs", range(8, 17)), ("attic", range(17, 25))]
    floors = np.repeat([0, -1, 1], [8, 9, 8])
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0), (8, 0, rise), (12, 0, rise)], rooms, floors)
    texts = [step.text for step in directions(lexis_map, plan)]
    assert texts == [
        "start in hall (floor 0)",
        "enter stairs (between floors)",
        f"take the stairs {way} to floor 1",
        "enter attic (floor 1)",
        "arrive in attic (floor 1)",
    ]


@pytest.mark.parametrize(("rise", "way"), [(3.0, "up"), (-3.0, "down")])
@pytest.mark.parametrize("stops", [False, True], ids=["images", "no images"])
def test_a_ride_in_a_lift_is_told_as_such(rng, rise, way, stops):
    rooms = [("hall", range(9)), ("stairs", range(9, 16)), ("attic", range(16, 25))]
    floors = np.repeat([0, -1, 1], [9, 7, 9])
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0), (4, 0, rise), (8, 0, rise)], rooms, floors)
    if stops:
        plan = replace(plan, keyframes=(*range(9), *range(16, 25)))
    texts = [step.text for step in directions(lexis_map, plan)]
    assert f"take the lift {way} to floor 1" in texts and not any("take the stairs" in text for text in texts)


def test_the_arrival_is_the_last_direction_even_in_a_lift(rng):
    rooms = [("hall", range(9)), ("stairs", range(9, 16)), ("attic", range(16, 25))]
    corners = [(0, 0, 0), (4, 0, 0), (4, 0, 3), (8, 0, 3)]
    lexis_map, plan = walked(rng, corners, rooms, np.repeat([0, -1, 1], [9, 7, 9]))
    into_lift = replace(plan, goal=lexis_map.rooms[1], keyframes=(*range(9), 12))
    texts = [step.text for step in directions(lexis_map, into_lift)]
    assert texts[-1] == "arrive in stairs (between floors)" and any("up" in text for text in texts)


def test_a_level_stretch_that_was_taken_for_stairs_is_not_climbed(rng):
    rooms = [("hall", range(8)), ("stairs", range(8, 17))]
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0), (8, 0, 0.2)], rooms, np.repeat([0, -1], [8, 9]))
    assert not any("take the stairs" in step.text for step in directions(lexis_map, plan))


def test_a_plan_that_goes_nowhere_starts_and_arrives(rng):
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0)], [("hall", range(9))])
    still = replace(plan, keyframes=(3,), length_m=0.0)
    assert [step.text for step in directions(lexis_map, still)] == ["start in hall (floor 0)", "arrive in hall (floor 0)"]


def test_the_plan_as_data_holds_keyframes_and_directions(rng):
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0)], [("hall", range(8))])
    data = plan_summary(lexis_map, plan)
    assert (data["from"], data["to"], data["length_m"]) == ("hall", "hall", pytest.approx(4.0))
    assert [k["id"] for k in data["keyframes"]] == list(plan.keyframes)
    assert data["keyframes"][0]["room"] == "hall" and data["keyframes"][-1]["room"] is None
    assert data["keyframes"][-1]["position_m"] == pytest.approx([4.0, 0.0, 0.0])
    assert [step["text"] for step in data["directions"]] == ["start in hall (floor 0)", "arrive in hall (floor 0)"]


def test_a_plan_that_ends_at_keyframes_of_neighbours_still_starts_and_arrives_in_its_own_rooms(rng):
    """A small room may be recognised only from viewpoints in front of it; see `path_end`."""
    rooms = [("office", range(5, 12)), ("corridor", [*range(5), *range(12, 25)])]
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0), (8, 0, 0), (12, 0, 0)], rooms)
    plan = replace(plan, start=lexis_map.rooms[0], goal=lexis_map.rooms[1])
    told = [step.text for step in directions(lexis_map, plan)]
    assert told == [
        "start in office (floor 0)", "enter corridor (floor 0)", "arrive in corridor (floor 0)",
    ]  # fmt: skip


def test_a_goal_that_no_keyframe_of_the_path_belongs_to_is_entered_before_it_is_arrived_in(rng):
    rooms = [("office", range(8)), ("corridor", range(8, 24)), ("kitchen", [24])]
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0), (8, 0, 0), (12, 0, 0)], rooms)
    told = [step.text for step in directions(lexis_map, replace(plan, keyframes=plan.keyframes[:-1]))]
    assert told[-2:] == ["enter kitchen (floor 0)", "arrive in kitchen (floor 0)"]


def test_the_rooms_of_all_keyframes_are_collected_once_and_not_for_every_keyframe_of_the_plan(rng, monkeypatch):
    lexis_map, plan = walked(rng, [(0, 0, 0), (4, 0, 0)], [("kitchen", range(9))])
    room_of, reads = LexisMap.room_of.fget, []
    monkeypatch.setattr(LexisMap, "room_of", property(lambda lexis_map: reads.append(lexis_map) or room_of(lexis_map)))
    plan_summary(lexis_map, plan)
    assert len(reads) <= 2  # for the directions and for the keyframes


@pytest.mark.parametrize(("start", "goal", "enters"), [
    ("office 1", "office 2", "the end"),
    ("corridor", "office 2", "the end"),
    ("office 1", "corridor", "the beginning"),
    ("corridor", "corridor", None),
])  # fmt: skip
def test_a_path_within_one_room_enters_its_goal_where_it_leaves_that_room(rng, start, goal, enters):
    """Two offices beside a corridor may both be recognised from the corridor alone."""
    rooms = [("office", range(2)), ("corridor", range(2, 23)), ("office", range(23, 25))]
    lexis_map, whole = walked(rng, [(0, 0, 0), (4, 0, 0), (8, 0, 0), (8, 4, 0)], rooms)
    named = dict(zip(("office 1", "corridor", "office 2"), lexis_map.rooms, strict=True))
    within = replace(whole, start=named[start], goal=named[goal], keyframes=whole.keyframes[2:23])
    told = [step.text.removesuffix(" (floor 0)") for step in directions(lexis_map, within)]
    entered = [f"enter {goal}"]
    middle = {"the end": ["turn left", *entered], "the beginning": [*entered, "turn left"], None: ["turn left"]}[enters]
    assert told == [f"start in {start}", *middle, f"arrive in {goal}"]
