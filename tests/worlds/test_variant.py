"""Variants of houses: one property differs and nothing else; symmetries form a group and commute with the truth."""

import json
import math

import numpy as np
import pytest
from helpers.unchecked import untyped
from hypothesis import given
from hypothesis import strategies as st

from worlds.errors import WorldsError
from worlds.floor_plans.symmetry import Symmetry, in_place
from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.presets import sample_house
from worlds.spec import MAX_STOREYS, HouseSpec
from worlds.truth import ambiguity_at, openness, room_at
from worlds.validation import validate
from worlds.variant import explicit, variant

PRESETS = ("home", "ori", "uh2-apt", "uh2-office")
OBLIQUE = st.floats(-math.pi, math.pi)


@pytest.fixture(scope="module", params=PRESETS)
def spec(request):
    return explicit(sample_house(request.param, 4))


def assert_same(a, b):
    """Assert that two houses are equal, except for the last digits of yaws."""
    assert bare(a) == bare(b)
    for x, y in zip(pieces(a), pieces(b), strict=True):
        assert math.remainder(x.yaw_rad - y.yaw_rad, 2 * math.pi) == pytest.approx(0.0, abs=1e-12)


def pieces(spec):
    return [piece for storey in spec.storeys for piece in storey.furniture]


def bare(spec):
    storeys = [
        storey.model_copy(update={"furniture": tuple(p.model_copy(update={"yaw_rad": 0.0}) for p in storey.furniture)})
        for storey in spec.storeys
    ]
    return spec.model_copy(update={"storeys": tuple(storeys)})


def test_mirrored_twice_or_turned_four_times_is_the_same_house(spec):
    assert_same(variant(variant(spec, mirror=True), mirror=True), spec)
    turned = spec
    for _ in range(4):
        turned = variant(turned, rotate=1)
    assert_same(turned, spec)
    assert_same(variant(spec, rotate=3), variant(variant(spec, rotate=2), rotate=1))


@pytest.mark.parametrize(("mirror", "turns"), [(True, 0), (False, 1), (True, 3)])
def test_truth_commutes_with_symmetry(spec, rng, mirror, turns):
    there = in_place(spec, mirror, turns)
    house, image = build_house(spec), build_house(variant(spec, mirror=mirror, rotate=turns))
    bounds = np.array([room.polygon.bounds for room in house.rooms])
    low, high = bounds[:, :2].min(axis=0) - 0.5, bounds[:, 2:].max(axis=0) + 0.5
    points = np.column_stack([rng.uniform(low, high, (600, 2)), rng.uniform(0.0, house.storeys[-1].ceiling_m, 600)])
    assert np.array_equal(room_at(image, there.points(points)), room_at(house, points))
    assert np.array_equal(ambiguity_at(image, there.points(points)), ambiguity_at(house, points))
    assert openness(image) == pytest.approx(openness(house))


@pytest.mark.parametrize(("mirror", "turns"), [(True, 0), (False, 1), (True, 2)])
def test_everything_solid_goes_where_the_symmetry_takes_it(spec, mirror, turns):
    there = in_place(spec, mirror, turns)
    house, image = build_house(spec), build_house(variant(spec, mirror=mirror, rotate=turns))
    validate(image)

    def outline(thing):
        points = np.array([(*corner, 0.0) for corner in thing.footprint.exterior.coords[:-1]])
        return {tuple(np.round(p, 6) + 0.0) for p in points}

    def moved(thing):
        points = np.array([(*corner, 0.0) for corner in thing.footprint.exterior.coords[:-1]])
        return {tuple(np.round(p, 6) + 0.0) for p in there.points(points)}

    for before, after in ((house.furniture, image.furniture), (house.leaves, image.leaves)):
        assert all(close(outline(b), moved(a)) for a, b in zip(before, after, strict=True))
    walls = sorted(tuple(sorted(moved(wall))) for wall in house.walls)
    assert np.allclose(walls, sorted(tuple(sorted(outline(wall))) for wall in image.walls), atol=1e-5)
    for a, b in zip(house.stairs, image.stairs, strict=True):
        assert np.allclose(there.points(a.walking_line), b.walking_line)


def close(a, b):
    return np.allclose(sorted(np.round(list(a), 4).tolist()), sorted(np.round(list(b), 4).tolist()), atol=2e-4)


@given(OBLIQUE, st.booleans(), st.integers(0, 3))
def test_fronts_go_where_the_symmetry_takes_them(yaw, mirror, turns):
    symmetry = Symmetry(mirror, turns)
    front = np.array([[-math.sin(yaw), math.cos(yaw), 0.0]])
    there = symmetry.yaw(yaw)
    assert -math.pi <= there <= math.pi
    assert np.allclose(symmetry.points(front), [[-math.sin(there), math.cos(there), 0.0]], atol=1e-9)


