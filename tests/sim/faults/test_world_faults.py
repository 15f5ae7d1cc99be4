"""Faults of the world: moved objects stay physically possible, and are visible when the truth says so."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from shapely.geometry import LineString, Point

from sim.faults import FAULTS, WorldFault, WorldState, fault_rng
from sim.faults.closing_doors import ClosingDoors, all_leaves, built_leaves
from sim.faults.images import Blur
from sim.faults.moved_furniture import with_furniture_moved
from sim.faults.world import ClosedDoors, MovedFurniture, Pedestrian
from sim.odometry.config import ODOMETRY_PRESETS
from sim.odometry.simulation import tour_odometry
from sim.render.camera import wide_camera
from sim.session import Session
from sim.tours.tour import Tour, TourConfig, plan_tour
from worlds.checks import PlanGrid, furniture_problems
from worlds.furniture.catalogue import kind_of
from worlds.furniture.kinds import OnCeiling, OnWall
from worlds.house import build_house
from worlds.presets import PRESETS, sample_from_rooms, sample_house
from worlds.walkable import Walkable

FRAMES = 32


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("home", 7))


@pytest.fixture(scope="module")
def tour(house):
    return plan_tour(house, Walkable(house), np.random.default_rng(0), TourConfig(length_m=120.0))


@pytest.fixture(scope="module")
def flat():
    """A house that renders ten times faster."""
    return build_house(sample_from_rooms(("kitchen", "bedroom"), seed=22))


@pytest.fixture(scope="module")
def flat_tour(flat):
    return plan_tour(flat, Walkable(flat), np.random.default_rng(0), TourConfig(length_m=45.0))


@pytest.fixture(scope="module")
def short(flat_tour):
    """Frames from the whole length of the tour."""
    k = np.linspace(0, len(flat_tour.stamps) - 1, FRAMES).astype(int)
    return Tour(flat_tour.stamps[k], flat_tour.T_W_B[k], flat_tour.motion, flat_tour.eye_height_m)


def session(house, tour, *faults, seed=5):
    odometry = tour_odometry(tour, ODOMETRY_PRESETS["multicam"], np.random.default_rng(2))
    return Session(house, tour, odometry, wide_camera(96, 72), faults, seed)


@pytest.fixture(scope="module")
def clean(flat, short):
    return list(session(flat, short))


def changed(clean, pairs):
    return np.array([not np.array_equal(a.image, b.image) for (a, _), (b, _) in zip(clean, pairs, strict=True)])


def names(pairs):
    return [truth.faults for _, truth in pairs]


def poses(things):
    return [(thing.id, thing.position, thing.yaw, thing.size) for thing in things]


def test_moved_furniture_stands_clear_in_its_room(house, tour):
    fault = MovedFurniture(0.6)
    after = fault.change(WorldState(house), tour, fault_rng(5, 0)).house
    moved = [piece.id for piece, old in zip(after.furniture, house.furniture, strict=True) if piece.position != old.position]
    assert len(moved) > 10
    later = tour.T_W_B[tour.stamps >= tour.stamps[-1] / 2, :3, 3]
    standing = [p for p in after.furniture if p.solid and p.position[2] == after.storeys[p.storey].floor_m]
    before = {p.id: p for p in house.furniture}
    for piece in standing:
        if piece.id in moved:
            storey = after.storeys[piece.storey]
            way = later[(later[:, 2] > storey.floor_m) & (later[:, 2] < storey.ceiling_m), :2]
            assert after.room_by_id[piece.room].polygon.covers(piece.footprint)
            assert len(way) < 2 or piece.footprint.distance(LineString(way)) > 0.24
    for a, b in combinations(standing, 2):
        if a.storey == b.storey and {a.id, b.id} & set(moved):
            assert a.footprint.intersection(b.footprint).area < 1e-6
    for piece in after.furniture:
        if not piece.solid and piece.id in moved:
            assert any(
                before[other].footprint.covers(Point(before[piece.id].position[:2])) for other in moved if other != piece.id
            )
    np.testing.assert_array_equal([p.size for p in after.furniture], [p.size for p in house.furniture])


@pytest.mark.parametrize("preset", PRESETS)
def test_a_house_with_moved_furniture_passes_the_checks_of_a_house(preset):
    """No two things overlap, nothing stands where a door swings or in a window, nothing leaves its room, and what hangs on a
    wall stays there."""
    for seed in (1, 2, 3, 4, 300):
        house = build_house(sample_house(preset, seed))
        after = with_furniture_moved(house, np.zeros((0, 3)), 1.0, 1.5, 0.5, np.random.default_rng(seed))
        assert poses(after) != poses(house.furniture)
        hanging = [isinstance(kind_of(piece.kind).place, OnWall | OnCeiling) for piece in after]
        assert [p for p, hangs in zip(poses(after), hanging, strict=True) if hangs] == [
            p for p, hangs in zip(poses(house.furniture), hanging, strict=True) if hangs
        ]
        grid = PlanGrid.of(house.spec)
        assert set(furniture_problems(replace(house, furniture=after), grid)) <= set(furniture_problems(house, grid))


@pytest.mark.parametrize("number", [1, 2])
def test_furniture_stands_in_one_place_while_doors_begin_and_end_to_close(number):
    house = build_house(sample_house("home", number))
    tour = plan_tour(house, Walkable(house), np.random.default_rng(0), TourConfig(length_m=120.0))
    moves, closes = MovedFurniture(0.5, at_s=20.0), ClosedDoors(0.7, at_s=40.0, for_s=20.0)
    alone = moves.change(WorldState(house), tour, fault_rng(5, 1))
    both = moves.change(closes.change(WorldState(house), tour, fault_rng(5, 0)), tour, fault_rng(5, 1))
    assert poses(alone.house.furniture) == poses(both.house.furniture) != poses(house.furniture)


def test_the_built_leaves_are_those_of_the_house(house):
    assert poses(built_leaves(house)) == poses(house.leaves) == poses(built_leaves(replace(house, leaves=())))


def test_every_door_way_gets_a_leaf(house):
    storeys = [
        storey.model_copy(update={"openings": tuple(o.model_copy(update={"leaf": None}) for o in storey.openings)})
        for storey in house.spec.storeys
    ]
    bare = build_house(house.spec.model_copy(update={"storeys": tuple(storeys)}))
    assert not bare.leaves and {leaf.id for leaf in all_leaves(bare)} == {leaf.id for leaf in all_leaves(house)}
    for leaf, own in zip(all_leaves(house), house.leaves, strict=True):
        assert (leaf.id, leaf.position, leaf.yaw) == (own.id, own.position, own.yaw)


def test_doors_are_shut_unless_the_body_is_near(house, tour):
    leaves = list(all_leaves(house))
    closing = ClosingDoors(leaves)
    states = set()
    for T in tour.T_W_B[::5]:
        for leaf, solid in zip(leaves, closing.solids_at(0.0, T), strict=True):
            reach = np.hypot(*(np.array(leaf.hinge) - T[:2, 3]))
            far = reach > 3.0 or not 0.0 < T[2, 3] - leaf.position[2] < 3.0
            states.add(far)
            if far:
                assert solid.yaw == pytest.approx(leaf.shut_yaw)
            elif 0.0 < T[2, 3] - leaf.position[2] < 3.0:
                half = leaf.size[0] / 2 * np.array([np.cos(solid.yaw), np.sin(solid.yaw)])
                middle = np.array(solid.position[:2])
                np.testing.assert_allclose(middle - half, leaf.hinge, atol=1e-9)
                assert LineString([middle - half, middle + half]).distance(Point(T[:2, 3])) > 0.15
    assert states == {True, False}


def test_a_person_walks_the_tour_ahead_of_the_camera(house, tour):
    fault = Pedestrian(at_s=30.0, pace=1.5, ahead_s=2.0)
    (person,) = fault.change(WorldState(house), tour, fault_rng(5, 0)).actors
    for t in (30.0, 32.5, 40.0):
        expected = tour.pose_at(32.0 + 1.5 * (t - 30.0))
        for solid in person.solids_at(t, np.eye(4)):
            np.testing.assert_allclose(solid.position[:2], expected[:2, 3])
            assert solid.position[2] == pytest.approx(expected[2, 3] - tour.eye_height_m)
            assert 1.5 < max(part.centre[2] + part.size[2] / 2 for part in solid.parts) < 2.0
    assert person.solids_at(30.0, tour.pose_at(32.0)) == []


@pytest.mark.parametrize("fault", [MovedFurniture(0.8), ClosedDoors()], ids=["furniture", "doors"])
def test_a_changed_world_is_seen_from_its_time_on(flat, short, clean, fault):
    pairs = list(session(flat, short, fault, seed=7))  # moves the nightstand, which is in view for long
    half = short.stamps >= short.stamps[-1] / 2
    assert names(pairs) == [(fault.name,) if late else () for late in half]
    seen = changed(clean, pairs)
    assert not seen[~half].any() and seen[half].mean() > 0.2
    for (a, _), (b, _) in zip(clean, pairs, strict=True):  # and no fault changes the odometry
        np.testing.assert_array_equal(a.T_O_B, b.T_O_B)


WORLD = (MovedFurniture(0.8), ClosedDoors(0.5), Pedestrian())


def test_every_fault_of_the_world_is_tested():
    assert {type(fault) for fault in WORLD} == {kind for kind in FAULTS.values() if issubclass(kind, WorldFault)}


@pytest.mark.parametrize("fault", WORLD, ids=lambda fault: fault.name)
def test_the_same_seed_changes_the_same(flat, flat_tour, fault):
    def things():
        stage = fault.change(WorldState(flat), flat_tour, fault_rng(5, 0))
        moving = [solid for actor in stage.actors for solid in actor.solids_at(flat_tour.stamps[-1] / 2, np.eye(4))]
        return [
            (*thing.position, thing.yaw, *(part.size for part in thing.parts)) for thing in (*stage.house.furniture, *moving)
        ]

    assert things() == things()


def test_a_person_is_seen_for_a_while_and_hides_what_is_behind(flat, flat_tour):
    k = slice(200, 500, 12)
    part = Tour(flat_tour.stamps[k], flat_tour.T_W_B[k], flat_tour.motion, flat_tour.eye_height_m)
    fault = Pedestrian(at_s=float(part.stamps[4]), for_s=10.0, ahead_s=2.5, pace=1.0)
    pairs, clean = list(session(flat, part, fault)), list(session(flat, part))
    there = np.array(["person" in truth.faults for _, truth in pairs])
    np.testing.assert_array_equal(there, (part.stamps >= fault.at_s) & (part.stamps < fault.at_s + 10.0))
    seen = changed(clean, pairs)
    assert not seen[~there].any() and seen[there].sum() >= 3


def test_faults_of_the_world_and_of_the_stream_compose(flat, short, clean):
    blur = Blur(5, at_s=float(short.stamps[-8]))
    pairs = list(session(flat, short, blur, MovedFurniture(0.8)))
    assert names(pairs)[-1] == ("moved-furniture", "blur") and names(pairs)[0] == ()
    assert names(pairs)[-10] == ("moved-furniture",)
