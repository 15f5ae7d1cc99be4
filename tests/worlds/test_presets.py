"""Presets: every seed gives a house of the kind that the preset's name promises, and the same house each time."""

import math
from collections import Counter

import pytest
from helpers.unchecked import untyped

from worlds.errors import WorldsError
from worlds.labels import STAIRS
from worlds.openings.openness import openness_of
from worlds.presets import PRESETS, sample_from_rooms, sample_house
from worlds.validation import built_and_checked

CIRCULATION = ("corridor", "entrance hall", STAIRS)


def labels(spec, level=None):
    storeys = spec.storeys if level is None else (spec.storeys[level],)
    return Counter(room.label for storey in storeys for room in storey.rooms)


def rooms(spec):
    """Rooms without corridors and halls; stairs are one room on the plan of every storey."""
    return sum(n for label, n in labels(spec).items() if label not in CIRCULATION)


@pytest.mark.parametrize("preset", PRESETS)
def test_many_seeds_all_lay_out_and_differ(preset):
    specs = [sample_house(preset, seed) for seed in range(40)]
    assert len({spec.to_json() for spec in specs}) == 40
    assert sample_house(preset, 17).to_json() == specs[17].to_json()


@pytest.mark.parametrize("seed", [74840, 156264, 352065, 690126, 795664])
def test_a_living_room_alone_takes_no_corridor_s_place(seed):
    spec = sample_house("random", seed)
    built_and_checked(spec)
    assert any(label in CIRCULATION for label in labels(spec)) and labels(spec)["living room"] == 1


def test_a_home_has_two_storeys_stairs_a_garden_and_open_living():
    for seed in range(40):
        spec = sample_house("home", seed)
        assert len(spec.storeys) == 2 and labels(spec)[STAIRS] == 2 and 7 <= rooms(spec) <= 9
        assert labels(spec, 0)["garden"] == 1
        kinds = {frozenset(i.split(" ")[0] for i in opening.rooms): opening.kind for opening in spec.storeys[0].openings}
        assert kinds[frozenset({"kitchen", "dining"})] == kinds[frozenset({"dining", "living"})] == "open"
        assert openness_of(spec) > 0.1


def test_the_other_datasets_of_the_paper():
    for seed in range(20):
        ori, flat, office = (sample_house(preset, seed) for preset in ("ori", "uh2-apt", "uh2-office"))
        assert len(ori.storeys) == 2 and labels(ori)["office"] >= 4 and labels(ori)["kitchen"] == 1
        assert rooms(ori) - labels(ori)["lobby"] == 7
        assert len(flat.storeys) == 3 and rooms(flat) == 4
        assert any(o.kind == "open" and {i[:6] for i in o.rooms} == {"living", "dining"} for o in flat.storeys[0].openings)
        assert len(office.storeys) == 1 and len(office.room_labels) == 4


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(("count", "storeys"), [(2, 1), (4, 4), (9, 3), (23, 2), (40, 1), (40, 4)])
def test_rooms_and_storeys_are_as_many_as_asked_for(preset, count, storeys):
    for seed in range(2):
        spec = sample_house(preset, seed, rooms=count, storeys=storeys)
        assert len(spec.storeys) == storeys
        spines = (labels(spec)["lobby"] > 0) * 2  # a lobby may be the hall as well as one of the requested rooms
        assert count <= rooms(spec) <= count + spines


@pytest.mark.parametrize("target", [0.0, 0.3, 0.8, 1.0])
def test_openness_asked_for_is_reached(target):
    assert openness_of(sample_house("home", 5, openness=target)) == pytest.approx(target, abs=0.05)


def test_clutter_is_passed_on():
    assert sample_house("ori", 1, clutter=0.0).clutter == 0.0
    assert sample_house("ori", 1, clutter=0.0).storeys == sample_house("ori", 1).storeys


@pytest.mark.parametrize(
    ("asked", "storeys"),
    [
        (("kitchen", "office", "office", "bathroom"), 1),
        (("lobby", "classroom", "toilet", "garden", "balcony"), 1),
        (("bedroom",), 1),
        (("living room", "bedroom", "bathroom", "balcony", "garage", "pantry"), 3),
        (("toilet",) * 40, 2),
    ],
)
def test_rooms_asked_for_are_there(asked, storeys):
    for seed in range(5):
        found = labels(sample_from_rooms(asked, seed, storeys=storeys))
        added = {STAIRS: storeys} if storeys > 1 else {}
        surplus = found - Counter(asked)
        assert not Counter(asked) - found
        assert set(surplus) <= {"corridor", "lobby", STAIRS} and {k: surplus[k] for k in added} == added


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (("kitchn",), "valid: kitchen"),
        ((), "0 rooms"),
        (("office",) * 41, "41 rooms"),
        (("stairs", "office"), "no room can be a 'stairs'"),
        (("garden",), "0 indoor rooms"),
        (("office", "garden", "garden"), "2 gardens"),
        (("office", "balcony", "balcony"), "2 balconies"),
    ],
)
def test_impossible_room_lists_are_refused(asked, message):
    with pytest.raises(WorldsError, match=message):
        sample_from_rooms(asked, 0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rooms": 1}, "1 rooms were asked for; valid: 2 to 40"),
        ({"rooms": 41}, "valid: 2 to 40"),
        ({"storeys": 0}, "valid: 1 to 4"),
        ({"storeys": 5}, "valid: 1 to 4"),
        ({"rooms": 2, "storeys": 3}, "cannot fill 3 storeys"),
        ({"openness": 1.5}, "openness"),
        ({"clutter": 5.0}, "clutter is 5.0"),
        ({"clutter": float("nan")}, "clutter is nan"),
    ],
)
def test_impossible_options_are_refused(options, message):
    with pytest.raises(WorldsError, match=message):
        sample_house("home", 0, **options)


@pytest.mark.parametrize("options", [{"seed": 1.5}, {"seed": "7"}, {"rooms": 4.5}, {"storeys": True}])
def test_numbers_that_are_not_whole_are_refused(options):
    (name,) = options
    with pytest.raises(WorldsError, match=rf"{name} is .*; valid: a whole number"):
        untyped(sample_house)(**{"preset": "home", "seed": 0} | options)


def test_an_unknown_preset_lists_the_known_ones():
    with pytest.raises(WorldsError, match="valid: home, ori"):
        sample_house("castle", 0)


@pytest.mark.parametrize("seed", [22395, 73632])
def test_a_garden_beside_a_balcony_is_wide_enough_to_walk_in(seed):
    """These houses had a garden without width, and one of 5 cm: their south side is too short for both."""
    built_and_checked(sample_house("random", seed, clutter=0.0))


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("room", ["toilet", "bathroom"])
def test_one_small_room_can_have_a_garden_and_a_balcony(room, seed):
    built_and_checked(sample_from_rooms([room, "garden", "balcony"], seed, clutter=0.0))


@pytest.mark.parametrize(("seed", "options"), [(20274, {}), (410, {"storeys": 3})])
def test_cars_are_parked_on_the_ground_storey_only(seed, options):
    _, *upper = sample_house("random", seed, **options).storeys
    assert upper and "garage" not in {room.label for storey in upper for room in storey.rooms}


@pytest.mark.parametrize("value", [True, math.nan, 5.0])
def test_clutter_that_is_no_number_is_refused(value):
    with pytest.raises(WorldsError, match=rf"^clutter is {value!r}; valid: 0 to 4"):
        untyped(sample_house)("home", 1, clutter=value)
