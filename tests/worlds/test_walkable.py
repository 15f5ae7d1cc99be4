from dataclasses import replace
from functools import cache

import networkx as nx
import numpy as np
import pytest
import shapely
from scipy.sparse.csgraph import dijkstra
from shapely.geometry import LineString, Polygon

from worlds.errors import WorldsError
from worlds.house import Furniture, build_house
from worlds.presets import PRESETS, sample_house
from worlds.spec import HouseSpec, LeafSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.truth import room_at
from worlds.walkable import UnreachableError, Walkable, polyline_length

RADIUS = 0.25


def two_rooms(*openings: OpeningSpec):
    """An office and a kitchen, each 4 x 3 m, side by side."""
    rooms = tuple(
        RoomSpec(id=name, label=name, polygon_m=((x, 0.0), (x + 4.0, 0.0), (x + 4.0, 3.0), (x, 3.0)))
        for name, x in (("office", 0.0), ("kitchen", 4.0))
    )
    return build_house(HouseSpec(clutter=0.0, storeys=(StoreySpec(rooms=rooms, openings=openings, furniture=()),)))


DOOR = OpeningSpec(rooms=("office", "kitchen"), kind="door", start_m=(4.0, 0.4), end_m=(4.0, 1.3))


def block(x, y, yaw, size, bottom=0.0):
    return Furniture("block", "block", "office", 0, (x, y, bottom), yaw, size, True)


@cache
def furnished(preset, seed):
    return build_house(sample_house(preset, seed))


@pytest.fixture(scope="module", params=[("home", 3), ("uh2-apt", 2)], ids=lambda p: p[0])
def house(request):
    return furnished(*request.param)


@pytest.fixture(scope="module")
def walkable(house):
    return Walkable(house)


def obstacles_at(house, floor_m):
    """Footprints of everything between ankle and head height, computed independently from the house alone."""
    solids = [(w.footprint, w.bottom_m, w.top_m) for w in house.walls]
    objects = [*(piece for piece in house.furniture if piece.solid), *house.leaves]
    solids += [(o.footprint, o.position[2], o.position[2] + o.size[2]) for o in objects]
    return [shape for shape, low, high in solids if low < floor_m + 1.9 and high > floor_m + 0.05]


def stair_cells_at(house, floor_m):
    return [r.polygon for r in house.rooms if r.label == "stairs" and r.floor_m <= floor_m < r.ceiling_m]


def test_every_step_keeps_the_bodys_radius(house, walkable):
    graph, nodes = walkable.graph.tocoo(), walkable.nodes
    a, b = nodes[graph.row], nodes[graph.col]
    for storey in house.storeys:
        level = (a[:, 2] == storey.floor_m) & (b[:, 2] == storey.floor_m)
        steps = shapely.linestrings(np.stack([a[level, :2], b[level, :2]], axis=1))
        for shape in obstacles_at(house, storey.floor_m):
            shapely.prepare(shape)
            assert not shapely.dwithin(shape, steps, RADIUS - 1e-4).any()


def test_clearance_is_the_distance_to_what_is_there(house, walkable, rng):
    for storey in house.storeys:
        on_floor = np.flatnonzero((walkable.nodes[:, 2] == storey.floor_m) & (walkable.clearance > RADIUS))
        some = rng.choice(on_floor, 200, replace=False)
        shapes = shapely.union_all(obstacles_at(house, storey.floor_m) + stair_cells_at(house, storey.floor_m))
        distance = shapely.distance(shapes, shapely.points(walkable.nodes[some, :2]))
        np.testing.assert_allclose(walkable.clearance[some], np.minimum(distance, 1.0), atol=1e-9)


def test_turned_furniture_blocks_its_footprint_and_high_or_flat_pieces_do_not():
    empty = two_rooms(DOOR)
    piece = block(2.0, 1.5, 0.5, (1.2, 0.6, 0.8))
    turned = Walkable(replace(empty, furniture=(piece,)))
    distance = shapely.distance(piece.footprint, shapely.points(turned.nodes[:, :2]))
    assert distance.min() >= RADIUS
    assert distance.min() < RADIUS + 0.1
    for harmless in (replace(piece, position=(2.0, 1.5, 1.95)), replace(piece, size=(1.2, 0.6, 0.02))):
        np.testing.assert_array_equal(Walkable(replace(empty, furniture=(harmless,))).nodes, Walkable(empty).nodes)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("seed", [3, 6, 300])
