"""Built houses: walls, stairs and openings agree with the room polygons; the truth agrees with the geometry."""

import numpy as np
import pytest
import shapely

from worlds.errors import HouseError
from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.presets import PRESETS, sample_house
from worlds.truth import NOWHERE, ambiguity_at, floor_at, openness, room_at
from worlds.validation import validate
from worlds.variant import explicit


@pytest.fixture(
    scope="module", params=[(preset, seed) for seed, preset in enumerate(PRESETS)], ids=lambda p: f"{p[0]}-{p[1]}"
)
def house(request):
    return build_house(sample_house(*request.param))


def test_every_preset_house_is_valid(house):
    validate(house)


def test_same_spec_same_house(house):
    again = build_house(house.spec)
    assert [(f.id, f.position, f.size, f.parts) for f in again.furniture] == [
        (f.id, f.position, f.size, f.parts) for f in house.furniture
    ]
    assert again.walls == house.walls
    for placed, before in ((again.leaves, house.leaves), (again.windows, house.windows)):
        assert [(o.id, o.position, o.yaw, o.size, o.parts) for o in placed] == [
            (o.id, o.position, o.yaw, o.size, o.parts) for o in before
        ]


def test_boundaries_have_the_length_of_the_room_perimeters(house):
    """A shared boundary belongs to two perimeters, an outer one to one."""
    for level, storey in enumerate(house.spec.storeys):
        perimeters = sum(shapely.Polygon(room.polygon_m).length for room in storey.rooms)
        sides = sum(b.length * sum(room is not None for room in b.rooms) for b, _ in house.boundaries[level])
        assert sides == pytest.approx(perimeters)


def test_boundary_sides_are_the_rooms_that_polygons_say(house):
    for level, pieces in enumerate(house.boundaries):
        for boundary, _ in pieces:
            middle = np.array(boundary.point((boundary.low + boundary.high) / 2))
            across = np.array([0.0, 1e-3]) if boundary.axis == 0 else np.array([1e-3, 0.0])
            for side, sign in ((0, -1), (1, 1)):
                height = house.storeys[level].floor_m + 1.0
                owner = room_at(house, np.array([[*(middle + sign * across), height]]))[0]
                expected = boundary.rooms[side]
                assert (owner == NOWHERE) if expected is None else house.rooms[owner] is house.room_by_id[expected]


def test_random_points_lie_in_at_most_one_room_and_on_its_floor(house):
    rng = np.random.default_rng(0)
    bounds = np.array([room.polygon.bounds for room in house.rooms])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    points = np.column_stack([rng.uniform(low, high, (400, 2)), rng.uniform(0.0, house.storeys[-1].ceiling_m, 400)])
    for point, owner, floor in zip(points, room_at(house, points), floor_at(house, points), strict=True):
        holding = [
            i for i, room in enumerate(house.rooms)
            if room.polygon.contains(shapely.Point(point)) and room.floor_m <= point[2] < room.ceiling_m + house.spec.slab_m
        ]  # fmt: skip
        assert holding == ([] if owner == NOWHERE else [owner])
        if owner != NOWHERE and house.rooms[owner].label != STAIRS:
            assert floor == house.rooms[owner].storey


def test_feet_are_in_the_room_they_stand_in_whatever_rounding_has_done_to_their_height(house):
    for i, room in enumerate(house.rooms):
        if room.label != STAIRS:
            place = room.polygon.representative_point()
            feet = np.array([[place.x, place.y, room.floor_m + off] for off in (-1e-9, -1e-15, 0.0, 1e-15, 1e-9)])
            assert set(room_at(house, feet)) == {i} and set(floor_at(house, feet)) == {room.storey}


def test_no_point_falls_between_two_rooms(house):
    for level, pieces in enumerate(house.boundaries):
        for boundary, _ in pieces:
            height = house.storeys[level].floor_m + 1.4
            points = np.array([[*boundary.point(a), height] for a in np.linspace(boundary.low, boundary.high, 5)])
            sides = {house.rooms.index(house.room_by_id[name]) for name in boundary.rooms if name is not None}
            assert set(room_at(house, points)[1:-1]) <= sides and NOWHERE not in room_at(house, points)


def test_ambiguity_contains_the_truth_and_only_opens_at_open_boundaries(house):
    points = np.array([[*room.polygon.representative_point().coords[0], room.floor_m + 1.4] for room in house.rooms])
    owner, allowed = room_at(house, points), ambiguity_at(house, points)
    assert allowed[np.arange(len(points)), owner].all()
    assert (ambiguity_at(house, points, band_m=0.0).sum(axis=1) == 1).all()


def test_stairs_climb_from_floor_to_floor_in_walkable_steps(house):
    for stairs in house.stairs:
        line = stairs.walking_line
        low, high = house.storeys[stairs.storey], house.storeys[stairs.storey + 1]
        assert line[0, 2] == low.floor_m and line[-1, 2] == high.floor_m
        tops = np.unique(np.round([part.centre[2] + part.size[2] / 2 for part in stairs.treads], 6))
        risers = np.diff([low.floor_m, *tops, high.floor_m])
        assert (risers > 0.1).all() and (risers < 0.2).all() and np.ptp(risers) < 1e-5


def test_openness_is_a_share(house):
    assert 0.0 <= openness(house) <= 1.0 + 1e-9


def test_a_given_piece_with_the_id_of_one_that_is_filled_in_elsewhere_is_refused():
    spec = sample_house("home", 0)
    below, *above = spec.storeys
    taken = explicit(spec).storeys[1].furniture[0].id
    piece = explicit(spec).storeys[0].furniture[0].model_copy(update={"id": taken})
    storeys = (below.model_copy(update={"furniture": (piece,)}), *above)
    with pytest.raises(HouseError, match=rf"filled in on other storeys: {taken}; valid: ids that are unique"):
        build_house(spec.model_copy(update={"storeys": storeys}))
