"""Steps of the reducer: every result is smaller, leaves alone what it does not remove, and can be written and read."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.errors import SimError
from sim.faults.delivery import Dropped
from sim.faults.poses import Kidnap
from sim.harness import Scenario
from sim.harness.run_settings import with_listed_house
from sim.harness.shrinking.house_edits import keep_furniture, keep_rooms
from sim.harness.shrinking.house_reductions import fewer_openings, fewer_rooms, fewer_storeys, less_furniture, without_parts
from sim.harness.shrinking.reductions import STEPS, for_images
from sim.harness.shrinking.scenario_difference import difference, relabelled_rooms
from sim.harness.shrinking.scenario_size import size
from sim.harness.shrinking.wall_reductions import narrower
from sim.harness.walk import shortest_walk_m, walk
from sim.render.rig import RigConfig
from worlds.house import build_house
from worlds.presets import sample_from_rooms, sample_house
from worlds.spec import HouseSpec
from worlds.strategies import houses
from worlds.validation import built_and_checked

RICH = Scenario(
    house=sample_house("home", 7),
    length_m=100.0,
    tour_kind="both ways",
    sway="hand-held",
    odometry="mono",
    overconfidence=4.0,
    faults=(Dropped(0.1), Dropped(0.2)),
    rig=RigConfig("stereo", lever_arm_m=(0.1, 0.0, 0.0)),
    fidelity="features",
)
LISTED = with_listed_house(RICH)
LONG = with_listed_house(Scenario(house=sample_from_rooms(("kitchen", "bedroom", "office"), seed=21), length_m=60.0))


@pytest.mark.parametrize("name", STEPS)
def test_every_candidate_is_smaller_and_can_be_saved(name):
    for candidate in list(STEPS[name](LISTED))[:12]:
        assert size(candidate) < size(LISTED)
        assert HouseSpec.from_json(candidate.house.to_json()).room_labels
        assert difference(LISTED, candidate) != "nothing"


def test_every_step_has_something_to_do_in_a_rich_scenario():
    idle = {name for name, step in STEPS.items() if not any(step(LISTED))}
    # This house has neither L-shaped rooms nor evening light, and all its rooms are furnished.
    assert idle <= {"rectangular rooms", "daylight", "simplest labels"}


@settings(max_examples=15)
@given(houses(max_rooms=6), st.sampled_from(sorted(STEPS)))
def test_steps_make_any_house_smaller(spec, name):
    scenario = with_listed_house(Scenario(house=spec, fidelity="features"))
    assert all(size(candidate) < size(scenario) for candidate in STEPS[name](scenario))


@pytest.mark.parametrize("step", [fewer_storeys, fewer_rooms, less_furniture, fewer_openings])
def test_what_remains_keeps_its_shape(step):
    rooms = {room.id: room for storey in LISTED.house.storeys for room in storey.rooms}
    pieces = {piece.id: piece for storey in LISTED.house.storeys for piece in storey.furniture}
    openings = {o.model_copy(update={"leads": None}) for storey in LISTED.house.storeys for o in storey.openings}
    for house in list(step(LISTED.house))[:10]:
        for storey in house.storeys:
            assert all(room == rooms[room.id] for room in storey.rooms)
            assert all(piece == pieces[piece.id] for piece in storey.furniture)
            assert {o.model_copy(update={"leads": None}) for o in storey.openings} <= openings


def test_parts_cover_everything_down_to_single_items():
    items = list(range(7))
    left = list(without_parts(items))
    assert left[0] == [] and left[-7:] == [[k for k in items if k != gone] for gone in items]
    assert list(without_parts([])) == [] and list(without_parts([1])) == [[]]


def test_all_rooms_kept_is_the_same_house():
    ids = {room.id for storey in LISTED.house.storeys for room in storey.rooms}
    assert keep_rooms(LISTED.house, ids) == LISTED.house
    assert keep_rooms(LISTED.house, set()) is None


def test_moving_walls_together_keeps_the_topology():
    moved = list(narrower(LISTED.house))
    assert moved
    for house in moved:
        for old, new in zip(LISTED.house.storeys, house.storeys, strict=True):
            assert [o.rooms for o in old.openings] == [o.rooms for o in new.openings]
            doors = [(a.width_m, b.width_m) for a, b in zip(old.openings, new.openings, strict=True) if a.kind != "open"]
            assert all(math.isclose(a, b, abs_tol=2e-3) for a, b in doors)


def test_a_listed_house_gives_the_same_walk():
    scenario = Scenario(house=sample_from_rooms(("kitchen", "bedroom"), seed=21), length_m=15.0, fidelity="features")
    listed = with_listed_house(scenario)
    assert (walk(scenario).tour.T_W_B == walk(listed).tour.T_W_B).all()
    assert with_listed_house(listed) == listed


def test_the_size_of_a_house_that_is_not_listed_is_not_known():
    with pytest.raises(SimError, match="does not list everything; valid: the result of with_listed_house"):
        size(RICH)


def test_a_staircase_is_one_room_on_all_its_storeys():
    assert len(LISTED.house.storeys) == 2
    assert size(LISTED).rooms == len(build_house(LISTED.house).rooms) < sum(len(s.rooms) for s in LISTED.house.storeys)


def test_differences_name_what_changed():
    assert difference(LISTED, LISTED) == "nothing"
    assert difference(LISTED, replace(LISTED, odometry="perfect")) == "odometry: mono -> perfect"
    room = LISTED.house.storeys[-1].rooms[0]
    ids = {r.id for storey in LISTED.house.storeys for r in storey.rooms} - {room.id}
    said = difference(LISTED, replace(LISTED, house=keep_rooms(LISTED.house, ids)))
    assert said.startswith(f"without {room.id!r}")


def test_faults_that_differ_in_a_setting_only_are_told_apart():
    early, late = (replace(LISTED, faults=(Kidnap(at_s=at_s, skip_s=8.0),)) for at_s in (10.0, 20.0))
    assert difference(early, late) == "faults: kidnap:at_s=10,skip_s=8 -> kidnap:at_s=20,skip_s=8"
    assert difference(early, replace(LISTED, faults=())) == "faults: kidnap:at_s=10,skip_s=8 -> none"


def test_a_rig_that_is_not_displaced_any_more_is_told():
    mounted = replace(LISTED, rig=replace(LISTED.rig, lever_arm_m=(0.0, 0.0, 0.0)))
    assert difference(LISTED, mounted) == "rig: stereo 480x360, displaced -> stereo 480x360"


def test_rooms_with_another_label_are_named_by_their_ids():
    assert relabelled_rooms(LISTED, LISTED) == ()
    empty = replace(LISTED, house=keep_furniture(LISTED.house, set()))
    last = list(STEPS["simplest labels"](empty))[-1]
    before, after = (
        {room.id: room.label for storey in each.house.storeys for room in storey.rooms} for each in (LISTED, last)
    )
    changed = [f"{key!r} has the label {label!r}" for key, label in after.items() if before[key] != label]
    assert list(relabelled_rooms(LISTED, last)) == changed != []


def test_with_images_the_steps_that_save_images_come_first():
    steps = for_images(STEPS)
    assert list(steps)[1:4] == ["fewer frames", "smaller rig", "shorten the tour"] and steps.keys() > STEPS.keys()
    least = next(steps["fewer frames and shortest tour"](LONG))
    assert size(least) < size(LONG) and least.length_m == math.ceil(shortest_walk_m(LONG)) < LONG.length_m
    walk(least)  # a tour of that length exists
    assert list(steps["drop rooms"](LONG)) == list(STEPS["drop rooms"](LONG))
    short, plain = next(steps["drop rooms"](least)), next(STEPS["drop rooms"](least))
    assert short == replace(plain, length_m=short.length_m) and short.length_m < plain.length_m
    assert short.length_m == max(4.0, math.ceil(shortest_walk_m(plain)))
    kept = {name: step for name, step in STEPS.items() if name != "shorten the tour"}
    assert next(for_images(kept)["drop rooms"](least)) == plain  # a step that is left out is not taken by others


def test_no_tour_is_requested_that_is_shorter_than_the_shortest():
    lengths = [candidate.length_m for candidate in STEPS["shorten the tour"](LONG)]
    assert lengths[0] == min(lengths) == math.ceil(shortest_walk_m(LONG)) and len(set(lengths)) == len(lengths) > 1


def test_two_storeys_shrink_at_once_to_a_staircase_and_what_carries_it():
    first = next(STEPS["drop rooms"](LISTED)).house
    built_and_checked(first)
    assert len(first.storeys) == 2 and sum(len(storey.rooms) for storey in first.storeys) <= 5
