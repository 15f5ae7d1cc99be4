"""Impossible houses: each is refused with the room and the violated rule."""

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import Polygon

from worlds.checks.collisions import outlines_over, overlaps
from worlds.checks.plan_grid import NO_ROOM, PlanGrid
from worlds.checks.reachability import unreachable_rooms
from worlds.errors import HouseError
from worlds.free_space import Obstacles
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec
from worlds.validation import problems, validate
from worlds.walkable import Walkable


def two_rooms(**change):
    storey = {
        "rooms": [
            {"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [4, 0], [4, 3], [0, 3]]},
            {"id": "b", "label": "bedroom", "polygon_m": [[4, 0], [8, 0], [8, 3], [4, 3]]},
        ],
        "openings": [{"rooms": ["a", "b"], "kind": "door", "start_m": [4, 1], "end_m": [4, 1.9]}],
        "furniture": [],
        "windows": [],
    }
    return HouseSpec.from_json(json.dumps({"storeys": [storey | change]}))


def refusal(spec):
    with pytest.raises(HouseError) as error:
        validate(build_house(spec))
    assert "\n" not in str(error.value)
    return str(error.value)


def test_the_house_itself_stands():
    validate(build_house(two_rooms()))


def test_a_room_without_a_door_is_not_reachable():
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

    with pytest.raises(HouseError, match="not rectangular; valid: a rectangle"):
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


def piece(name, x, y, kind="office chair", room="b", z=0.0, yaw=0.0, size=(0.6, 0.5, 0.9)):
    position = [x, y, z]
    return {"id": name, "kind": kind, "room": room, "position_m": position, "yaw_rad": yaw, "size_m": size, "seed": 1}


def furnished(*pieces, **change):
    return two_rooms(furniture=list(pieces), **change)


def told(spec):
    return list(problems(build_house(spec)))


def test_pieces_that_touch_or_stand_on_each_other_are_fine():
    table, lamp = piece("table", 6, 1.5, "dining table", size=[1.6, 0.9, 0.75]), piece("lamp", 6, 1.5, "table lamp", z=0.75)
    beside = piece("chair", 6, 2.2, size=[0.5, 0.5, 0.9])
    rug = piece("rug", 6, 1.5, "rug", size=[2.0, 1.6, 0.02])
    assert told(furnished(table, lamp | {"size_m": [0.2, 0.2, 0.4]}, beside, rug)) == []


@pytest.mark.parametrize("yaw", [0.0, 0.6])
def test_pieces_that_run_into_each_other_are_both_named(yaw):
    one, other = piece("one", 6, 1.5), piece("other", 6.4, 1.6, yaw=yaw)
    assert told(furnished(one, other)) == [
        "furniture 'one' (office chair) and furniture 'other' (office chair) in 'b' run into each other"
    ]


@pytest.mark.parametrize(("apart", "meet"), [(0.21, False), (0.2, False), (0.19, True)])
def test_boxes_turned_alike_are_as_far_apart_as_they_are(apart, meet):
    """Their bounding boxes overlap in any case."""
    turned, off = {"yaw": np.pi / 4, "size": [1, 0.2, 1]}, apart / np.sqrt(2)
    found = told(furnished(piece("one", 5.5, 1.5, **turned), piece("other", 5.5 + off, 1.5 - off, **turned)))
    assert ["run into each other" in problem for problem in found] == [True] * meet


def test_furniture_in_a_wall_and_under_a_lintel():
    assert told(furnished(piece("p", 7.68, 1.5))) == [
        "furniture 'p' (office chair) in 'b' stands in the wall between 'b' and the outside"
    ]
    assert told(furnished(piece("p", 7.65, 1.5))) == []
    high = piece("p", 4.31, 1.45, "picture", z=2.02, size=[0.6, 0.6, 0.3])
    assert any("stands in the wall between 'a' and 'b'" in problem for problem in told(furnished(high)))


def test_furniture_of_one_room_in_another():
    openings = [{"rooms": ["a", "b"], "kind": "open", "start_m": [4, 0.5], "end_m": [4, 2.5]}]
    for x in (2.0, 4.1):
        assert told(furnished(piece("p", x, 1.5), openings=openings)) == [
            "furniture 'p' (office chair) sticks out of its room 'b'"
        ]


DOOR = {"rooms": ["a", "b"], "kind": "door", "start_m": [4, 1], "end_m": [4, 1.9]}


@pytest.mark.parametrize(("angle", "told_of"), [(1.57, 2), (0.0, 1), (0.3, 1)])
def test_furniture_in_the_swing_area_of_a_leaf_is_refused(angle, told_of):
    """Whatever its angle, a leaf has to be able to open to a right angle."""
    leaf = {"hinge": "start", "into": "b", "angle_rad": angle}
    found = told(furnished(piece("p", 4.6, 1.24, size=[0.5, 0.5, 0.5]), openings=[DOOR | {"leaf": leaf}]))
    assert len(found) == told_of
    assert "'p'" in found[-1] and "in the way of the door leaf of storeys[0].openings[0] (a - b)" in found[-1]
    assert told(furnished(piece("p", 5.3, 1.24), openings=[DOOR | {"leaf": leaf}])) == []
    other_side = leaf | {"into": "a"}
    assert told(furnished(piece("p", 4.6, 1.5, size=[0.5, 0.5, 0.5]), openings=[DOOR | {"leaf": other_side}])) == []


@pytest.mark.parametrize(
    ("kind", "z", "height", "is_in_the_way"),
    [("wall shelf", 1.4, 0.3, True), ("rug", 0.0, 0.02, False), ("shoes", 0.0, 0.12, False)],
)
def test_furniture_that_hangs_in_the_swing_area_is_refused(kind, z, height, is_in_the_way):
    """Shoes and rugs on the floor do not stop a leaf."""
    shut = DOOR | {"leaf": {"hinge": "start", "into": "b", "angle_rad": 0.0}}
    found = told(furnished(piece("p", 4.6, 1.24, kind, z=z, size=[0.5, 0.25, height]), openings=[shut]))
    assert ["is in the way of the door leaf" in problem for problem in found] == [True] * is_in_the_way


def test_leaves_that_hit_each_other_or_a_wall():
    second = {"rooms": ["a", "b"], "kind": "door", "start_m": [4, 2.0], "end_m": [4, 2.8]}
    facing = [
        DOOR | {"leaf": {"hinge": "end", "into": "b"}},
        second | {"leaf": {"hinge": "start", "into": "b", "angle_rad": 2}},
    ]
    assert any("as it stands is in the way of" in problem for problem in told(two_rooms(openings=facing)))
    in_corner = DOOR | {"start_m": [4, 0.06], "end_m": [4, 0.96], "leaf": {"hinge": "start", "into": "b", "angle_rad": 2.0}}
    assert any(problem.startswith("the wall between") for problem in told(two_rooms(openings=[in_corner])))


@pytest.mark.parametrize("angle", [0.0, 1.5])
def test_a_leaf_does_not_swing_through_stairs(angle):
    def house(into):
        cell = {"label": "stairs", "polygon_m": [[2, 0], [6, 0], [6, 3], [2, 3]]}
        room = {"label": "corridor", "polygon_m": [[0, 0], [2, 0], [2, 3], [0, 3]]}
        leaf = {"into": into, "angle_rad": angle}
        up = {"rooms": ["hall", "cell"], "kind": "door", "start_m": [2, 0.2], "end_m": [2, 1.3], "leaf": leaf}
        down = {"rooms": ["gallery", "top"], "kind": "open", "start_m": [2, 1.7], "end_m": [2, 2.8]}
        lower = {"rooms": [room | {"id": "hall"}, cell | {"id": "cell"}], "openings": [up]}
        upper = {"rooms": [room | {"id": "gallery"}, cell | {"id": "top"}], "openings": [down]}
        return HouseSpec.from_json(json.dumps({"storeys": [lower, upper], "clutter": 0}))

    assert told(house("hall")) == []
    assert told(house("cell")) == [
        "the stairs 'cell' are in the way of the door leaf of storeys[0].openings[0] (hall - cell)"
    ]


def test_a_closed_door_is_passable():
    shut = DOOR | {"leaf": {"into": "b", "angle_rad": 0.0}}
    assert told(two_rooms(openings=[shut])) == []


@pytest.mark.parametrize(
    ("kind", "sizes", "message"),
    [
        ("door", {"height_m": 1.8}, "1.80 m high"),
        ("arch", {"height_m": 2.9}, "2.90 m high"),
        ("counter", {"sill_m": 1.0, "height_m": 2.8}, "open from 1.00 to 2.80 m"),
        ("half wall", {"sill_m": 2.7}, "open from 2.70 to 2.60 m"),
        ("half wall", {"sill_m": 0.04}, "open from 0.04 to 2.60 m; valid: a part of 0.3 ... 2.60 m"),
        ("counter", {"sill_m": 0.2, "height_m": 2.0}, "open from 0.20 to 2.00 m; valid: a part of 0.3 ... 2.60 m"),
    ],
)
def test_openings_fit_under_the_ceiling(kind, sizes, message):
    odd = {"rooms": ["a", "b"], "kind": kind, "start_m": [4, 2.0], "end_m": [4, 2.9]} | sizes
    found = told(two_rooms(openings=[DOOR, odd]))
    assert len(found) == 1 and message in found[0] and "storeys[0].openings[1] (a - b)" in found[0]


def test_an_opening_is_between_two_rooms():
    inside = {"rooms": ["a", "a"], "kind": "open", "start_m": [2, 1], "end_m": [2, 2]}
    assert told(two_rooms(openings=[DOOR, inside])) == [
        "storeys[0].openings[1] (a - a): both rooms are 'a'; valid: two different rooms"
    ]


def test_only_openings_of_stairs_lead_up_or_down():
    assert told(two_rooms(openings=[DOOR | {"leads": "up"}])) == [
        """storeys[0].openings[0] (a - b): "leads" says 'up', but neither room is stairs; leave it out"""
    ]


def test_windows_stay_apart_and_under_the_ceiling():
    window = {"room": "b", "start_m": [8, 0.5], "end_m": [8, 1.5]}
    assert told(two_rooms(windows=[window])) == []
    assert told(two_rooms(windows=[window, window | {"start_m": [8, 1.2], "end_m": [8, 2.2]}])) == [
        "storeys[0]: window/0/0 and window/0/1 overlap; openings and windows may only touch"
    ]
    assert "up to the ceiling" in told(two_rooms(windows=[window | {"height_m": 2.8}]))[0]


def test_a_fence_has_no_windows():
    rooms = json.loads(two_rooms().to_json())["storeys"][0]["rooms"]
    window = {"room": "b", "start_m": [8, 0.5], "end_m": [8, 1.5]}
    (problem,) = told(two_rooms(rooms=[rooms[0], rooms[1] | {"label": "garden"}], windows=[window]))
    assert problem == "window/0/0 (b): is in a fence; valid: windows of indoor rooms"


def test_a_slot_in_one_room_is_told_as_such():
    slotted = [[0, 0], [4, 0], [4, 3], [2.2, 3], [2.2, 1], [2, 1], [2, 3], [0, 3]]
    rooms = json.loads(two_rooms().to_json())["storeys"][0]["rooms"]
    found = told(two_rooms(rooms=[rooms[0] | {"polygon_m": slotted}, rooms[1]]))
    assert any("room 'a' has a slot of 0.2 m near (2.00, 1.00) m" in problem for problem in found)


@pytest.mark.parametrize("gap", [1e-3, 0.05, 0.29])
def test_rooms_touch_or_are_well_apart(gap):
    rooms = [
        {"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [4, 0], [4, 3], [0, 3]]},
        {"id": "b", "label": "bedroom", "polygon_m": [[4, 0], [8, 0], [8, 3], [4, 3]]},
        {"id": "c", "label": "garden", "polygon_m": [[1, 3 + gap], [7, 3 + gap], [7, 6], [1, 6]]},
    ]
    found = told(two_rooms(rooms=rooms))
    assert len([p for p in found if f"leave a gap of {gap:.3g} m" in p and "'c'" in p]) == 2
    rooms[2]["polygon_m"] = [[1, 3.3], [7, 3.3], [7, 6], [1, 6]]
    assert not any("gap" in problem for problem in told(two_rooms(rooms=rooms)))


def test_rooms_stand_on_rooms():
    data = json.loads(sample_house("home", 1).to_json())
    assert told(HouseSpec.from_json(json.dumps(data))) == []
    x = max(x for storey in data["storeys"] for room in storey["rooms"] for x, _ in room["polygon_m"])
    annex = {"id": "annex", "label": "bedroom", "polygon_m": [[x, 0], [x + 3, 0], [x + 3, 3], [x, 3]]}
    data["storeys"][1]["rooms"].append(annex)
    assert any(
        "only 0 % of room 'annex' stand on indoor rooms" in problem
        for problem in told(HouseSpec.from_json(json.dumps(data)))
    )


def test_a_room_without_a_free_place_is_not_reached():
    cell = {"id": "cell", "label": "toilet", "polygon_m": [[0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5]]}
    assert ["not reachable on foot" in problem for problem in told(two_rooms(rooms=[cell], openings=[]))] == [True]


def test_problems_tells_all_and_validate_the_first():
    spec = furnished(piece("p", 7.7, 1.5), piece("q", 7.7, 1.6), openings=[])
    found = told(spec)
    assert [any(words in problem for problem in found) for words in ("'p'", "'q'", "run into", "not reachable")] == [
        True
    ] * 4
    assert refusal(spec) == found[0]


WARDROBE = {"kind": "wardrobe", "size": [0.6, 1.6, 2.0]}
BLOCKED = "(storeys[0].openings[0]); not reachable on foot (body radius 0.25 m): "


@pytest.mark.parametrize("width", [0.6, 1.0, 1.6])
def test_furniture_that_blocks_a_door_is_named_with_the_door(width):
    barrier = piece("barrier", 4.4, 1.45, "wardrobe", size=[0.6, width, 2.0])
    harmless = piece("other", 7.6, 1.45, **WARDROBE)
    (problem,) = told(furnished(harmless, barrier))
    assert problem == f"furniture 'barrier' (wardrobe) in 'b' blocks the door between 'a' and 'b' {BLOCKED}b; move it away"
    assert told(furnished(harmless)) == []


def test_no_more_pieces_are_named_than_have_to_move():
    row = [piece(name, 4.4, y, size=[0.6, 0.4, 0.8]) for name, y in (("low", 1.1), ("high", 1.8))]
    assert [problem.split("'")[1] for problem in told(furnished(*row))] in (["low"], ["high"])
    both_sides = piece("here", 3.6, 1.45, room="a", **WARDROBE), piece("there", 4.4, 1.45, **WARDROBE)
    found = told(furnished(*both_sides))
    assert [problem.split("'")[1] for problem in found] == ["here", "there"]
    assert all("blocks the door between 'a' and 'b'" in problem and BLOCKED in problem for problem in found)


def test_furniture_across_a_room_is_named_where_no_opening_is_near():
    rooms = [
        {"id": "a", "label": "kitchen", "polygon_m": [[0, 0], [2, 0], [2, 2], [0, 2]]},
        {"id": "b", "label": "corridor", "polygon_m": [[2, 0], [8, 0], [8, 2], [2, 2]]},
        {"id": "c", "label": "bedroom", "polygon_m": [[8, 0], [10, 0], [10, 2], [8, 2]]},
    ]
    doors = [DOOR | {"start_m": [2, 0.5], "end_m": [2, 1.4]}]
    doors.append({"rooms": ["b", "c"], "kind": "door", "start_m": [8, 0.5], "end_m": [8, 1.4]})
    (problem,) = told(furnished(piece("shelf", 5, 1, "bookshelf", size=[0.3, 1.8, 2.0]), rooms=rooms, openings=doors))
    assert problem.startswith("furniture 'shelf' (bookshelf) in 'b' blocks the path; not reachable")
    blocked = [piece("one", 2.4, 0.95, **WARDROBE), piece("two", 7.6, 0.95, **WARDROBE)]
    assert [(p.split("'")[1], p.split(": ")[1]) for p in told(furnished(*blocked, rooms=rooms, openings=doors))] == [
        ("one", "a; move it away"),
        ("two", "c; move it away"),
    ]


def test_furniture_is_not_to_blame_where_an_opening_is_missing():
    """The furniture makes the room that is larger without it the smaller one."""
    shelves = [piece(f"shelf {k}", 0.6 + 0.9 * k, 1.5, "bookshelf", size=[0.3, 2.2, 2.0]) for k in range(4)]
    (problem,) = (text for text in told(furnished(*shelves, openings=[])) if "not reachable" in text)
    assert problem.endswith("add an opening, stairs or free space") and "furniture" not in problem


def test_rooms_without_a_way_in_and_rooms_behind_furniture_are_told_apart():
    far = {"id": "c", "label": "gym", "polygon_m": [[4, 3], [8, 3], [8, 6], [4, 6]]}
    rooms = [*json.loads(two_rooms().to_json())["storeys"][0]["rooms"], far]
    behind, alone = told(furnished(piece("barrier", 4.4, 1.45, **WARDROBE), rooms=rooms))
    assert "'barrier'" in behind and behind.endswith(": b; move it away")
    assert alone.startswith("not reachable on foot (body radius 0.25 m): c; add an opening")


def test_reachability_agrees_with_the_walkable_graph():
    for preset, seed in (("home", 0), ("uh2-apt", 1), ("ori", 2)):
        house = build_house(sample_house(preset, seed))
        rng = np.random.default_rng(seed)
        for changed in (house, replace(house, stairs=()), replace(house, walls=tuple(rng.permutation(house.walls)[5:]))):
            shut_out = {room.id for room in changed.rooms} - set(Walkable(replace(changed, leaves=())).reachable_rooms())
            assert set(unreachable_rooms(changed, PlanGrid.of(changed.spec), 0.25)) == shut_out


boxes = st.tuples(*[st.floats(-1, 1)] * 2, *[st.floats(0.05, 1.5)] * 2, st.floats(-3.2, 3.2), st.just(0.0), st.just(1.0))


def outline(row):
    x, y, w, d, yaw, *_ = row
    corners = np.array([[-w, -d], [w, -d], [w, d], [-w, d]]) / 2
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    return corners @ turn + (x, y)


@given(a=boxes, b=boxes)
def test_overlaps_agree_with_polygons(a, b):
    one, other = Polygon(outline(a)), Polygon(outline(b))
    shrunk, grown = (bool(one.buffer(by, join_style="mitre").intersects(other)) for by in (-0.01, 0.01))
    found = len(overlaps(Obstacles.of([a]), Obstacles.of([b]), 1e-9)) == 1
    as_outline = len(outlines_over(outline(a)[None], np.array([[0.0, 1.0]]), Obstacles.of([b]), 1e-9)) == 1
    assert found == as_outline
    assert shrunk <= found <= grown
    above = Obstacles.of([(*b[:-2], 1.0, 2.0)])
    assert len(overlaps(Obstacles.of([a]), above, 1e-9)) == 0


def test_the_plan_grid_is_the_polygons():
    house = build_house(sample_house("home", 2))
    grid = PlanGrid.of(house.spec)
    for level, owner in enumerate(grid.owner):
        of_level = [k for k, its in enumerate(grid.level_of_room) if its == level]
        for k in of_level:
            assert grid.area[owner == k].sum() == pytest.approx(Polygon(grid.rooms[k].polygon_m).area)
        x, y = ((edges[1:] + edges[:-1]) / 2 for edges in (grid.x, grid.y))
        inside = [shapely.contains_xy(Polygon(grid.rooms[k].polygon_m), *np.meshgrid(x, y, indexing="ij")) for k in of_level]
        expected = np.where(np.any(inside, axis=0), np.array(of_level)[np.argmax(inside, axis=0)], NO_ROOM)
        np.testing.assert_array_equal(owner, expected)
