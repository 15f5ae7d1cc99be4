"""Every drawn house is valid, and failures shrink to the minimal house that a person would have drawn."""

import json
import math

import pytest
from hypothesis import HealthCheck, Phase, find, given, settings
from hypothesis import strategies as st
from hypothesis.errors import InvalidArgument, Unsatisfiable

import worlds
import worlds.spec
from worlds.errors import WorldsError
from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.openings.openness import openness_of, with_openness
from worlds.spec import HouseSpec
from worlds.strategies import OPENING_KINDS, _opened, houses, open_plans, room_pairs
from worlds.validation import validate
from worlds.walls import boundaries

# beartype picks at random which items of a list it checks, including lists inside strategies.
pytestmark = pytest.mark.filterwarnings("ignore:Do not use the `random` module")

SHRINKING = settings(
    database=None,
    derandomize=True,
    max_examples=2000,
    deadline=None,
    phases=(Phase.generate, Phase.shrink),
    suppress_health_check=list(HealthCheck),
)


def inner_boundaries(spec):
    """(storey, boundary) for every boundary between two rooms."""
    return [(storey, line) for storey in spec.storeys for line in boundaries(storey) if None not in line.rooms]


def labels(spec):
    return sorted(room.label for storey in spec.storeys for room in storey.rooms)


def open_share(storey, line):
    """Share of the length of a boundary that is permanently open from floor to ceiling."""
    return sum(o.width_m for o in storey.openings if o.kind == "open" and set(o.rooms) == set(line.rooms)) / line.length


def sides(room):
    xs, ys = zip(*room.polygon_m, strict=True)
    return len(room.polygon_m), max(xs) - min(xs), max(ys) - min(ys)


@pytest.mark.parametrize(
    "strategy",
    [
        houses(max_storeys=3, doors=("no leaf", "open", "ajar", "closed")),
        houses(min_rooms=9, max_rooms=16, max_storeys=1, labels=("garden", "corridor", "balcony")),
        houses(min_rooms=20, max_rooms=30, max_storeys=4),
        open_plans(),
        room_pairs(),
    ],
    ids=["houses", "gardens", "many rooms", "open plans", "pairs"],
)
@settings(max_examples=25)
@given(data=st.data())
def test_every_drawn_house_stands_and_can_be_walked(strategy, data):
    spec = data.draw(strategy)
    assert spec.storeys[0].furniture == ()
    validate(build_house(spec))
    assert HouseSpec.from_json(spec.to_json()) == spec


@pytest.mark.parametrize(
    "strategy",
    [houses(furnished=True, max_rooms=5), open_plans(furnished=True, max_rooms=4), room_pairs(furnished=True)],
    ids=["houses", "open plans", "pairs"],
)
@settings(max_examples=10)
@given(data=st.data())
def test_furnished_houses_are_valid_too(strategy, data):
    house = build_house(data.draw(strategy))
    validate(house)
    assert house.furniture


@pytest.mark.parametrize(
    "strategy", [houses(), houses(openness=(0.4, 0.6)), houses(furnished=True), open_plans(), room_pairs()]
)
def test_the_printed_example_is_an_expression_with_public_names(strategy):
    """Where a call of `grow` is longer than the spec, Hypothesis prints the spec."""
    drawn = []

    @settings(SHRINKING, max_examples=20, phases=(Phase.generate,))
    @given(spec=strategy)
    def fails(spec):
        drawn.append(spec)
        assert len(drawn) < 5  # the first, simplest examples say little

    with pytest.raises(AssertionError) as caught:
        fails()
    (printed,) = (note for note in caught.value.__notes__ if "fails(" in note)
    text = printed.partition(":")[2].strip()
    of_spec = vars(worlds.spec) if "HouseSpec(" in text else {}
    names = of_spec | {name: getattr(worlds, name) for name in worlds.__all__} | {"fails": lambda spec: spec}
    assert eval(text, {"__builtins__": {}}, names) == drawn[-1]


