"""Windows: only in the outer walls of indoor rooms, clear of corners and of each other, drawn with the room's own seed."""

import itertools

import numpy as np
import pytest
import shapely
from helpers.opening_rooms import WALL_X, every_kind

from worlds.errors import HouseError
from worlds.house import build_house
from worlds.labels import OUTDOOR_LABELS
from worlds.openings.windows import sample_windows
from worlds.presets import PRESETS, sample_house
from worlds.spec import HouseSpec, RoomSpec, StoreySpec, WindowSpec
from worlds.walls import WALL_THICKNESS_M

BARE = {"storage room", "pantry", "garage", "stairs", *OUTDOOR_LABELS}


@pytest.fixture(scope="module", params=list(PRESETS))
def house(request):
    return build_house(sample_house(request.param, 5))


def test_windows_are_in_outer_walls_and_apart(house):
    assert house.windows
    for window in house.windows:
        room = house.room_by_id[window.room]
        assert room.label not in BARE
        line = shapely.LineString([window.start, window.end])
        assert room.polygon.exterior.buffer(1e-6).covers(line)
        rooms = house.spec.storeys[window.storey].rooms
        others = [r for r in rooms if r.id != window.room and r.label not in OUTDOOR_LABELS]
        assert all(shapely.Polygon(r.polygon_m).distance(line) > 0.15 for r in others)
        assert min(shapely.Point(corner).distance(line) for corner in room.polygon.exterior.coords) > 0.15
        storey = house.storeys[window.storey]
        assert storey.floor_m + 0.4 < window.position[2] < window.position[2] + window.size[2] < storey.ceiling_m
    for a, b in itertools.combinations(house.windows, 2):
        assert a.storey != b.storey or a.footprint.distance(b.footprint) > 0.1


def test_the_windows_of_a_room_look_alike(house):
    for _, windows in itertools.groupby(house.windows, lambda window: (window.storey, window.room)):
        assert len({(window.seed, window.size[2]) for window in windows}) == 1


@pytest.mark.parametrize("label", OUTDOOR_LABELS)
def test_rooms_look_out_into_gardens_and_onto_balconies(label):
    """A room whose only outer wall faces an outdoor room has its windows in this wall."""
    room = RoomSpec(id="living", label="living room", polygon_m=((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)))
    around = {
        "west": ("corridor", ((-2.0, -2.0), (0.0, -2.0), (0.0, 6.0), (-2.0, 6.0))),
        "east": ("corridor", ((5.0, -2.0), (7.0, -2.0), (7.0, 6.0), (5.0, 6.0))),
        "north": ("corridor", ((0.0, 4.0), (5.0, 4.0), (5.0, 6.0), (0.0, 6.0))),
        "south": (label, ((0.0, -2.0), (5.0, -2.0), (5.0, 0.0), (0.0, 0.0))),
    }
    others = tuple(RoomSpec(id=side, label=name, polygon_m=corners) for side, (name, corners) in around.items())
    houses = [build_house(HouseSpec(seed=s, storeys=(StoreySpec(rooms=(room, *others), furniture=()),))) for s in range(5)]
    windows = [window for house in houses for window in house.windows if window.room == "living"]
    assert windows
    assert all(window.start[1] == window.end[1] == 0.0 for window in windows)


def test_the_object_stands_on_the_inner_face_and_looks_into_the_room(house):
    for window in house.windows:
        room = house.room_by_id[window.room]
        assert room.polygon.covers(window.footprint)
        assert window.footprint.distance(room.polygon.exterior) == pytest.approx(WALL_THICKNESS_M / 2)
        x, y, _ = window.position
        front = np.array([x, y]) + 0.1 * np.array([-np.sin(window.yaw), np.cos(window.yaw)])
        assert room.polygon.exterior.distance(shapely.Point(front)) > room.polygon.exterior.distance(shapely.Point(x, y))


def test_rooms_look_as_they_should():
    """In many draws, living rooms have large windows, bathrooms small and high ones, and storage rooms none."""
    sizes = {}
    for label in ("living room", "bathroom", "storage room"):
        room = RoomSpec(id=label, label=label, polygon_m=((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)))
        outer = build_house(HouseSpec(storeys=(StoreySpec(rooms=(room,), furniture=()),))).boundaries[0]
        walls = [boundary for boundary, _ in outer]
        drawn = [w for seed in range(60) for w in sample_windows(room, walls, 2.6, np.random.default_rng(seed))]
        sizes[label] = [((w.height_m - w.sill_m) * np.hypot(*np.subtract(w.end_m, w.start_m)), w.sill_m) for w in drawn]
    assert sizes["storage room"] == []
    assert 60 <= len(sizes["living room"]) <= 120 and 15 <= len(sizes["bathroom"]) <= 45
    assert min(area for area, _ in sizes["living room"]) > 2 * max(area for area, _ in sizes["bathroom"])
    assert min(sill for _, sill in sizes["bathroom"]) > 1.3


def test_twins_have_the_same_windows():
    square = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    twins = tuple(
        RoomSpec(id=name, label="office", seed=7, polygon_m=tuple((x + dx, y) for x, y in square))
        for name, dx in (("one", 0.0), ("two", 20.0))
    )
    house = build_house(HouseSpec(storeys=(StoreySpec(rooms=twins, furniture=()),)))
    one, two = ([w for w in house.windows if w.room == name] for name in ("one", "two"))
    assert one and len(one) == len(two)
    for a, b in zip(one, two, strict=True):
        np.testing.assert_allclose(np.subtract(b.position, a.position), (20.0, 0.0, 0.0), atol=1e-9)
        assert a.size == b.size and a.parts == b.parts


def test_given_windows_are_kept_and_wrong_ones_refused():
    spec = every_kind()
    given = WindowSpec(room="kitchen", start_m=(0.0, 3.0), end_m=(0.0, 4.5))

    def house_with(window):
        return build_house(spec.model_copy(update={"storeys": (spec.storeys[0].model_copy(update={"windows": (window,)}),)}))

    (window,) = house_with(given).windows
    assert (window.start, window.end, window.size[0]) == (given.start_m, given.end_m, 1.5)
    for bad in ({"room": "living room"}, {"end_m": (0.4, 4.5)}, {"end_m": (0.0, 14.5)}, {"sill_m": 2.2}):
        with pytest.raises(HouseError, match=r"storeys\[0\].windows\[0\]"):
            house_with(given.model_copy(update=bad))
    with pytest.raises(HouseError, match="no other indoor room behind it"):
        house_with(WindowSpec(room="kitchen", start_m=(WALL_X, 0.1), end_m=(WALL_X, 0.4)))
