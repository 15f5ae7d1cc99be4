"""Spiral stairs in generated houses: walkable steps, head room, tours that climb them, and stairs for LEXIS."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from shapely.affinity import rotate
from shapely.geometry import Point, box

from lexis.config import LabelConfig
from lexis.floors import assign_floors
from lexis.stairs import lift_rides, on_stairs
from sim.tours.smooth import evenly
from sim.tours.tour import plan_tour
from worlds.errors import HouseError
from worlds.house import Furniture, build_house
from worlds.presets import sample_house
from worlds.stairs.build import build_stairs
from worlds.stairs.cells import MIN_HEAD_ROOM_M
from worlds.stairs.flights import MIN_TREAD_M
from worlds.stairs.spirals import MAX_RISER_M, MIN_FRONT_M, MIN_RADIUS_M, Spiral, least_cell
from worlds.validation import problems, validate
from worlds.variant import variant
from worlds.walkable import Walkable
from worlds.walls import HALF_WALL_M


@pytest.fixture(scope="module", params=[("home", 100), ("uh2-apt", 100)], ids=str)
def house(request):
    return build_house(variant(sample_house(*request.param, clutter=0.2), climb="spiral"))


def footprint(part):
    (x, y, _), (w, d, _) = part.centre, part.size
    return rotate(box(x - w / 2, y - d / 2, x + w / 2, y + d / 2), part.yaw, use_radians=True)


def steps_of(flight):
    return [part for part in flight.treads if part.shape == "box"]


def top(part):
    return part.centre[2] + part.size[2] / 2


def test_a_spiral_has_equal_steps_from_floor_to_floor_around_one_pole(house):
    validate(house)
    for flight in house.stairs:
        assert flight.kind == "spiral"
        low, high = house.storeys[flight.storey].floor_m, house.storeys[flight.storey + 1].floor_m
        risers = np.diff([low, *(top(step) for step in steps_of(flight)), high])
        assert np.ptp(risers) < 1e-9 and 0.1 < risers.max() <= MAX_RISER_M + 1e-9
        pole = np.array(flight.treads[-1].centre[:2])
        distances = [np.linalg.norm(np.array(step.centre[:2]) - pole) for step in steps_of(flight)]
        assert np.ptp(distances) < 1e-9
        shaft = house.room_by_id[flight.room].polygon
        assert all(shaft.buffer(0.03).contains(footprint(part)) for part in flight.parts)


def test_the_walking_line_passes_over_every_step_with_head_room(house):
    parts = [part for flight in house.stairs for part in (*flight.treads, *flight.floors) if part.shape == "box"]
    for flight in house.stairs:
        line, steps = flight.walking_line, steps_of(flight)
        assert (line[0, 2], line[-1, 2]) == tuple(house.storeys[flight.storey + k].floor_m for k in (0, 1))
        first = int(np.flatnonzero(line[:, 2] > line[0, 2])[0])
        on_steps = line[first : first + len(steps)]
        for point, step in zip(on_steps, steps, strict=True):
            assert footprint(step).contains(Point(point)) and point[2] == pytest.approx(top(step))
        assert min(math.dist(a, b) for a, b in zip(on_steps[:-1, :2], on_steps[1:, :2], strict=True)) > 0.95 * MIN_TREAD_M
        for x, y, z in line[first - 1 :]:
            above = [part for part in parts if top(part) > z + 0.5 and footprint(part).contains(Point(x, y))]
            assert min((part.centre[2] - part.size[2] / 2 - z for part in above), default=np.inf) >= MIN_HEAD_ROOM_M


@pytest.mark.parametrize("seed", [3, 7])
def test_nobody_walks_through_a_railing_of_a_spiral_in_three_storeys(seed):
    house = build_house(variant(sample_house("uh2-apt", seed, clutter=0.2), climb="spiral"))
    rails = [part for flight in house.stairs for part in flight.railing]
    assert len(house.stairs) == 2 and rails
    for flight in house.stairs:
        for x, y, z in evenly(flight.walking_line, 0.02):
            at_body = [rail for rail in rails if rail.centre[2] - rail.size[2] / 2 < z + 1.9 and top(rail) > z + 0.05]
            assert all(footprint(rail).distance(Point(x, y)) > 0.1 for rail in at_body)


def test_furniture_on_any_step_of_a_spiral_is_refused(house):
    flight = house.stairs[0]
    for step in steps_of(flight):
        tip = max(footprint(step).exterior.coords, key=lambda corner: math.dist(corner, flight.treads[-1].centre[:2]))
        x, y = np.average([tip, step.centre[:2]], axis=0, weights=[0.8, 0.2])
        size = (0.06, 0.06, 0.1)
        vase = Furniture("f", "vase", flight.room, flight.storey, (x, y, top(step) - 0.05), 0.0, size, solid=True)
        assert any("stands on the stairs" in each for each in problems(replace(house, furniture=(vase,))))


def test_stairs_hold_no_furniture(house):
    flight = house.stairs[0]
    x, y, z = flight.walking_line[len(flight.walking_line) // 2]
    for solid in (True, False):
        shelf = Furniture("f", "vase", flight.room, flight.storey, (x, y, z + 0.5), 0.0, (0.1, 0.1, 0.1), solid=solid)
        found = list(problems(replace(house, furniture=(shelf,))))
        assert any("stands in the stairs" in each for each in found) == solid


def test_lexis_takes_a_tour_up_and_down_a_spiral_for_stairs_between_floors(house):
    tour = plan_tour(house, Walkable(house), np.random.default_rng(0))
    at = np.interp(np.arange(0.0, tour.length_m, 0.5), tour.distances_m, np.arange(len(tour.stamps))).astype(int)
    positions = tour.T_W_B[at, :3, 3]
    floors = assign_floors(on_stairs(positions, LabelConfig()), positions)
    ground = positions[:, 2] - tour.eye_height_m
    for number, storey in enumerate(house.storeys):
        level = np.abs(ground - storey.floor_m) < 1e-6
        assert np.mean(floors[level] == number) > 0.95 and set(floors[level]) <= {-1, number}
    between = np.abs(ground[:, None] - [storey.floor_m for storey in house.storeys]).min(axis=1) > 0.5
    assert between.any() and (floors[between] == -1).all() and lift_rides(positions) == []


@pytest.mark.parametrize(("length", "width"), [(5.0, 5.0), (3.0, 4.0), (2.8, 2.6)])
def test_a_larger_cell_has_a_spiral_that_leaves_a_floor_before_the_doors(length, width):
    spiral = Spiral(length, width, 2.9)
    assert spiral.is_walkable and spiral.front_m + 1e-9 >= MIN_FRONT_M
    assert spiral.radius <= width / 2 - HALF_WALL_M and spiral.centre[0] + spiral.radius <= length - HALF_WALL_M + 1e-9


def test_a_spiral_is_refused_with_what_is_wrong():
    with pytest.raises(HouseError, match="openings are in different sides"):
        build_house(variant(sample_house("home", 101, clutter=0.0), climb="spiral"))
    spec = variant(sample_house("home", 100, clutter=0.0), climb="spiral")
    with pytest.raises(HouseError, match=r"leaves 1.90 m of head room; valid: a rise of at least 2.25 m"):
        build_stairs(spec, [0.0, 2.2])


@pytest.mark.parametrize("rise", [4.2, 4.5, 6.3])
def test_a_spiral_in_a_small_cell_is_refused_with_the_least_cell_for_its_rise(rise):
    spec = variant(sample_house("home", 100, clutter=0.0), climb="spiral")
    with pytest.raises(HouseError, match=rf"too small to rise {rise:.2f} m; valid: at least ") as refused:
        build_stairs(spec, [0.0, rise])
    length, width = map(float, re.findall(r"(\d\.\d\d) m (?:away|across)", str(refused.value)))
    assert Spiral(length, width, rise).is_walkable
    assert not Spiral(length - 0.01, width, rise).is_walkable and not Spiral(length, width - 0.01, rise).is_walkable


def test_the_least_cell_of_a_low_spiral_is_as_large_as_its_least_radius():
    assert least_cell(2.4) == (2 * MIN_RADIUS_M + HALF_WALL_M + MIN_FRONT_M, 2 * MIN_RADIUS_M + 2 * HALF_WALL_M)