@given(room_pairs(kinds=("half wall", "counter")))
def test_rooms_joined_by_a_half_wall_or_counter_also_have_a_door(spec):
    assert sum(len(storey.rooms) for storey in spec.storeys) == 2
    assert "door" in {opening.kind for opening in spec.storeys[0].openings}


@pytest.mark.parametrize("strategy", [houses, room_pairs])
@pytest.mark.parametrize(("kind", "door"), [("arch", "no leaf"), ("cased", "open"), ("door", "closed"), ("open", "ajar")])
def test_openings_are_of_the_kinds_and_doors_in_the_states_that_are_asked_for(strategy, kind, door):
    angles = {"no leaf": None, "open": math.pi / 2, "ajar": 0.5, "closed": 0.0}

    @settings(SHRINKING, max_examples=50)
    @given(strategy(kinds=(kind,), doors=(door,)))
    def are_as_asked(spec):
        inner = [o for storey in spec.storeys for o in storey.openings if o.leads is None]
        assert {opening.kind for opening in inner} <= {kind}
        # A leaf without room to swing is left out.
        assert {o.leaf.angle_rad for o in inner if o.leaf} <= {angles[door]}

    are_as_asked()


def test_a_pair_of_rooms_with_a_closed_door_has_a_closed_door():
    spec = find(room_pairs(kinds=("door",), doors=("closed",)), lambda spec: True, settings=SHRINKING)
    assert [opening.leaf.angle_rad for opening in spec.storeys[0].openings] == [0.0]


@given(st.data())
def test_open_plans_are_as_open_as_asked(data):
    least = data.draw(st.sampled_from([0.2, 0.5, 0.8, 1.0]))
    assert openness_of(data.draw(open_plans(min_openness=least))) >= least - 1e-9


@given(houses(openness=(0.4, 0.6)))
def test_houses_are_as_open_as_asked(spec):
    assert 0.35 <= openness_of(spec) <= 0.65


@pytest.mark.parametrize("strategy", [houses, open_plans])
def test_rooms_with_distinct_labels_shrink_to_a_pair_of_them(strategy):
    drawn = strategy(distinct_labels=True, labels=("kitchen", "bedroom", "office"), max_rooms=3)
    assert labels(find(drawn, lambda spec: True, settings=SHRINKING)) == ["bedroom", "kitchen"]

    @settings(SHRINKING, max_examples=100)
    @given(drawn)
    def all_differ(spec):
        rooms = [label for label in labels(spec) if label != STAIRS]
        assert len(set(rooms)) == len(rooms)

    all_differ()


def test_houses_whose_walls_are_too_short_for_the_openness_are_not_drawn():
    squares = [[0, 0], [3, 0], [3, 3], [0, 3]], [[3, 1.6], [6, 1.6], [6, 4.6], [3, 4.6]]
    rooms = [{"id": f"r{i}", "label": "office", "polygon_m": square} for i, square in enumerate(squares)]
    door = {"rooms": ["r0", "r1"], "kind": "door", "start_m": [3, 1.9], "end_m": [3, 2.7]}
    spec = HouseSpec.from_json(json.dumps({"storeys": [{"rooms": rooms, "openings": [door]}]}))
    with pytest.raises(WorldsError, match=r"too short for openness 0\.34"):
        with_openness(spec, 0.34)
    with pytest.raises(Unsatisfiable):
        find(_opened(st.just(spec), 0.34, 0.34), lambda _: True, settings=SHRINKING)


def test_an_open_boundary_shrinks_to_two_bare_squares():
    spec = find(
        houses(max_storeys=3),
        lambda spec: any(open_share(storey, line) >= 0.5 for storey, line in inner_boundaries(spec)),
        settings=SHRINKING,
    )
    (storey,) = spec.storeys
    assert labels(spec) == ["kitchen", "kitchen"]
    assert [sides(room) for room in storey.rooms] == [(4, 2.0, 2.0)] * 2
    assert [(o.kind, o.start_m, o.end_m, o.leaf) for o in storey.openings] == [("open", (2.0, 0.0), (2.0, 2.0), None)]
    assert storey.furniture == () and storey.windows is None


