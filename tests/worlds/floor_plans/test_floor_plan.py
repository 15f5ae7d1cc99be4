"""Layouts: rooms tile their storey, storeys stand on each other, and every room is connected to the others."""

import itertools

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import unary_union
from shapely.geometry import Polygon, box

from worlds.floor_plans.rectangles import SquareSymmetry, area_m2, contact, outline
from worlds.labels import OUTDOOR_LABELS, ROOM_LABELS, STAIRS
from worlds.presets import PRESETS, sample_house
from worlds.spec import PASSABLE

SEEDS = range(20)
CIRCULATION = ("corridor", "entrance hall", "lobby")
_MOST_M2 = {"toilet": 30.0, "pantry": 16.0, "bathroom": 40.0, "bedroom": 45.0, "office": 65.0, "living room": 80.0}
_LEAST_M2 = {"bedroom": 7.0, "living room": 13.0, "kitchen": 7.0, "classroom": 30.0, "open-plan office": 18.0}


@pytest.fixture(scope="module", params=PRESETS)
def houses(request):
    return [sample_house(request.param, seed) for seed in SEEDS]


def polygons(storey, indoors_only=True):
    return [Polygon(r.polygon_m) for r in storey.rooms if not (indoors_only and r.label in OUTDOOR_LABELS)]


def storeys(houses):
    return [storey for house in houses for storey in house.storeys]


def test_rooms_of_a_storey_tile_one_connected_polygon(houses):
    for storey in storeys(houses):
        everything = polygons(storey, indoors_only=False)
        assert all(p.is_valid and p.exterior.is_ccw for p in everything)
        assert unary_union(everything).area == pytest.approx(sum(p.area for p in everything), abs=1e-6)
        assert unary_union(polygons(storey)).geom_type == "Polygon"


def test_every_storey_stands_on_the_one_below(houses):
    for house in houses:
        for lower, upper in itertools.pairwise(house.storeys):
            ground = unary_union(polygons(lower)).buffer(1e-6)
            assert unary_union(polygons(upper)).difference(ground).area < 1e-3
            cells = [{Polygon(r.polygon_m).bounds for r in s.rooms if r.label == STAIRS} for s in (lower, upper)]
            assert cells[0] == cells[1] and len(cells[0]) == 1


def test_walls_lie_on_the_centimetre_grid(houses):
    corners = np.array([p for storey in storeys(houses) for room in storey.rooms for p in room.polygon_m])
    np.testing.assert_array_equal(corners, np.round(corners, 2))


def test_all_rooms_of_a_storey_are_joined(houses):
    for storey in storeys(houses):
        graph = nx.Graph([o.rooms for o in storey.openings if o.kind in PASSABLE])
        graph.add_nodes_from(room.id for room in storey.rooms)
        assert nx.is_connected(graph)


def test_rooms_are_of_sane_sizes(houses):
    for room in (room for storey in storeys(houses) for room in storey.rooms):
        polygon = Polygon(room.polygon_m)
        assert _LEAST_M2.get(room.label, 2.0) <= polygon.area <= _MOST_M2.get(room.label, 260.0), (room.label, polygon.area)
        sides = [np.hypot(*np.subtract(a, b)) for a, b in itertools.pairwise(polygon.exterior.coords)]
        assert min(sides) >= (0.3 if room.label in CIRCULATION else 0.99), (room.id, min(sides))
        if room.label in ("bedroom", "living room", "kitchen", "office", "children's room", "meeting room"):
            assert len(room.polygon_m) > 4 or max(sides) <= 3.0 * min(sides), room.id


def test_rooms_with_the_same_seed_are_translated_copies(houses):
    by_seed = {}
    for house in houses:
        for room in (room for storey in house.storeys for room in storey.rooms if room.seed is not None):
            by_seed.setdefault((house.name, room.seed), []).append(room)
    for twins in by_seed.values():
        assert len({room.label for room in twins}) == 1
        shapes = {tuple(np.round(np.subtract(room.polygon_m, np.min(room.polygon_m, axis=0)), 2).ravel()) for room in twins}
        assert len(shapes) == 1, [room.id for room in twins]


def test_every_label_and_every_shape_of_room_and_stairs_occurs():
    houses = [sample_house(preset, seed) for preset in PRESETS for seed in range(40)]
    rooms = [room for storey in storeys(houses) for room in storey.rooms]
    assert {room.label for room in rooms} == set(ROOM_LABELS)
    assert {len(room.polygon_m) for room in rooms if room.label not in ("corridor", "entrance hall", "lobby")} >= {4, 6, 8}
    assert {len(storey.rooms) > 20 for storey in storeys(houses)} == {True, False}


corners, sizes = st.tuples(st.integers(0, 8), st.integers(0, 8)), st.tuples(st.integers(1, 4), st.integers(1, 4))
rectangles = st.builds(lambda corner, size: (*corner, corner[0] + size[0], corner[1] + size[1]), corners, sizes)


@given(st.lists(rectangles, min_size=1, max_size=4), st.tuples(*[st.booleans()] * 3))
def test_outlines_and_contacts_agree_with_shapely(rects, flips):
    disjoint = [r for i, r in enumerate(rects) if all(box(*r).intersection(box(*other)).area == 0 for other in rects[:i])]
    turned = [SquareSymmetry(*flips).rect(r) for r in disjoint]
    assert area_m2(turned) == pytest.approx(sum(box(*r).area for r in disjoint) / 1e4)
    union = unary_union([box(*r) for r in turned])
    if union.geom_type == "Polygon" and not union.interiors:
        polygon = Polygon(outline(turned))
        assert polygon.equals(union) and polygon.exterior.is_ccw
        assert len(polygon.exterior.coords) == len(union.simplify(0.0).exterior.coords)
    for a, b in itertools.combinations(turned, 2):
        assert contact([a], [b]) == pytest.approx(box(*a).intersection(box(*b)).length)