def test_nobody_stands_inside_what_hangs_on_a_wall(preset, seed):
    """Pieces that hang at the height of a head are above others that block the way. Toys on the floor block nobody."""
    house = furnished(preset, seed)
    nodes = Walkable(house).nodes
    for piece in house.furniture:
        floor_m = house.storeys[piece.storey].floor_m
        if piece.position[2] < floor_m + 1.9 and piece.position[2] + piece.size[2] > floor_m + 0.7:
            here = nodes[np.abs(nodes[:, 2] - floor_m) < 0.3, :2]
            assert not shapely.contains_xy(piece.footprint, *here.T).any(), piece.kind


def test_nodes_are_in_the_room_they_name(house, walkable):
    owner = room_at(house, walkable.nodes)
    np.testing.assert_array_equal(walkable.node_room, owner)


def test_distance_is_a_metric_and_no_shorter_than_straight(walkable, rng):
    some = rng.choice(np.flatnonzero(walkable.connected), 12, replace=False)
    d = dijkstra(walkable.graph, indices=some)[:, some]
    np.testing.assert_allclose(d, d.T)
    assert (d[:, :, None] <= d[:, None, :] + d.T[None, :, :] + 1e-9).all()
    for a in some[:4]:
        for b in some[4:8]:
            p, q = walkable.nodes[a], walkable.nodes[b]
            length = walkable.distance(p, q)
            assert np.linalg.norm(p - q) - 1e-9 <= length <= walkable.distances_from(p)[b] + 1e-9
            assert length == pytest.approx(walkable.distance(q, p))


def test_path_is_walkable_from_end_to_end(house, walkable, rng):
    ends = walkable.nodes[rng.choice(np.flatnonzero(walkable.connected), 2, replace=False)]
    for prefer in (0.0, 0.6):
        path = walkable.path(*ends, prefer_clearance_m=prefer)
        np.testing.assert_array_equal(path[[0, -1]], ends)
        for storey in house.storeys:
            level = (path[:-1, 2] == storey.floor_m) & (path[1:, 2] == storey.floor_m)
            steps = shapely.linestrings(np.stack([path[:-1, :2], path[1:, :2]], axis=1)[level])
            for shape in obstacles_at(house, storey.floor_m):
                assert not shapely.dwithin(shape, steps, RADIUS - 1e-4).any()


def test_shortest_way_round_a_door_is_that_of_the_visibility_graph():
    house = replace(two_rooms(DOOR), furniture=(block(2.6, 1.4, 0.0, (0.8, 1.0, 0.7)),))
    start, goal = np.array([1.05, 2.55, 0.0]), np.array([5.55, 2.35, 0.0])
    solid = shapely.union_all([shape.buffer(RADIUS, quad_segs=16) for shape in obstacles_at(house, 0.0)])
    free = Polygon([(0, 0), (8, 0), (8, 3), (0, 3)]).difference(solid)
    corners = [start[:2], goal[:2], *shapely.get_coordinates(free)]
    sight = nx.Graph()
    tolerant = free.buffer(1e-6)
    for i, p in enumerate(corners):
        for j, q in enumerate(corners[:i]):
            if tolerant.covers(LineString([p, q])):
                sight.add_edge(i, j, weight=float(np.linalg.norm(np.subtract(p, q))))
    exact = nx.dijkstra_path_length(sight, 0, 1)
    for resolution in (0.1, 0.05):
        found = Walkable(house, RADIUS, resolution).distance(start, goal)
        assert exact - 2 * resolution <= found <= 1.03 * exact + resolution


@pytest.mark.parametrize("beside_the_wall_m", [0.35, 1.0])
def test_a_way_many_times_as_long_as_the_straight_line_is_found(beside_the_wall_m):
    walkable = Walkable(two_rooms(DOOR))
    start, goal = np.array([4.0 - beside_the_wall_m, 2.6, 0.0]), np.array([4.0 + beside_the_wall_m, 2.6, 0.0])
    for prefer, longer in ((0.0, 1.0), (0.6, 1.25)):
        path = walkable.path(start, goal, prefer)
        assert 3.0 < polyline_length(path) <= longer * walkable.distances_from(start)[walkable.snap(goal)] + 1e-9
        np.testing.assert_allclose(path[[0, -1]], [start, goal], atol=walkable.resolution_m)


