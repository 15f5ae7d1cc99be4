"""Stairs of all kinds in small houses: walkable steps, exact heights, the same shape in every orientation of the cell."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString, Point, box

from sim.tours.tour import plan_tour
from worlds.errors import HouseError
from worlds.house import build_house
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.stairs.build import build_stairs
from worlds.stairs.cells import APPROACH_M, MIN_HEAD_ROOM_M
from worlds.stairs.flights import MAX_RISER_M, MIN_RUN_WIDTH_M, MIN_TREAD_M, cell_needed, fit_stairs
from worlds.truth import room_at
from worlds.walkable import Walkable

KINDS = ("straight", "L", "U")
HALL_M = 2.0


def house(kind, storeys=2, height=2.6, cell=None, ways=None):
    """Four halls around a stair cell, open to one another. The climb begins in the south."""
    length, width = cell or cell_needed(kind, height + 0.3, 0.25, 0.9)
    x0, y0, x1, y1 = HALL_M, HALL_M, round(HALL_M + width, 6), round(HALL_M + length, 6)
    far_x, far_y, middle = x1 + HALL_M, y1 + HALL_M, (x0 + x1) / 2
    rooms = {
        "south": ((0, 0), (x1, 0), (x1, y0), (0, y0)),
        "east": ((x1, 0), (far_x, 0), (far_x, y1), (x1, y1)),
        "north": ((x0, y1), (far_x, y1), (far_x, far_y), (x0, far_y)),
        "west": ((0, y0), (x0, y0), (x0, far_y), (0, far_y)),
        "stairs": ((x0, y0), (x1, y0), (x1, y1), (x0, y1)),
    }
    joins = [
        ("south", "east", (x1, 0), (x1, y0)), ("east", "north", (x1, y1), (far_x, y1)),
        ("north", "west", (x0, y1), (x0, far_y)), ("west", "south", (0, y0), (x0, y0)),
    ]  # fmt: skip
    front = {"straight": x1 - 0.05, "L": x0 + 0.95, "U": middle}[kind]
    ends = {
        "straight": ("north", "stairs", (x0 + 0.05, y1), (x1 - 0.05, y1)),
        "L": ("east", "stairs", (x1, y1 - 0.95), (x1, y1 - 0.05)),
        "U": ("south", "stairs", (middle, y0), (x1 - 0.05, y0)),
    }
    flights = {"up": ("south", "stairs", (x0 + 0.05, y0), (front, y0)), "down": ends[kind]} | (ways or {})

    def storey(level):
        openings = [(way, None) for way in joins]
        openings += [(flights["up"], "up")] * (level + 1 < storeys) + [(flights["down"], "down")] * (level > 0)
        return StoreySpec(
            height_m=height,
            rooms=tuple(
                RoomSpec(id=f"{name} {level}", label="stairs" if name == "stairs" else "corridor", polygon_m=polygon)
                for name, polygon in rooms.items()
            ),
            openings=tuple(
                OpeningSpec(rooms=(f"{a} {level}", f"{b} {level}"), kind="open", start_m=p, end_m=q, leads=leads)
                for (a, b, p, q), leads in openings
            ),
            furniture=(),
            windows=(),
        )

    return HouseSpec(storeys=tuple(storey(level) for level in range(storeys)))


def edited(spec, edit):
    data = json.loads(spec.to_json())
    edit(data["storeys"])
    return HouseSpec.from_json(json.dumps(data))


def floors(spec):
    return np.cumsum([0.0, *(storey.height_m + spec.slab_m for storey in spec.storeys[:-1])]).tolist()


def stairs_of(spec):
    return build_stairs(spec, floors(spec))


def footprint(part):
    (x, y, _), (w, d, _) = part.centre, part.size
    return box(x - w / 2, y - d / 2, x + w / 2, y + d / 2)


def top(part):
    return part.centre[2] + part.size[2] / 2


def height_on(line, xy):
    """Height of a polyline above a point of its plan."""
    for a, b in pairwise(line):
        step = b[:2] - a[:2]
        if np.linalg.norm(step) > 1e-9 and LineString([a[:2], b[:2]]).distance(Point(xy)) < 1e-6:
            return a[2] + (b[2] - a[2]) * float((xy - a[:2]) @ step) / float(step @ step)
    raise AssertionError(f"{xy} is not on the line")


@given(
    kind=st.sampled_from(KINDS),
    height=st.floats(2.1, 6.0),
    more=st.tuples(st.floats(0.0, 1.5), st.floats(0.0, 1.5)),
)
def test_a_cell_as_large_as_needed_has_walkable_stairs(kind, height, more):
    rise = height + 0.3
    width = cell_needed(kind, rise)[1] + more[1]
    clear = {"straight": width - 0.1, "U": width / 2 - 0.05, "L": MIN_RUN_WIDTH_M}[kind]
    length = cell_needed(kind, rise, width_m=clear)[0] + more[0]
    steps = fit_stairs(kind, length, width, rise, above_void=True)
    assert steps.is_walkable
    tops = [0.0, *(slab.top for slab in steps.treads), rise]
    risers = np.diff(tops)
    assert risers.max() <= MAX_RISER_M + 1e-9 and np.ptp(risers) < 1e-9 and risers.min() > 0.1
    for slab in (steps.foot, *steps.treads, steps.head):
        assert -1e-9 <= slab.u[0] <= slab.u[1] <= length + 1e-9 and -1e-9 <= slab.v[0] <= slab.v[1] <= width + 1e-9
    depths = [min(slab.u[1] - slab.u[0], slab.v[1] - slab.v[0]) for slab in steps.treads]
    assert min(depths) >= MIN_TREAD_M - 1e-9
    landings = [depth for depth in depths if depth > 0.3 + 1e-6]
    assert all(depth >= steps.width_m - 1e-6 for depth in landings)
    assert len(landings) == (kind != "straight" or rise > 3.7)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("short", [(0.03, 0.0), (0.0, 0.03)])
def test_a_cell_any_smaller_is_refused_with_what_it_needs(kind, short):
    length, width = cell_needed(kind, 2.9)
    with pytest.raises(HouseError, match=rf"stairs 'stairs 0'.*too small for {kind}.*at least {length:.2f} m along"):
        stairs_of(house(kind, cell=(length - short[0], width - short[1])))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("height", [2.3, 2.6, 3.4])
def test_the_walking_line_climbs_the_rise_over_every_treads_middle(kind, height):
    for stairs in stairs_of(house(kind, 3, height)):
        assert stairs.kind == kind
        line, low = stairs.walking_line, stairs.storey * (height + 0.3)
        assert line[0, 2] == pytest.approx(low, abs=1e-12) and line[-1, 2] == pytest.approx(low + height + 0.3, abs=1e-12)
        assert (np.diff(line[:, 2]) >= 0.0).all()
        plan = LineString(line[:, :2])
        for part in stairs.treads:
            if min(part.size[:2]) < 0.5:  # no landing
                middle = plan.intersection(footprint(part)).centroid
                assert height_on(line, np.array(middle.coords[0])) == pytest.approx(top(part))
        length, width = cell_needed(kind, height + 0.3, 0.25, 0.9)
        cell = box(HALL_M, HALL_M, HALL_M + width, HALL_M + length)
        assert plan.difference(cell).length == pytest.approx(2 * APPROACH_M)
        assert all(cell.buffer(1e-6).contains(footprint(part)) for part in stairs.parts)


@pytest.mark.parametrize("kind", KINDS)
def test_head_room_along_the_whole_line_of_a_stack(kind):
    stairs = stairs_of(house(kind, 4, 2.2))
    boxes = [(footprint(p), p.centre[2] - p.size[2] / 2) for flight in stairs for p in flight.treads + flight.floors]
    for flight in stairs:
        plan = LineString(flight.walking_line[:, :2])
        for s in np.arange(APPROACH_M, plan.length - APPROACH_M, 0.05):
            xy = np.array(plan.interpolate(s).coords[0])
            here = height_on(flight.walking_line, xy)
            above = [low - here for shape, low in boxes if shape.contains(Point(xy)) and low > here]
            assert min(above, default=np.inf) >= MIN_HEAD_ROOM_M - 0.1  # the line is up to half a riser below a tread's edge


def turned(spec, change):
    """The house with every point of its plan transformed; polygons stay counter-clockwise."""

    def edit(storeys):
        for storey in storeys:
            for opening in storey["openings"]:
                opening["start_m"], opening["end_m"] = change(*opening["start_m"]), change(*opening["end_m"])
            for room in storey["rooms"]:
                ring = [change(*corner) for corner in room["polygon_m"]]
                area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, ring[1:] + ring[:1], strict=True))
                room["polygon_m"] = ring if area > 0 else ring[::-1]

    return edited(spec, edit)


SYMMETRIES = {
    "quarter": lambda x, y: (-y, x),
    "half": lambda x, y: (-x, -y),
    "mirror": lambda x, y: (-x, y),
    "diagonal": lambda x, y: (y, x),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("change", SYMMETRIES.values(), ids=SYMMETRIES)
def test_a_turned_or_mirrored_house_has_the_same_stairs_turned_or_mirrored(kind, change):
    spec = house(kind, 3)
    for one, other in zip(stairs_of(spec), stairs_of(turned(spec, change)), strict=True):
        moved = np.array([(*change(x, y), z) for x, y, z in one.walking_line])
        np.testing.assert_allclose(other.walking_line, moved, atol=1e-9)
        for a, b in ((one.treads, other.treads), (one.railing, other.railing)):
            np.testing.assert_allclose([p.centre for p in b], [(*change(*p.centre[:2]), p.centre[2]) for p in a], atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_walks_through_all_storeys_and_a_tour_goes_up_and_down(kind):
    spec = house(kind, 3)
    built = build_house(spec)
    walkable = Walkable(built)
    assert set(walkable.reachable_rooms()) == {room.id for room in built.rooms}
    assert set(Walkable(replace(built, stairs=())).reachable_rooms()) < {room.id for room in built.rooms}
    motion = plan_tour(built, walkable, np.random.default_rng(0)).motion
    heights = motion.position(np.append(np.arange(0.0, motion.duration_s, 0.02), motion.duration_s))[:, 2]
    assert heights.min() == 0.0 and heights.max() == pytest.approx(floors(spec)[-1])
    assert heights[0] == heights[-1] == 0.0
    for flight in built.stairs:
        halfway = flight.walking_line[2:-2] if kind != "straight" else flight.walking_line.mean(axis=0, keepdims=True)
        assert {built.rooms[k].label for k in room_at(built, halfway)} == {"stairs"}


def test_open_sides_have_a_railing_and_walled_ones_none():
    for kind in KINDS:
        for flight in stairs_of(house(kind, 3)):
            assert bool(flight.railing) == (kind != "straight")
            rails = [footprint(part) for part in flight.railing]
            assert all(rail.distance(LineString(flight.walking_line[:, :2])) > 0.3 for rail in rails)


def without_leads(storeys):
    for storey in storeys:
        for opening in storey["openings"]:
            opening.pop("leads", None)


def test_a_middle_storey_has_to_say_which_opening_leads_where():
    assert [flight.kind for flight in stairs_of(edited(house("U"), without_leads))] == ["U"]
    with pytest.raises(HouseError, match=r'storeys\[1\]\.openings\[4\].*valid: "leads": "up" or "leads": "down"'):
        stairs_of(edited(house("U", 3), without_leads))


def test_every_flight_has_one_opening_at_either_end():
    with pytest.raises(HouseError, match=r"stairs 'stairs 0'.*no openings to the flight up from storeys\[0\]"):
        stairs_of(edited(house("L"), lambda storeys: storeys[0]["openings"].pop()))
    with pytest.raises(HouseError, match=r"'stairs 1' have 2 openings to the flight down from storeys\[1\]"):
        stairs_of(edited(house("L"), lambda storeys: storeys[1]["openings"].append(storeys[1]["openings"][-1])))
    with pytest.raises(HouseError, match=r"leads up, but stairs 'stairs 1' do not go up"):
        stairs_of(edited(house("L"), lambda storeys: storeys[1]["openings"][-1].update(leads="up")))


@pytest.mark.parametrize(
    ("kind", "ways", "message"),
    [
        ("U", {"up": ("south", "stairs", (2.05, 2.0), (2.5, 2.0))}, r"middle of the flight is at \(2\.50, 2\.00\) m"),
        ("U", {"down": ("south", "stairs", (2.05, 2.0), (2.9, 2.0))}, "half of the same side; valid: one in each half"),
        ("L", {"up": ("south", "stairs", (3.0, 2.0), (4.0, 2.0))}, r"middle of the flight is at"),
        ("straight", {"up": ("south", "stairs", (2.05, 1.9), (2.95, 1.9))}, "is in no side of the stairs"),
    ],
)
def test_an_opening_beside_its_flight_is_refused(kind, ways, message):
    with pytest.raises(HouseError, match=message):
        stairs_of(house(kind, ways=ways))


def test_a_flight_over_the_head_of_another_is_refused():
    """A straight flight that begins where the lower one ends would run through it."""

    def begin_at_the_far_end(storeys):
        south, north = storeys[1]["openings"][-2:]
        storeys[1]["openings"][-2:] = [{**north, "leads": "up"}, {**north, "leads": "down"}]
        above = {name.replace("1", "2") for name in south["rooms"]}
        storeys[2]["openings"][-1] = {**south, "rooms": sorted(above), "leads": "down"}

    with pytest.raises(HouseError, match=r"stairs 'stairs 1'.*from storeys\[1\] leaves -?\d\.\d+ m of head room"):
        stairs_of(edited(house("straight", 3), begin_at_the_far_end))


def test_a_low_door_to_the_stairs_is_refused():
    with pytest.raises(HouseError, match=r"1\.92 m high, too low to walk through; valid: at least 1\.95 m"):
        stairs_of(edited(house("U"), lambda storeys: storeys[0]["openings"][-1].update(kind="door", height_m=1.92)))


def test_what_an_opening_leaves_beside_the_flight_has_a_floor_and_a_rail():
    """Upstairs the whole front of the cell is open; the half above the first run of steps is a drop."""
    front = ("south", "stairs", (2.05, 2.0), (3.75, 2.0))
    wide, narrow = (stairs_of(house("U", ways=ways))[0] for ways in ({"down": front}, {}))
    more = set(wide.floors) - set(narrow.floors)
    assert [footprint(part).bounds for part in more] == [pytest.approx((2.05, 2.0, 2.95, 2.05))]
    assert len(wide.railing) > len(narrow.railing)


def with_west_sides_at(spec, sides_m):
    """The house with the western side of its cell moved from x = `HALL_M` to one x per storey."""

    def edit(storeys):
        for storey, side in zip(storeys, sides_m, strict=True):
            lines = [room["polygon_m"] for room in storey["rooms"]]
            lines += [[opening["start_m"], opening["end_m"]] for opening in storey["openings"]]
            for point in (point for line in lines for point in line if point[0] == HALL_M):
                point[0] = side

    return edited(spec, edit)


@pytest.mark.parametrize(
    ("sides_m", "staircases"),
    [
        ((2.0000004, 2.0000006), 1),  # less than a micrometre apart, but rounded to the micrometre they differ
        ((2.0000006, 2.0000015), 1),
        ((2.0000004, 2.0000015), 2),
        ((2.0, 2.0000008, 2.0000016), 1),  # each cell is compared with the one that it stands on
    ],
)
def test_rooms_and_flights_agree_on_which_cells_are_one_staircase(sides_m, staircases):
    built = build_house(with_west_sides_at(house("U", len(sides_m)), sides_m))
    cells = {built.room_by_id[f"stairs {level}"].id for level in range(len(sides_m))}
    assert len(cells) == sum(room.label == "stairs" for room in built.rooms) == staircases
    assert len(built.stairs) == len(sides_m) - staircases


def test_two_stairs_in_one_place_of_a_storey_overlap():
    def again(storeys):
        storeys[1]["rooms"].append({**storeys[1]["rooms"][-1], "id": "more stairs"})

    with pytest.raises(HouseError, match="rooms 'stairs 1' and 'more stairs' overlap"):
        build_house(edited(house("U"), again))