def test_a_kitchen_beside_a_bathroom_shrinks_to_these_two():
    def unhygienic(spec):
        label = {room.id: room.label for storey in spec.storeys for room in storey.rooms}
        return any({label[i] for i in line.rooms} == {"kitchen", "bathroom"} for _, line in inner_boundaries(spec))

    spec = find(houses(max_storeys=3, furnished=True), unhygienic, settings=SHRINKING)
    (storey,) = spec.storeys
    assert labels(spec) == ["bathroom", "kitchen"]
    assert [sides(room) for room in storey.rooms] == [(4, 2.0, 2.0)] * 2
    assert [(o.kind, o.width_m, o.leaf) for o in storey.openings] == [("door", pytest.approx(0.8), None)]


def test_a_second_storey_shrinks_to_a_room_on_each_and_stairs():
    spec = find(houses(max_storeys=4), lambda spec: len(spec.storeys) > 1, settings=SHRINKING)
    assert labels(spec) == ["kitchen", "kitchen", STAIRS, STAIRS]
    assert [len(storey.openings) for storey in spec.storeys] == [1, 1]
    assert [sides(storey.rooms[0]) for storey in spec.storeys] == [(4, 2.0, 2.0)] * 2


def test_the_number_of_rooms_shrinks_to_exactly_what_fails():
    spec = find(houses(max_rooms=12, max_storeys=1), lambda spec: len(labels(spec)) > 5, settings=SHRINKING)
    assert labels(spec) == ["kitchen"] * 6


@pytest.mark.parametrize(
    ("strategy", "arguments", "message"),
    [
        (houses, {"min_rooms": 0}, "min_rooms=0 is not a whole number in 1 ... 40"),
        (houses, {"min_rooms": 3, "max_rooms": 2}, "min_rooms=3 exceeds max_rooms=2"),
        (houses, {"max_rooms": True}, "max_rooms=True"),
        (houses, {"max_storeys": 9}, "max_storeys=9 is not a whole number in 1 ... 4"),
        (houses, {"labels": "kitchen"}, "labels='kitchen' is not a list"),
        (houses, {"labels": []}, "labels="),
        (houses, {"labels": ["stairs"]}, "labels has 'stairs'; valid: kitchen"),
        (houses, {"labels": ["garden"]}, "labels has 'garden', which bears no storey; valid with max_storeys=1 only"),
        (room_pairs, {"kinds": ["window"]}, f"kinds has 'window'; valid: {', '.join(OPENING_KINDS)}"),
        (room_pairs, {"doors": ["locked"]}, "doors has 'locked'; valid: no leaf, open, ajar, closed"),
        (houses, {"openness": (0.6, 0.2)}, "openness=(0.6, 0.2) is not a range within 0 ... 1"),
        (open_plans, {"min_openness": 1.5}, "min_openness=1.5 is not in 0 ... 1"),
        (open_plans, {"min_openness": math.nan}, "min_openness=nan"),
        (open_plans, {"min_rooms": 1}, "min_rooms=1 is not a whole number in 2 ... 40"),
        (
            houses,
            {"distinct_labels": True, "labels": ["kitchen", "bedroom"]},
            "max_rooms is 8; valid with distinct_labels: up",
        ),
        (open_plans, {"labels": ["kitchen", "garden"]}, "labels has 'garden'; valid: kitchen, "),
    ],
)
def test_bad_arguments_are_refused_at_once(strategy, arguments, message):
    with pytest.raises(InvalidArgument) as error:
        strategy(**arguments)
    assert message in str(error.value)