def test_preferred_clearance_is_kept_where_there_is_room():
    house = replace(two_rooms(DOOR), furniture=(block(2.0, 1.2, 0.0, (0.6, 0.6, 0.7)),))
    walkable = Walkable(house)
    start, goal = np.array([0.6, 1.6, 0.0]), np.array([3.4, 1.6, 0.0])
    ways = [LineString(walkable.path(start, goal, prefer)[:, :2]) for prefer in (0.0, 0.6)]
    near, far = (way.distance(house.furniture[0].footprint) for way in ways)
    assert RADIUS <= near < 0.35
    assert far > 0.45


def test_stairs_join_the_storeys():
    house = furnished("home", 3)
    walkable = Walkable(house)
    assert set(walkable.reachable_rooms()) == {room.id for room in house.rooms}
    line = house.stairs[0].walking_line
    path = walkable.path(line[0], line[-1])
    assert polyline_length(path) == pytest.approx(polyline_length(line), rel=1e-6)
    assert (np.diff(path[:, 2]) >= 0.0).all()
    one, other = walkable.nodes_in(house.rooms[0].id)[0], walkable.nodes_in(house.rooms[-1].id)[0]
    points = walkable.nodes[one], walkable.nodes[other]
    assert np.array_equal(walkable.path(one, other), walkable.path(*points))
    assert np.array_equal(walkable.distances_from(one), walkable.distances_from(points[0]))
    without = Walkable(replace(house, stairs=()))
    with pytest.raises(UnreachableError, match="no path between"):
        without.path(without.nodes[0], without.nodes[-1])


def test_a_closed_door_and_a_door_for_thinner_bodies():
    narrow = OpeningSpec(rooms=("office", "kitchen"), kind="door", start_m=(4.0, 0.5), end_m=(4.0, 0.95))
    low = OpeningSpec(rooms=("office", "kitchen"), kind="door", start_m=(4.0, 0.5), end_m=(4.0, 1.5), height_m=1.7)
    assert len(Walkable(two_rooms(DOOR)).reachable_rooms()) == 2
    assert len(Walkable(two_rooms()).reachable_rooms()) == 1
    assert len(Walkable(two_rooms(low)).reachable_rooms()) == 1
    assert len(Walkable(two_rooms(narrow)).reachable_rooms()) == 1
    assert len(Walkable(two_rooms(narrow), radius_m=0.12).reachable_rooms()) == 2


@pytest.mark.parametrize(("angle", "rooms"), [(0.0, 1), (0.4, 1), (np.pi / 2, 2)])
def test_a_leaf_is_in_the_way_as_it_stands(angle, rooms):
    leaf = LeafSpec(hinge="start", into="kitchen", angle_rad=angle)
    house = two_rooms(DOOR.model_copy(update={"leaf": leaf}))
    walkable = Walkable(house)
    assert len(walkable.reachable_rooms()) == rooms
    distance = shapely.distance(house.leaves[0].footprint, shapely.points(walkable.nodes[:, :2]))
    assert distance.min() >= RADIUS


def test_a_house_without_a_free_place_has_no_reachable_room():
    cell = RoomSpec(id="cell", label="toilet", polygon_m=((0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)))
    walkable = Walkable(build_house(HouseSpec(storeys=(StoreySpec(rooms=(cell,), furniture=()),))))
    assert walkable.reachable_rooms() == ()
    with pytest.raises(UnreachableError, match="no free place"):
        walkable.snap(np.zeros(3))


def test_bad_arguments_name_what_is_valid():
    house = two_rooms(DOOR)
    with pytest.raises(WorldsError, match=r"radius_m is -1.*valid"):
        Walkable(house, radius_m=-1.0)
    with pytest.raises(WorldsError, match=r"resolution_m is 0.*valid"):
        Walkable(house, resolution_m=0.0)
    with pytest.raises(UnreachableError, match=r"no free place within 0.5 m of \(-2.00, 1.00, 0.00\)"):
        Walkable(house).snap(np.array([-2.0, 1.0, 0.0]))
    with pytest.raises(UnreachableError, match="valid: finite coordinates"):
        Walkable(house).snap(np.array([np.nan, 1.0, 0.0]))
    with pytest.raises(WorldsError, match=r"no room 'cellar'; valid: office, kitchen"):
        Walkable(house).nodes_in("cellar")
