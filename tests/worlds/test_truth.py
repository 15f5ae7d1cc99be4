"""The truth about room membership, openings and connections, compared with the polygons and with walkable paths."""

import json

import numpy as np
import pytest
import shapely

from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.openings.openness import with_openness
from worlds.presets import sample_house
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.truth import ambiguity_at, boundary_lines, objects, room_at, room_graph, storey_of
from worlds.truth_json import truth_json
from worlds.walkable import Walkable


@pytest.fixture(scope="module", params=[("home", 1, 0.3), ("ori", 2, 0.6), ("uh2-apt", 0, 0.1)], ids=lambda p: p[0])
def house(request):
    preset, seed, target = request.param
    return build_house(with_openness(sample_house(preset, seed), target))


def two_rooms(kind, low, high):
    corners = [((x, 0.0), (x + 4.0, 0.0), (x + 4.0, 4.0), (x, 4.0)) for x in (0.0, 4.0)]
    rooms = tuple(RoomSpec(id=i, label="office", polygon_m=p) for i, p in zip("ab", corners, strict=True))
    gap = OpeningSpec(rooms=("a", "b"), kind=kind, start_m=(4.0, low), end_m=(4.0, high))
    return build_house(HouseSpec(storeys=(StoreySpec(rooms=rooms, openings=(gap,)),), clutter=0.0))


@pytest.mark.parametrize(
    ("kind", "width", "open_to_both"),
    [("open", 1.0, True), ("half wall", 1.0, True), ("counter", 1.0, True), ("cased", 1.3, True), ("arch", 1.2, True),
     ("cased", 1.1, False), ("arch", 1.1, False), ("door", 1.3, False)],
)  # fmt: skip
def test_both_labels_count_near_gaps_that_nothing_closes_and_only_there(kind, width, open_to_both):
    house = two_rooms(kind, 1.0, 1.0 + width)
    x, y = np.meshgrid(np.linspace(0.02, 7.98, 90), np.linspace(0.02, 3.98, 60))
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, 1.3)], axis=-1)
    near = (np.abs(points[:, 0] - 4.0) <= 0.75) & (points[:, 1] >= 1.0) & (points[:, 1] <= 1.0 + width)
    allowed = ambiguity_at(house, points)
    assert np.array_equal(allowed.all(axis=1), near & open_to_both)
    assert allowed[np.arange(len(points)), room_at(house, points)].all()


def test_boundary_lines_cover_every_rooms_outline(house):
    """Every outline is covered exactly once: the lengths add up, and the union is that of the outlines."""
    for level, storey in enumerate(house.spec.storeys):
        outlines = shapely.union_all([shapely.Polygon(room.polygon_m).exterior for room in storey.rooms])
        lines = [piece.line for piece in boundary_lines(house) if piece.storey == level]
        assert sum(line.length for line in lines) == pytest.approx(outlines.length)
        assert outlines.buffer(1e-6).contains(shapely.union_all(lines))


def test_passages_lie_between_their_two_rooms(house):
    for passage in room_graph(house).passages:
        around = np.array([[dx, dy, 1.0] for dx in (-0.1, 0.1) for dy in (-0.1, 0.1)]) + passage.point
        assert {house.rooms[i].id for i in room_at(house, around)} == set(passage.rooms)


def test_the_room_graph_joins_what_can_be_walked(house):
    """The graph is connected exactly as the unfurnished house is for a walker."""
    graph, walkable = room_graph(house), Walkable(build_house(house.spec.model_copy(update={"clutter": 0.0})))
    reached, new = set(), {graph.rooms[0]}
    while new:
        reached |= new
        new = {room for p in graph.passages if reached & set(p.rooms) for room in p.rooms} - reached
    assert reached == set(graph.rooms) == set(walkable.reachable_rooms())


def test_stairs_join_the_rooms_at_both_ends(house):
    for room in (room for room in house.rooms if room.label == STAIRS):
        storeys = {passage.storey for passage in room_graph(house).passages if room.id in passage.rooms}
        assert len(storeys) > 1 and min(storeys) == room.storey


def test_objects_lie_in_their_rooms(house):
    furniture = {piece.id for piece in house.furniture}
    seen = objects(house)
    assert len({thing.id for thing in seen}) == len(seen)
    inside = [thing for thing in seen if thing.id in furniture]
    centres = np.array([thing.centre for thing in inside])
    assert [house.rooms[i].id for i in room_at(house, centres)] == [thing.room for thing in inside]


def test_truth_json_is_json_and_complete(house):
    data = json.loads(json.dumps(truth_json(house), allow_nan=False))
    assert [room["id"] for room in data["rooms"]] == [room.id for room in house.rooms]
    assert shapely.Polygon(data["rooms"][0]["polygon_m"]).equals(house.rooms[0].polygon)
    assert len(data["objects"]) == len(objects(house)) and len(data["stairs"]) == len(house.stairs)
    assert {pair["openness"] > 0 for pair in data["openness"]["pairs"]} == {True, False}
    assert any(line["ambiguous"] for line in data["boundaries"])


def test_storey_is_the_highest_floor_below():
    assert storey_of(np.array([-0.1, 0.0, 1.2, 2.99, 3.0, 9.0]), [0.0, 3.0]).tolist() == [0, 0, 0, 0, 1, 1]


def test_a_foot_that_rounding_has_put_below_its_floor_is_on_it():
    assert storey_of(np.array([2.8999999999999995]), [0.0, 2.9]).tolist() == [1]