@pytest.mark.parametrize("preset", PRESETS)
def test_openness_leaves_polygons_windows_and_seeds_alone(preset):
    spec = sample_house(preset, 6)
    changed = variant(spec, openness=0.45)
    strip = [{**s.model_dump(), "storeys": [{**x.model_dump(), "openings": ()} for x in s.storeys]} for s in (spec, changed)]
    assert strip[0] == strip[1] and spec != changed
    windows = [[(w.room, w.start, w.end, w.size) for w in build_house(s).windows] for s in (spec, changed)]
    assert windows[0] == windows[1] and windows[0]


@pytest.mark.parametrize("preset", PRESETS)
def test_repainting_leaves_all_geometry_alone(preset):
    spec = sample_house(preset, 6)
    a, b = explicit(spec), explicit(variant(spec, repaint=7))
    assert a.storeys == b.storeys and a.appearance != b.appearance


@pytest.mark.parametrize("preset", PRESETS)
def test_more_clutter_keeps_the_existing_furniture(preset):
    spec = sample_house(preset, 6)
    few, many = (pieces(explicit(variant(spec, clutter=amount))) for amount in (0.6, 1.8))
    places = {(p.kind, p.position_m, p.size_m) for p in many}
    kept = sum((p.kind, p.position_m, p.size_m) in places for p in few)
    assert len(many) > len(few) and kept >= 0.9 * len(few)


@pytest.mark.parametrize("preset", ["home", "ori", "uh2-apt"])
def test_a_storey_more_leaves_those_below_as_they_are(preset):
    spec = sample_house(preset, 6)
    taller = variant(spec, add_storey=True)
    house = build_house(taller)
    validate(house)
    assert len(taller.storeys) == len(spec.storeys) + 1
    assert taller.storeys[: len(spec.storeys) - 1] == spec.storeys[:-1]
    assert taller.storeys[-2].rooms == spec.storeys[-1].rooms
    assert [r.polygon_m for r in taller.storeys[-1].rooms] == [r.polygon_m for r in spec.storeys[-1].rooms]
    assert sum(room.label == STAIRS for room in house.rooms) == sum(r.label == STAIRS for r in build_house(spec).rooms)
    validate(build_house(variant(taller, add_storey=True, mirror=True)))


@pytest.mark.parametrize("ending", ["", " 1.9", " 0.1", " 1." + 60 * "9", " " + 40 * "9" + ".1"])
def test_a_storey_more_has_valid_room_ids_however_long_the_old_ids_are(ending):
    spec = sample_house("home", 6)
    room = next(room for room in spec.storeys[-1].rooms if room.label != STAIRS)
    name = "r" * (64 - len(ending)) + ending
    longer = HouseSpec.model_validate_json(spec.model_dump_json(by_alias=True).replace(f'"{room.id}"', f'"{name}"'))
    for _ in range(4):
        longer = variant(longer, add_storey=True)
    assert len({room.id for storey in longer.storeys for room in storey.rooms}) == sum(len(s.rooms) for s in longer.storeys)


def two_storeys(**door):
    """Return a house whose openings do not say where they lead, as in the README."""
    cell = {"label": "stairs", "polygon_m": [[2, 0], [6, 0], [6, 3], [2, 3]]}
    room = {"label": "corridor", "polygon_m": [[0, 0], [2, 0], [2, 3], [0, 3]]}
    up = {"rooms": ["hall", "stairs 0"], "kind": "door", "start_m": [2, 0.2], "end_m": [2, 1.3]}
    down = {"rooms": ["gallery", "stairs 1"], "kind": "open", "start_m": [2, 1.7], "end_m": [2, 2.8]}
    lower = {"rooms": [room | {"id": "hall"}, cell | {"id": "stairs 0"}], "openings": [up | door]}
    upper = {"rooms": [room | {"id": "gallery"}, cell | {"id": "stairs 1"}], "openings": [down]}
    return HouseSpec.from_json(json.dumps({"storeys": [lower, upper], "clutter": 0}))


@pytest.mark.parametrize("door", [{}, {"leaf": {"into": "hall"}}, {"leads": "up"}])
def test_a_storey_more_on_a_house_by_hand(door):
    taller = variant(two_storeys(**door), add_storey=True)
    house = build_house(taller)
    validate(house)
    assert len(house.stairs) == 2 and taller.storeys[0] == two_storeys(**door).storeys[0]
    assert [opening.leads for opening in taller.storeys[1].openings] == ["down", "up"]
    validate(build_house(variant(taller, add_storey=True)))


