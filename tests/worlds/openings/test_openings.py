"""Placement of openings: in the wall that two rooms share, clear of corners and of each other; leaves swing freely."""

import math
from collections import Counter
from functools import partial
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from worlds.errors import WorldsError
from worlds.house import build_house
from worlds.layout import Link, StoreyLayout
from worlds.openings.opening_draft import OpeningDraft, shared_walls
from worlds.openings.placement import APART_M, CORNER_M, place_openings
from worlds.spec import PASSABLE, HouseSpec, LeafSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.walkable import Walkable
from worlds.walls import WALL_THICKNESS_M, opening_span

KINDS = ("door", "cased", "arch", "half wall", "counter", "open")


def room(name, *corners, label="office"):
    return RoomSpec(id=name, label=label, polygon_m=corners)


def rectangle(name, x0, y0, x1, y1, label="office"):
    return room(name, (x0, y0), (x1, y0), (x1, y1), (x0, y1), label=label)


def ell_layout(kinds, corridor_m=1.8):
    """A corridor with an L-shaped room around one of its ends and two rooms on its other side."""
    w, d = 8.0, 4.0
    c, top = corridor_m, corridor_m + d
    rooms = (
        rectangle("corridor", 0.0, 0.0, w, c, label="corridor"),
        room("ell", (0.0, c), (w, c), (w, 0.0), (w + 3, 0.0), (w + 3, top), (0.0, top)),
        rectangle("a", 0.0, -d, 3.5, 0.0),
        rectangle("b", 3.5, -d, w, 0.0),
    )
    pairs = (("corridor", "ell"), ("a", "corridor"), ("corridor", "b"), ("a", "b"))
    return StoreyLayout(rooms, tuple(Link(pair, kind) for pair, kind in zip(pairs, kinds, strict=True)))


def hub_layout(kinds, size_m=2.3):
    """A small office between four corridors, whose doors would all preferably swing into the office."""
    s = size_m
    around = [("w", -2.0, 0.0, 0.0, s), ("e", s, 0.0, s + 2, s), ("s", 0.0, -2.0, s, 0.0), ("n", 0.0, s, s, s + 2)]
    rooms = (rectangle("hub", 0.0, 0.0, s, s), *(rectangle(*side, label="corridor") for side in around))
    return StoreyLayout(rooms, tuple(Link(("hub", side[0]), kind) for side, kind in zip(around, kinds, strict=True)))


kinds = st.tuples(*[st.sampled_from(KINDS)] * 4)
# Made in the test: beartype checks randomly chosen items with the `random` module, which strategies must not touch.
layouts = st.builds(partial, st.just(hub_layout), kinds) | st.builds(
    partial, st.just(ell_layout), kinds, st.sampled_from((1.3, 1.8, 2.4))
)
seeds = st.integers(0, 2**32)


@given(layouts, seeds)
def test_openings_lie_in_the_shared_wall_clear_of_corners_and_each_other(make_layout, seed):
    layout = make_layout()
    rooms = {r.id: r for r in layout.rooms}
    spans = []
    for opening in place_openings(layout, np.random.default_rng(seed)):
        axis, at, low, high = opening_span(opening)
        margin = 0.0 if opening.kind == "open" else CORNER_M
        walls = shared_walls(*(rooms[name] for name in opening.rooms))
        (wall,) = (w for w in walls if (w.axis, w.at) == (axis, at))
        assert wall.low + margin - 1e-9 <= low < high <= wall.high - margin + 1e-9
        assert all(abs(v * 100 - round(v * 100)) < 1e-6 for v in (low, high)), "off the centimetre grid"
        assert opening.kind not in PASSABLE or high - low >= 0.7 - 1e-9
        spans.append((axis, at, low, high, opening.kind == "open"))
    for (*line, low, high, a_open), (*other, start, stop, b_open) in combinations(spans, 2):
        apart = 0.0 if a_open and b_open else APART_M  # where no wall is left between them, openings touch
        assert line != other or max(low, start) - min(high, stop) >= apart - 1e-9


@given(layouts, seeds)
def test_every_link_can_be_walked_through(make_layout, seed):
    layout = make_layout()
    openings = place_openings(layout, np.random.default_rng(seed))
    passable = {frozenset(opening.rooms) for opening in openings if opening.kind in PASSABLE}
    assert passable == {frozenset(link.rooms) for link in layout.links}
    assert {o.kind for o in openings} <= {link.kind for link in layout.links} | {"door", "cased"}


