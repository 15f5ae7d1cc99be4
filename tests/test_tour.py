from functools import cache

import numpy as np
import pytest
import shapely

from sim.errors import SimError
from sim.tour import TourConfig, plan_tour
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec, RoomSpec, StoreySpec
from worlds.truth import room_at
from worlds.walkable import Walkable

RADIUS = 0.25


def tour_of(house, seed=0, **config):
    return plan_tour(house, Walkable(house, RADIUS), np.random.default_rng(seed), TourConfig(**config))


@cache
def furnished(preset, seed):
    return build_house(sample_house(preset, seed))


@pytest.fixture(scope="module", params=[("home", 11), ("uh2-apt", 12), ("random", 14)], ids=lambda p: p[0])
def house(request):
    return furnished(*request.param)


@pytest.fixture(scope="module")
def tour(house):
    return tour_of(house)


def test_body_touches_nothing(house, tour):
    feet = tour.motion.positions
    bodies = shapely.points(feet[:, :2])
    solids = [(w.footprint, w.bottom_m, w.top_m) for w in house.walls]
    solids += [(f.footprint, f.position[2], f.position[2] + f.size[2]) for f in house.furniture if f.solid]
    for shape, low, high in solids:
        shapely.prepare(shape)
        beside = (low < feet[:, 2] + 1.9) & (high > feet[:, 2] + 0.05)
        assert not shapely.dwithin(shape, bodies[beside], RADIUS - 1e-4).any()


def test_every_room_is_visited_and_the_tour_ends_where_it_began(house, tour):
    assert set(room_at(house, tour.T_W_B[:, :3, 3])) >= set(range(len(house.rooms)))
    np.testing.assert_allclose(tour.motion.positions[0], tour.motion.positions[-1], atol=1e-9)


def test_speed_and_turn_rate_keep_their_bounds(tour):
    dt = np.diff(tour.motion.times)
    assert dt.min() > 0.0
    speed = np.linalg.norm(np.diff(tour.motion.positions, axis=0), axis=1) / dt
    assert speed.max() <= 0.7 + 1e-6
    assert (speed > 0.7 - 1e-6).mean() > 0.6
    assert np.abs(np.diff(tour.motion.yaw) / dt).max() <= 1.2 + 1e-6


def test_body_is_level_at_eye_height_on_the_floor_or_the_stairs(house, tour):
    np.testing.assert_allclose(tour.T_W_B[:, 2, :3], np.tile([0.0, 0.0, 1.0], (len(tour.stamps), 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(tour.T_W_B[:, :3, :3]), 1.0)
    feet = tour.T_W_B[:, :3, 3] - [0.0, 0.0, 1.4]
    off_floor = np.abs(feet[:, 2:] - [s.floor_m for s in house.storeys]).min(axis=1) > 0.06
    on_stairs = np.array([r.label == "stairs" for r in house.rooms])[room_at(house, np.add(feet, [0.0, 0.0, 0.1]))]
    assert not (off_floor & ~on_stairs).any()


def test_lowest_storey_is_seen_again_from_the_same_direction(house, tour):
    """At least 10 s later, within 1 m and 0.5 rad: what a loop closure needs."""
    position, forward = tour.T_W_B[:, :3, 3], tour.T_W_B[:, :2, 0]
    low = np.flatnonzero(position[:, 2] < 1.5)[::5]
    near = np.linalg.norm(position[low, None] - position[None, low], axis=-1) < 1.0
    aligned = forward[low] @ forward[low].T > np.cos(0.5)
    earlier = tour.stamps[low, None] - tour.stamps[None, low] > 10.0
    second_half = low > low[len(low) // 2]
    assert (near & aligned & earlier).any(axis=1)[second_half].mean() > 0.7


def test_frame_rate_only_samples_the_motion():
    house = furnished("random", 14)
    slow, fast = tour_of(house, frame_rate_hz=10.0), tour_of(house, frame_rate_hz=20.0)
    np.testing.assert_allclose(fast.T_W_B[::2][: len(slow.stamps)], slow.T_W_B, atol=1e-9)
    np.testing.assert_array_equal(slow.pose_at(slow.stamps[37]), slow.T_W_B[37])


def test_same_seed_same_tour_and_another_seed_another():
    house = furnished("home", 11)
    first, again, other = tour_of(house, 1), tour_of(house, 1), tour_of(house, 2)
    np.testing.assert_array_equal(first.T_W_B, again.T_W_B)
    assert first.T_W_B.shape != other.T_W_B.shape or not np.allclose(first.T_W_B, other.T_W_B)


@pytest.mark.parametrize("length_m", [118.0, 264.0])
def test_asked_length_is_met(length_m):
    assert tour_of(furnished("home", 11), length_m=length_m).length_m == pytest.approx(length_m, rel=0.1)


def test_bad_settings_name_what_is_valid():
    with pytest.raises(SimError, match=r"speed_m_s is 0.*valid"):
        TourConfig(speed_m_s=0.0)
    for endless in (np.inf, np.nan):
        with pytest.raises(SimError, match=r"length_m is (inf|nan); valid"):
            TourConfig(length_m=endless)
    cell = RoomSpec(id="cell", label="storage room", polygon_m=((0.0, 0.0), (1.2, 0.0), (1.2, 1.2), (0.0, 1.2)))
    with pytest.raises(SimError, match="can stop at 1 places in it; a tour needs two"):
        tour_of(build_house(HouseSpec(storeys=(StoreySpec(rooms=(cell,), furniture=()),))))
