"""Lifts in generated houses: walkable, straight up, one door per storey; and tours that ride them."""

import numpy as np
import pytest
from shapely.geometry import Point

from sim.tours.tour import TourConfig, plan_tour
from worlds.errors import HouseError
from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.presets import sample_house
from worlds.spec import PASSABLE
from worlds.stairs.build import build_stairs
from worlds.stairs.cells import APPROACH_M
from worlds.stairs.shafts import MIN_SHAFT_M
from worlds.validation import validate
from worlds.variant import variant
from worlds.walkable import Walkable

HOUSES = [("home", 100), ("home", 104), ("ori", 100), ("uh2-apt", 100)]


def with_lifts(preset, seed):
    return variant(sample_house(preset, seed, clutter=0.2), climb="lift")


@pytest.fixture(scope="module", params=HOUSES, ids=str)
def house(request):
    return build_house(with_lifts(*request.param))


def changed(spec, level, change):
    """The house with the cells of stairs on a storey changed: new fields for the room, or None to leave its openings out."""
    storey = spec.storeys[level]
    cells = {room.id for room in storey.rooms if room.label == STAIRS}
    if change is None:
        update = {"openings": tuple(o for o in storey.openings if not cells & set(o.rooms))}
    else:
        update = {"rooms": tuple(r.model_copy(update=change) if r.id in cells else r for r in storey.rooms)}
    storeys = [*spec.storeys]
    storeys[level] = storey.model_copy(update=update)
    return spec.model_copy(update={"storeys": tuple(storeys)})


def test_a_house_with_lifts_is_valid_and_its_lifts_take_the_place_of_the_stairs(house):
    validate(house)
    assert house.stairs and all(flight.kind == "lift" and not flight.parts for flight in house.stairs)
    for storey in house.spec.storeys:
        for cell in (room for room in storey.rooms if room.label == STAIRS):
            assert sum(cell.id in opening.rooms and opening.kind in PASSABLE for opening in storey.openings) == 1


def test_a_lift_joins_the_floors_and_rises_straight_up_inside_its_shaft(house):
    for lift in house.stairs:
        line, shaft = lift.walking_line, house.room_by_id[lift.room].polygon
        low, high = house.storeys[lift.storey].floor_m, house.storeys[lift.storey + 1].floor_m
        assert (line[0, 2], line[-1, 2]) == (low, high) and set(line[:, 2]) == {low, high}
        rise = int(np.flatnonzero(np.diff(line[:, 2]))[0])
        assert (line[rise, :2] == line[rise + 1, :2]).all()
        assert (np.abs(np.diff(line[:, :2], axis=0)).min(axis=1) < 1e-9).all()  # through the doors at right angles
        for end in (line[0], line[-1]):
            assert shaft.distance(Point(end)) == pytest.approx(APPROACH_M)
        assert all(shaft.buffer(1e-6).contains(Point(point)) for point in line[1:-1])
        assert shaft.exterior.distance(Point(line[rise])) >= 0.3


def test_a_tour_of_all_rooms_rides_the_lifts_standing_and_turns_to_the_exit_meanwhile(house):
    tour = plan_tour(house, Walkable(house), np.random.default_rng(0), TourConfig(glance_rad=0.0))
    positions, yaw = tour.T_W_B[:, :3, 3], tour.motion.yaw(tour.stamps)
    steps = np.diff(positions, axis=0)
    riding = np.abs(steps[:, 2]) > 0.05
    assert np.abs(np.diff(positions[:, 2])).sum() == pytest.approx(2 * np.ptp(positions[:, 2]), rel=0.01)
    assert riding.any() and np.linalg.norm(steps[riding, :2], axis=1).max() < 0.02
    walking = (np.linalg.norm(steps[:, :2], axis=1) > 0.04) & (np.abs(steps[:, 2]) < 1e-6)
    ahead = np.arctan2(steps[walking, 1], steps[walking, 0])
    off = (yaw[:-1][walking] - ahead + np.pi) % (2 * np.pi) - np.pi
    shafts = [house.room_by_id[lift.room].polygon.buffer(0.3) for lift in house.stairs]
    near = np.array([any(shaft.contains(Point(point)) for shaft in shafts) for point in positions[:-1][walking]])
    assert np.abs(off[near]).max() < 1.0


def test_a_storey_more_is_reached_by_the_lift():
    house = build_house(variant(with_lifts("home", 100), add_storey=True))
    validate(house)
    assert [flight.kind for flight in house.stairs] == ["lift", "lift"] and len(house.storeys) == 3


def test_a_lift_is_refused_with_what_is_wrong():
    spec = with_lifts("home", 100)
    small = {"polygon_m": ((0.0, 0.0), (0.9, 0.0), (0.9, 2.0), (0.0, 2.0))}
    for wrong, message in [
        (changed(spec, 1, {"climb": "spiral"}), "has the climb 'lift'"),
        (
            changed(spec, 1, {"label": "storage room"}),
            "is labelled 'storage room' but has climb 'lift'; valid: climb only in rooms labelled 'stairs'",
        ),
        (changed(spec, 1, None), r"has 0 openings on storeys\[1\]; valid: one"),
        (changed(changed(spec, 0, small), 1, small), rf"is 0.90 x 2.00 m; valid: at least {MIN_SHAFT_M}"),
    ]:
        with pytest.raises(HouseError, match=message):
            build_stairs(wrong, [0.0, 2.9])