def test_a_door_to_stairs_that_is_hung_anew_leads_where_it_led():
    """The leaf of the door down would stand in front of the opening to the flight up on the new storey."""
    data = json.loads(two_storeys().to_json())
    data["storeys"][1]["openings"][0] |= {"kind": "door", "leaf": {"into": "gallery", "angle_rad": 2.0}}
    taller = variant(HouseSpec.from_json(json.dumps(data)), add_storey=True)
    down, up = taller.storeys[1].openings
    assert (down.leads, up.leads) == ("down", "up") and down.leaf.angle_rad != 2.0
    validate(build_house(taller))


@pytest.mark.parametrize("field", ["furniture", "windows"])
def test_a_storey_more_on_a_bare_one_is_bare_and_else_filled_in(field):
    spec = sample_house("home", 6)
    bare_top = spec.storeys[-1].model_copy(update={field: ()})
    bare = spec.model_copy(update={"storeys": (*spec.storeys[:-1], bare_top)})
    for below, above in ((bare, ()), (spec, None), (explicit(spec), None)):
        assert getattr(variant(below, add_storey=True).storeys[-1], field) == above


def test_a_storey_more_may_be_too_much():
    squares = [[[x, y], [x + 2, y], [x + 2, y + 2], [x, y + 2]] for x in range(-16, 2, 2) for y in range(3, 27, 2)]
    rooms = [{"id": f"r{i}", "label": "office", "polygon_m": square} for i, square in enumerate(squares)]
    data = json.loads(two_storeys().to_json())
    for level in (0, 1):
        data["storeys"][level]["rooms"] += [room | {"id": f"{room['id']} {level}"} for room in rooms[:95]]
    with pytest.raises(WorldsError, match=r"the house with one more storey: .*at most 200"):
        variant(HouseSpec.from_json(json.dumps(data)), add_storey=True)


def test_what_cannot_be_varied_is_refused():
    spec = sample_house("uh2-office", 1)
    with pytest.raises(WorldsError, match="valid: houses of two storeys or more"):
        variant(spec, add_storey=True)
    tall = sample_house("home", 6)
    while len(tall.storeys) < MAX_STOREYS:
        tall = variant(tall, add_storey=True)
    with pytest.raises(WorldsError, match="the house has 8 storeys"):
        variant(tall, add_storey=True)
    for change in ({"clutter": -1.0}, {"repaint": -1}, {"openness": 2.0}):
        with pytest.raises(WorldsError, match="valid: 0 "):
            variant(spec, **change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"climb": "ladder"}, "climb is 'ladder'; valid: lift, spiral"),
        ({"climb": 3}, "climb is 3; valid: lift, spiral"),
        ({"repaint": 2.5}, "repaint is 2.5; valid: a whole number"),
        ({"rotate": 1.5}, "rotate is 1.5; valid: a whole number"),
        ({"rotate": True}, "rotate is True; valid: a whole number"),
    ],
)
def test_values_of_the_wrong_type_are_refused(change, message):
    with pytest.raises(WorldsError) as error:
        untyped(variant)(sample_house("home", 1), **change)
    assert str(error.value) == message


def test_a_variant_without_changes_is_the_same_house():
    spec = sample_house("home", 1)
    assert variant(spec) is spec


def test_a_copied_storey_with_a_pantry_behind_a_garage_can_be_walked():
    """The only door of a pantry may lead to a garage, which becomes a storage room upstairs."""
    data = json.loads(sample_house("home", 300, storeys=2, clutter=0.0).to_json())
    top = data["storeys"][-1]
    # The only door of this laundry room leads to the bedroom.
    inner, outer = "laundry room 1.1", "bedroom 1.1"
    for room in top["rooms"]:
        room["label"] = {inner: "pantry", outer: "garage"}.get(room["id"], room["label"])
    spec = HouseSpec.from_json(json.dumps(data))
    taller = variant(spec, add_storey=True)
    validate(build_house(taller))
    upstairs = {room.label for room in taller.storeys[-1].rooms}
    assert "garage" not in upstairs and {"storage room", "pantry"} <= upstairs


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"clutter": "2"}, "clutter is '2'; valid: 0 to 4"),
        ({"openness": True}, "openness is True; valid: 0 to 1"),
    ],
)
def test_a_property_of_another_type_is_refused(change, message):
    with pytest.raises(WorldsError, match=message):
        untyped(variant)(sample_house("home", 1, clutter=0.0), **change)


def test_a_variant_of_numpy_s_numbers_can_be_saved():
    spec = untyped(variant)(sample_house("home", 1, clutter=0.0), repaint=np.int64(5), clutter=np.float32(0.5))
    assert HouseSpec.from_json(spec.to_json()) == spec and (spec.appearance.seed, spec.clutter) == (5, 0.5)