@given(layouts, seeds)
def test_leaves_swing_freely_and_stand_wide_open(make_layout, seed):
    """The swing area of a leaf, constructed independently, meets no wall and no swing area of another leaf."""
    layout = make_layout()
    rooms = {r.id: r for r in layout.rooms}
    sectors = []
    for opening in place_openings(layout, np.random.default_rng(seed)):
        if opening.leaf is None:
            continue
        assert math.radians(60.0) <= opening.leaf.angle_rad <= math.radians(110.0)
        sector = swept(opening, rooms)
        inside = shapely.Polygon(rooms[opening.leaf.into].polygon_m).buffer(-WALL_THICKNESS_M / 2, join_style="mitre")
        hinge = shapely.Point(opening.start_m if opening.leaf.hinge == "start" else opening.end_m)
        # Next to the hinge the leaf is still inside its own wall.
        own_wall = shapely.LineString([opening.start_m, opening.end_m]).buffer(0.06, cap_style="square")
        assert sector.difference(inside).difference(own_wall).area < 1e-6
        assert own_wall.contains(hinge)
        sectors.append(sector)
    assert all(a.intersection(b).area < 1e-9 for a, b in combinations(sectors, 2))


def swept(opening, rooms):
    start, end = np.array(opening.start_m), np.array(opening.end_m)
    hinge, free = (start, end) if opening.leaf.hinge == "start" else (end, start)
    centre = (start + end) / 2
    normal = np.array([-(end - start)[1], (end - start)[0]]) / opening.width_m
    polygon = shapely.Polygon(rooms[opening.leaf.into].polygon_m)
    if not polygon.contains(shapely.Point(centre + 0.01 * normal)):
        normal = -normal
    along = free - hinge
    turns = np.linspace(0.0, max(opening.leaf.angle_rad, math.pi / 2), 30)
    arc = [hinge + math.cos(t) * along + math.sin(t) * opening.width_m * normal for t in turns]
    return shapely.Polygon([hinge, *arc])


def test_doors_swing_out_of_the_corridor_and_most_have_a_leaf():
    doors = [
        opening for seed in range(200) for opening in place_openings(ell_layout(["door"] * 4), np.random.default_rng(seed))
    ]
    into = Counter(door.leaf and door.leaf.into for door in doors)
    assert into["corridor"] == 0 and 0.02 < into[None] / len(doors) < 0.15
    assert all(0.79 <= door.width_m <= 1.01 for door in doors)


def test_a_house_with_leaves_as_they_stand_can_be_walked():
    for seed in range(8):
        layout = ell_layout(["door"] * 4, corridor_m=1.4)
        storey = StoreySpec(rooms=layout.rooms, openings=place_openings(layout, np.random.default_rng(seed)))
        house = build_house(HouseSpec(storeys=(storey,), clutter=0.0))
        assert set(Walkable(house).reachable_rooms()) == {"corridor", "ell", "a", "b"}


def test_what_is_too_wide_for_the_wall_becomes_a_door_as_narrow_as_needed():
    for wall, kind, width in ((1.2, "arch", 0.9), (1.02, "cased", 0.72), (1.0, "door", 0.7)):
        rooms = (rectangle("a", 0.0, 0.0, 3.0, wall), rectangle("b", 3.0, 0.0, 6.0, wall))
        (opening,) = place_openings(StoreyLayout(rooms, (Link(("a", "b"), kind),)), np.random.default_rng(1))
        assert opening.kind == "door" and opening.width_m <= width + 1e-9


def test_where_nothing_fits_both_rooms_are_named():
    rooms = (rectangle("kitchen 1", 0.0, 0.0, 3.0, 0.9), rectangle("pantry 1", 3.0, 0.0, 6.0, 0.9))
    for kind in ("door", "counter"):
        with pytest.raises(WorldsError, match=r"'kitchen 1' and 'pantry 1': they share 0\.90 m"):
            place_openings(StoreyLayout(rooms, (Link(("kitchen 1", "pantry 1"), kind),)), np.random.default_rng(0))


@given(layouts, seeds)
def test_a_gap_remembers_its_opening(make_layout, seed):
    layout = make_layout()
    rooms = {r.id: r for r in layout.rooms}
    for opening in place_openings(layout, np.random.default_rng(seed)):
        assert OpeningDraft.of(opening, rooms).spec() == opening


@pytest.mark.parametrize("leads", ["up", "down", None])
@pytest.mark.parametrize("leaf", [None, LeafSpec(into="hall")])
def test_a_gap_remembers_where_its_opening_leads(leads, leaf):
    rooms = {r.id: r for r in (rectangle("hall", 0.0, 0.0, 2.0, 3.0), rectangle("cell", 2.0, 0.0, 6.0, 3.0, label="stairs"))}
    ends = {"start_m": (2.0, 0.2), "end_m": (2.0, 1.3)}
    opening = OpeningSpec(rooms=("hall", "cell"), kind="door", leads=leads, leaf=leaf, **ends)
    assert OpeningDraft.of(opening, rooms).spec() == opening
