"""Openness: measured in two ways, reached to within 0.05 for every target, and nothing but openings changes."""

import itertools
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worlds.errors import WorldsError
from worlds.house import build_house
from worlds.openings.openness import openness_of, with_openness
from worlds.presets import PRESETS, sample_house
from worlds.spec import PASSABLE, HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.truth import boundary_openness, openness
from worlds.validation import validate

TARGETS = (0.0, 0.07, 0.25, 0.5, 0.72, 0.93, 1.0)
# Made in the tests: beartype checks randomly chosen items with the `random` module, which strategies must not touch.
presets, seeds = st.sampled_from(PRESETS), st.integers(0, 500)


def two_rooms(wall_m, *openings, labels=("kitchen", "living room")):
    corners = [((x, 0.0), (x + 4.0, 0.0), (x + 4.0, wall_m), (x, wall_m)) for x in (0.0, 4.0)]
    rooms = tuple(RoomSpec(id=i, label=label, polygon_m=p) for i, label, p in zip("ab", labels, corners, strict=True))
    return HouseSpec(storeys=(StoreySpec(height_m=2.5, rooms=rooms, openings=openings),), clutter=0.0)


def opening(kind, low, high, **more):
    return OpeningSpec(rooms=("a", "b"), kind=kind, start_m=(4.0, low), end_m=(4.0, high), **more)


@pytest.mark.parametrize(
    ("gap", "share"),
    [
        (opening("door", 1.0, 2.0), 0.0),
        (opening("cased", 1.0, 3.0, height_m=2.0), 2.0 * 2.0 / 10.0),
        (opening("half wall", 0.0, 4.0, sill_m=1.0), 0.6),
        (opening("counter", 1.0, 2.0, sill_m=1.0, height_m=2.0), 0.1),
        (opening("open", 0.0, 4.0), 1.0),
        # Half an ellipse, 2 m wide and 0.4 m high, above sides of 1.6 m.
        (opening("arch", 1.0, 3.0, height_m=2.0), (2.0 * 1.6 + 3.141592653589793 * 1.0 * 0.4 / 2) / 10.0),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)
def test_openness_is_the_share_of_the_wall_that_is_gap(gap, share):
    house = build_house(two_rooms(4.0, gap))
    assert openness(house) == pytest.approx(share) == pytest.approx(boundary_openness(house)["a", "b"])


@pytest.mark.parametrize(("preset", "seed"), [("home", 2), ("apartment", 10), ("random", 2)])
def test_no_house_and_no_boundary_is_more_than_open(preset, seed):
    """Rounding errors must not lift the openness above 1, as they did in these houses."""
    spec = sample_house(preset, seed, openness=1.0)
    assert max(openness_of(spec), openness(build_house(spec)), *boundary_openness(build_house(spec)).values()) <= 1.0


def test_outdoors_and_stairs_do_not_count():
    spec = sample_house("home", 3)
    house = build_house(spec)
    ids = {room.id for room in house.rooms if room.outdoor or room.label == "stairs"}
    assert ids and not any(ids & set(pair) for pair in boundary_openness(house))


@given(presets, seeds)
def test_two_ways_of_measuring_agree(preset, seed):
    spec = sample_house(preset, seed)
    assert openness_of(spec) == pytest.approx(openness(build_house(spec.model_copy(update={"clutter": 0.0}))), abs=1e-9)


@given(presets, seeds, st.sampled_from(TARGETS) | st.floats(0.0, 1.0))
def test_any_target_is_reached_and_only_openings_change(preset, seed, target):
    spec = sample_house(preset, seed)
    changed = with_openness(spec, target)
    assert HouseSpec.from_json(changed.to_json()) == changed
    assert openness_of(changed) == pytest.approx(target, abs=0.05)
    for before, after in zip(spec.storeys, changed.storeys, strict=True):
        assert before.model_copy(update={"openings": after.openings}) == after
        joined = [{frozenset(o.rooms) for o in s.openings if o.kind in PASSABLE} for s in (before, after)]
        assert joined[0] <= joined[1]
    assert with_openness(spec, target) == changed


@pytest.mark.parametrize(("preset", "target"), list(zip(PRESETS, itertools.cycle((0.0, 0.4, 1.0)), strict=False)))
def test_opened_and_closed_houses_are_valid(preset, target):
    changed = with_openness(sample_house(preset, 11), target)
    house = build_house(changed)
    validate(house)
    assert openness(house) == pytest.approx(target, abs=0.05)


@given(st.floats(1.5, 6.0).map(lambda v: round(v, 2)), st.floats(0.0, 1.0), st.integers(0, 20))
def test_even_one_short_wall_takes_any_target(wall, target, seed):
    spec = two_rooms(wall, opening("door", 0.15, 0.95))
    assert openness_of(with_openness(spec, target, seed)) == pytest.approx(target, abs=0.05)


def test_where_the_walls_are_too_short_for_it_the_nearest_is_named():
    with pytest.raises(WorldsError, match=r"too short for openness 0\.30; the nearest is 0\.\d\d"):
        with_openness(two_rooms(1.1, opening("door", 0.15, 0.95)), 0.3)


@pytest.mark.parametrize("start", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(2))
def test_kitchens_open_before_bedrooms_and_close_after_them(start, seed):
    spec = with_openness(sample_house("apartment", seed), start)
    labels = {room.id: room.label for storey in spec.storeys for room in storey.rooms}
    private = {"bathroom", "bedroom", "toilet", "children's room"}
    for target in (0.1, 0.2, 0.4):
        shares = boundary_openness(build_house(with_openness(spec, target)))
        living = [v for pair, v in shares.items() if {labels[i] for i in pair} <= {"kitchen", "dining room", "living room"}]
        others = [v for pair, v in shares.items() if private & {labels[i] for i in pair}]
        assert max(others, default=0.0) == 0.0 or min(living, default=1.0) > 0.99


def test_there_are_many_ways_to_be_half_open():
    kinds = {
        o.kind
        for seed in range(12)
        for storey in with_openness(sample_house("ori", seed), 0.3).storeys
        for o in storey.openings
        if o.leads is None
    }
    assert kinds == {"door", "cased", "arch", "half wall", "counter", "open"}


def test_a_house_that_is_as_open_as_asked_for_stays_the_same():
    spec = sample_house("uh2-apt", 2)
    assert with_openness(spec, openness_of(spec)) == spec


@pytest.mark.parametrize("target", [-0.1, 1.1, float("nan")])
def test_impossible_targets_are_refused(target):
    with pytest.raises(WorldsError, match="valid: 0 "):
        with_openness(two_rooms(4.0), target)


@pytest.mark.parametrize("seed", range(6))
def test_a_door_in_place_of_an_opening_between_corners_keeps_away_from_them(seed):
    """The only wall between the rooms is 0.95 m long, so that the door takes the place of the opening."""
    outlines = {
        "a": [[0, 0], [4, 0], [4, 3], [0, 3]],
        "b": [[4, 2.05], [8, 2.05], [8, 6], [3.5, 6], [3.5, 3], [4, 3]],
    }
    rooms = [{"id": name, "label": "office", "polygon_m": outline} for name, outline in outlines.items()]
    way = {"rooms": ["a", "b"], "kind": "open", "start_m": [4, 2.05], "end_m": [4, 3]}
    spec = HouseSpec.from_json(json.dumps({"storeys": [{"rooms": rooms, "openings": [way], "furniture": []}]}))
    validate(build_house(with_openness(spec, 0.0, seed)))
