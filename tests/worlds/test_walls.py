"""Walls: the parts of boundaries without openings, from corner to corner; arches are half ellipses."""

import itertools

import numpy as np
import pytest
import shapely
from helpers.opening_rooms import every_kind, opening

from worlds.arches import arch_rise, spandrel_area
from worlds.errors import HouseError
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import OpeningSpec
from worlds.walls import (
    FENCE_HEIGHT_M,
    WALL_THICKNESS_M,
    Boundary,
    arch_curve,
    opening_span,
    split_at_openings,
    wall_spans,
)


@pytest.fixture(scope="module", params=["every kind", "home"])
def house(request):
    return build_house(every_kind() if request.param == "every kind" else sample_house("home", 3))


@pytest.mark.parametrize("kind", ["door", "cased", "arch", "half wall", "counter", "open"])
@pytest.mark.parametrize("height", [2.4, 2.6, 3.2])
def test_a_gap_and_the_wall_round_it_are_as_high_as_the_storey(kind, height):
    low, high = opening(kind).gap_m(height)
    spans = wall_spans(opening(kind), height)
    assert sum(top - bottom for bottom, top in spans) + high - low == pytest.approx(height)
    assert all(top <= low + 1e-9 or bottom >= high - 1e-9 for bottom, top in spans)


def test_the_pieces_of_a_boundary_make_up_the_boundary(house):
    for level, storey in enumerate(house.spec.storeys):
        for whole in {(b.axis, b.at) for b, _ in house.boundaries[level]}:
            pieces = sorted((b.low, b.high) for b, _ in house.boundaries[level] if (b.axis, b.at) == whole)
            assert all(stop <= start + 1e-9 for (_, stop), (start, _) in itertools.pairwise(pieces))
        widths = sum(b.length for b, o in house.boundaries[level] if o is not None)
        assert widths == pytest.approx(sum(o.width_m for o in storey.openings))


def test_walls_leave_no_gap_at_corners_and_none_inside_a_room(house):
    """Under the ceiling every room is enclosed by a ring of wall, except for openings that reach up to there."""
    half = WALL_THICKNESS_M / 2
    for level, storey in enumerate(house.spec.storeys):
        heights = house.storeys[level]
        top = shapely.union_all([w.footprint for w in house.walls if w.storey == level and w.top_m == heights.ceiling_m])
        for room in (r for r in storey.rooms if not house.room_by_id[r.id].outdoor):
            polygon = shapely.Polygon(room.polygon_m)
            open_ends = [
                shapely.LineString([o.start_m, o.end_m]) for o in storey.openings if o.kind in ("open", "half wall")
            ]
            rim = polygon.buffer(half, join_style="mitre").difference(polygon.buffer(-half, join_style="mitre"))
            gaps = shapely.union_all([line.buffer(half + 1e-6, cap_style="flat") for line in open_ends])
            assert rim.difference(gaps).difference(top).area == pytest.approx(0.0, abs=1e-6)
            assert polygon.buffer(-half - 1e-6, join_style="mitre").intersection(top).area == 0.0


def test_an_arch_is_half_an_ellipse_over_upright_sides():
    arch = opening("arch", height_m=2.3)
    axis, at, low, high = opening_span(arch)
    curve = np.array(arch_curve(Boundary(axis, at, low, high, ("kitchen", "living room")), arch, 2.6))
    assert curve[[0, -1], 0].tolist() == [low, high]
    np.testing.assert_allclose(curve[[0, -1], 1], 2.3 - arch_rise(arch.width_m))
    assert curve[:, 1].max() == pytest.approx(2.3)
    x, z = (curve[:, 0] - (low + high) / 2) / (arch.width_m / 2), (curve[:, 1] - curve[0, 1]) / arch_rise(arch.width_m)
    np.testing.assert_allclose(x**2 + z**2, 1.0, atol=1e-9)
    lacking = arch.width_m * 2.3 - np.trapezoid(curve[:, 1], curve[:, 0])
    assert lacking == pytest.approx(spandrel_area(arch.width_m), abs=0.012 * arch.width_m * arch_rise(arch.width_m))


def test_strips_of_an_arch_reach_at_least_to_its_curve(house):
    for wall in (wall for wall in house.walls if wall.spandrel):
        arch = next(o for b, o in house.boundaries[wall.storey] if b is wall.boundary)
        curve = np.array(arch_curve(wall.boundary, arch, np.inf))
        assert wall.bottom_m <= np.interp([wall.low, wall.high], *curve.T).min() + 1e-9
        assert wall.top_m == pytest.approx(arch.height_m)


def test_fences_stand_where_all_is_outdoors(house):
    for wall in house.walls:
        outdoors = all(name is None or house.room_by_id[name].outdoor for name in wall.rooms)
        low = wall.top_m <= house.storeys[wall.storey].floor_m + FENCE_HEIGHT_M
        assert low == outdoors or wall.boundary in {b for b, o in house.boundaries[wall.storey] if o is not None}


def test_an_opening_in_two_pieces_of_boundary_is_in_both():
    wide = OpeningSpec(rooms=("a", "b"), kind="open", start_m=(0.5, 0.0), end_m=(3.0, 0.0))
    parts = [piece for low, high in ((0.0, 2.0), (2.0, 4.0)) for piece in split_at_openings(_stretch(low, high), [wide])]
    assert [(b.low, b.high, o is wide) for b, o in parts] == [
        (0.0, 0.5, False), (0.5, 2.0, True), (2.0, 3.0, True), (3.0, 4.0, False),
    ]  # fmt: skip


def _stretch(low, high):
    return Boundary(0, 0.0, low, high, ("a", "b"))


def test_an_opening_that_lies_askew_is_refused():
    askew = OpeningSpec(rooms=("a", "b"), kind="door", start_m=(0.0, 0.0), end_m=(1.0, 1.0))
    with pytest.raises(HouseError, match="not on one line along x or y"):
        opening_span(askew)
