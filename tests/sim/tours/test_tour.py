from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely
from helpers.unchecked import unchecked
from scipy.spatial import cKDTree

from sim.errors import SimError
from sim.tours.config import TOUR_KINDS
from sim.tours.tour import TourConfig, plan_tour, shortest_length
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec, RoomSpec, StoreySpec
from worlds.truth import room_at
from worlds.walkable import Walkable

RADIUS = 0.25
LIMITS = {"speed_m_s": 0.7, "acceleration_m_s2": 1.5, "turn_rate_rad_s": 1.2}


@cache
def furnished(preset, seed):
    house = build_house(sample_house(preset, seed))
    return house, Walkable(house, RADIUS)


@cache
def tour_of(preset, number, seed=0, **config):
    return plan_tour(*furnished(preset, number), np.random.default_rng(seed), TourConfig(**config))


@pytest.fixture(scope="module", params=[("home", 11), ("uh2-apt", 12), ("random", 15)], ids=lambda p: p[0])
def preset(request):
    return request.param


@pytest.fixture(scope="module", params=TOUR_KINDS)
def kind(request):
    return request.param


@pytest.fixture(scope="module")
def house(preset):
    return furnished(*preset)[0]


@pytest.fixture(scope="module")
def tour(preset, kind):
    return tour_of(*preset, kind=kind)


@pytest.fixture(scope="module")
def rooms_tour(preset):
    return tour_of(*preset)


def times(tour, step_s=0.01):
    return np.append(np.arange(0.0, tour.motion.duration_s, step_s), tour.motion.duration_s)


def norm(v):
    return np.linalg.norm(v, axis=1)


def test_body_touches_nothing(house, tour):
    feet = tour.motion.position(times(tour))
    bodies = shapely.points(feet[:, :2])
    solids = [(w.footprint, w.bottom_m, w.top_m) for w in house.walls]
    solids += [(f.footprint, f.position[2], f.position[2] + f.size[2]) for f in house.furniture if f.solid]
    solids += [(leaf.footprint, leaf.position[2], leaf.position[2] + leaf.size[2]) for leaf in house.leaves]
    shapes, low, high = (np.array(column) for column in zip(*solids, strict=True))
    body, solid = shapely.STRtree(shapes).query(bodies, "dwithin", RADIUS - 1e-4)
    height = feet[body, 2]
    assert not ((low[solid] < height + 1.9) & (high[solid] > height + 0.05)).any()


def test_limits_are_kept_at_every_time_and_most_of_the_way_is_walked_at_full_speed(tour):
    t, motion = times(tour), tour.motion
    speed = norm(motion.velocity(t))
    assert speed.max() <= LIMITS["speed_m_s"] + 1e-9
    assert norm(motion.acceleration(t)).max() <= LIMITS["acceleration_m_s2"] + 1e-9
    assert np.abs(motion.yaw_rate(t)).max() <= LIMITS["turn_rate_rad_s"] + 1e-9
    assert (speed > 0.69).mean() > 0.45
    np.testing.assert_allclose(norm(motion.velocity(t[[0, -1]])), 0.0, atol=1e-9)


def test_it_ends_where_it_began_and_never_leaves_the_rooms(house, tour):
    feet = tour.motion.position(times(tour))
    np.testing.assert_allclose(feet[0], feet[-1], atol=1e-9)
    rooms = room_at(house, feet + [0.0, 0.0, 0.1])
    assert (rooms >= 0).all()
    off_floor = np.abs(feet[:, 2:] - [s.floor_m for s in house.storeys]).min(axis=1) > 1e-9
    near_stairs = shapely.union_all([r.polygon for r in house.rooms if r.label == "stairs"]).buffer(0.6)
    assert shapely.contains_xy(near_stairs, feet[off_floor, 0], feet[off_floor, 1]).all()


def test_on_stairs_the_feet_follow_the_walking_line(house, rooms_tour):
    """The path is within 15 cm sideways and within 5 cm in height: less than a third of a riser."""
    feet = rooms_tour.motion.position(times(rooms_tour, 0.05))
    for flight in house.stairs:
        line = shapely.LineString(flight.walking_line[:, :2])
        s = np.append(0.0, np.cumsum(norm(np.diff(flight.walking_line[:, :2], axis=0))))
        low, high = flight.walking_line[[0, -1], 2]
        on = feet[(feet[:, 2] > low + 0.1) & (feet[:, 2] < high - 0.1)]
        places = shapely.points(on[:, :2])
        assert shapely.distance(line, places).max() < 0.15
        height = np.interp(shapely.line_locate_point(line, places), s, flight.walking_line[:, 2])
        assert np.abs(height - on[:, 2]).max() < 0.05


@pytest.mark.parametrize("kind", ["rooms", "both ways", "lawn-mower"])
def test_every_room_is_visited(preset, kind):
    tour, house = tour_of(*preset, kind=kind), furnished(*preset)[0]
    assert set(room_at(house, tour.T_W_B[:, :3, 3])) >= set(range(len(house.rooms)))


def test_view_is_level_unless_it_is_asked_to_follow_the_stairs(preset, rooms_tour):
    up = np.tile([0.0, 0.0, 1.0], (len(rooms_tour.stamps), 1))
    np.testing.assert_allclose(rooms_tour.T_W_B[:, 2, :3], up, atol=1e-12)
    t = times(rooms_tour, 0.05)
    motion = tour_of(*preset, pitch_on_stairs=True).motion
    t = t[t < motion.duration_s]
    slope = -np.arctan2(motion.velocity(t)[:, 2], norm(motion.velocity(t)[:, :2]))
    pitch = motion.attitude(t)[:, 1]
    steep = (np.abs(slope) > 0.3) & (norm(motion.velocity(t)) > 0.6)
    assert np.abs(pitch[steep] - slope[steep]).max(initial=0.0) < 0.45
    assert np.median(np.abs(pitch[steep] - slope[steep])) < 0.05 if steep.any() else np.abs(pitch).max() == 0.0


def aligned_earlier(tour, sign, storeys=np.inf):
    """Share of later poses that were near a pose at least 10 s earlier, with equal (+1) or opposite (-1) heading."""
    position, forward = tour.T_W_B[:, :3, 3], tour.T_W_B[:, :2, 0]
    own = np.flatnonzero(position[:, 2] < storeys)[::5]
    near = np.linalg.norm(position[own, None] - position[None, own], axis=-1) < 1.0
    aligned = sign * forward[own] @ forward[own].T > np.cos(0.5)
    earlier = tour.stamps[own, None] - tour.stamps[None, own] > 10.0
    return (near & aligned & earlier).any(axis=1)[len(own) // 2 :].mean()


def test_lowest_storey_is_seen_again_from_the_same_direction(rooms_tour):
    assert aligned_earlier(rooms_tour, 1, storeys=1.5) > 0.7


def test_both_ways_sees_the_whole_way_from_the_opposite_direction(preset):
    assert aligned_earlier(tour_of(*preset, kind="both ways"), -1) > 0.8


def test_a_loop_is_the_same_circuit_again():
    tour = tour_of("home", 11, kind="loop", circuit_m=30.0, laps=4)
    assert tour.length_m == pytest.approx(120.0, rel=0.1)
    assert aligned_earlier(tour, 1) > 0.9


def test_the_shortest_circuit_is_walked_in_every_house(preset):
    assert 1.0 < tour_of(*preset, kind="loop", circuit_m=2.0, laps=2).length_m < 6.0


def test_a_loop_has_as_many_laps_as_are_asked_for(preset):
    once, thrice = (tour_of(*preset, kind="loop", circuit_m=2.0, laps=laps).length_m for laps in (1, 3))
    assert thrice == pytest.approx(3.0 * once, rel=0.15)


def test_every_kind_of_tour_leads_through_a_house_of_one_room(kind):
    room = RoomSpec(id="a", label="bedroom", polygon_m=((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)))
    house = build_house(HouseSpec(storeys=(StoreySpec(rooms=(room,), furniture=()),)))
    walkable, config = Walkable(house, RADIUS), TourConfig(kind=kind)
    shortest_m = shortest_length(house, walkable, np.random.default_rng(0), config)
    longer = replace(config, length_m=shortest_m + 2.0)
    assert plan_tour(house, walkable, np.random.default_rng(0), longer).length_m == pytest.approx(shortest_m + 2.0, abs=1.0)


def test_a_lawn_mower_comes_near_every_free_place(preset, house):
    walkable = furnished(*preset)[1]
    tour = tour_of(*preset, kind="lawn-mower", lane_m=0.8)
    feet = cKDTree(tour.motion.position(times(tour, 0.1))[:, :2])
    stairs = [k for k, room in enumerate(house.rooms) if room.label == "stairs"]
    free = walkable.nodes[walkable.connected & ~np.isin(walkable.node_room, stairs)]
    assert (feet.query(free[:, :2])[0] < 0.8).mean() > 0.95


@pytest.mark.parametrize(("kind", "length_m"), [
    *(("rooms", length) for length in (118.0, 140.0, 264.0)),
    *(("loop", length) for length in (49.0, 264.0)), ("random", 49.0), ("random", 118.0), ("both ways", 264.0),
    ("lawn-mower", 264.0),
])  # fmt: skip
def test_asked_length_is_met(kind, length_m):
    tour = tour_of("home", 11, kind=kind, length_m=length_m)
    assert tour.length_m == pytest.approx(length_m, abs=max(3.0, 0.03 * length_m))


def test_a_short_tour_leaves_out_second_stops_but_no_room():
    house = furnished("home", 11)[0]
    whole, short = tour_of("home", 11), tour_of("home", 11, length_m=90.0)
    assert short.length_m < 0.7 * whole.length_m
    assert set(room_at(house, short.T_W_B[:, :3, 3])) >= set(range(len(house.rooms)))
    with pytest.raises(
        SimError, match=r"length_m is 30; valid: at least \d+ for a tour \(rooms\) that visits every room of house 'home-11'"
    ):
        tour_of("home", 11, length_m=30.0)


@pytest.mark.parametrize(("kind", "length_m"), [("loop", 20.0), ("random", 36.0)])
def test_a_tour_of_only_some_rooms_is_not_said_to_visit_every_room(kind, length_m):
    with pytest.raises(SimError, match=rf"valid: at least \d+ for a tour \({kind}\) in house 'home-11'"):
        tour_of("home", 11, kind=kind, length_m=length_m)


def test_random_tours_differ_and_reach_many_rooms():
    first, other = (tour_of("home", 11, seed, kind="random", length_m=150.0) for seed in (0, 1))
    rooms = [set(room_at(furnished("home", 11)[0], tour.T_W_B[:, :3, 3])) for tour in (first, other)]
    assert min(map(len, rooms)) >= 6
    assert np.abs(first.T_W_B[0] - other.T_W_B[0]).max() > 0.1


def test_a_reversed_tour_walks_the_same_path_from_its_end():
    tours = (tour_of("home", 11, length_m=120.0, reverse=reverse) for reverse in (False, True))
    there, back = (tour.motion.position(np.linspace(0.0, tour.motion.duration_s, 4000)) for tour in tours)
    far, _ = cKDTree(there).query(back)
    assert far.max() < 0.03
    # Both begin at the same place, since tours are closed, and leave it in opposite directions.
    ahead = [np.diff(path[[0, 100]], axis=0)[0] for path in (there, back)]
    np.testing.assert_allclose(there[0], back[0], atol=1e-6)
    assert np.linalg.norm(ahead[0] - ahead[1]) > 0.3


def test_frame_rate_only_samples_the_motion():
    slow, fast = (tour_of("random", 14, frame_rate_hz=rate) for rate in (10.0, 20.0))
    np.testing.assert_allclose(fast.T_W_B[::2][: len(slow.stamps)], slow.T_W_B, atol=1e-9)
    np.testing.assert_array_equal(slow.pose_at(slow.stamps[37]), slow.T_W_B[37])


def test_sway_is_added_to_the_same_walk():
    plain, swaying = (tour_of("random", 14, sway=sway) for sway in ("none", "quadruped"))
    np.testing.assert_array_equal(plain.motion.controls, swaying.motion.controls)
    assert plain.length_m == swaying.length_m
    assert 0.0 < np.abs(plain.T_W_B - swaying.T_W_B).max() < 0.1


def test_same_seed_same_tour_and_another_seed_another(kind):
    arguments = {"rng": np.random.default_rng(1), "config": TourConfig(kind=kind)}
    again = plan_tour(*furnished("home", 11), **arguments)
    first, other = (tour_of("home", 11, seed, kind=kind) for seed in (1, 2))
    np.testing.assert_array_equal(first.T_W_B, again.T_W_B)
    assert first.T_W_B.shape != other.T_W_B.shape or not np.allclose(first.T_W_B, other.T_W_B)


def test_bad_settings_name_what_is_valid():
    with pytest.raises(SimError, match=r"speed_m_s is 0.*valid"):
        TourConfig(speed_m_s=0.0)
    with pytest.raises(SimError, match=r"kind is 'zigzag'; valid: rooms, both ways, loop, random, lawn-mower"):
        unchecked(TourConfig, kind="zigzag")
    with pytest.raises(SimError, match=r"laps is 0.*valid: >= 1"):
        TourConfig(laps=0)
    for endless in (np.inf, np.nan):
        with pytest.raises(SimError, match=r"length_m is (inf|nan); valid"):
            TourConfig(length_m=endless)
    with pytest.raises(SimError, match=r"^tour: eye_height_m is 1\.9; valid: below 1\.9, the height up to which paths"):
        tour_of("home", 11, eye_height_m=1.9)
    assert tour_of("random", 14, kind="loop").length_m > 20.0
    with pytest.raises(SimError, match=r"circuit_m is 900; valid: up to \d+ in this house"):
        tour_of("random", 14, kind="loop", circuit_m=900.0)
    for short in (0.05, 0.3, 1.99):
        with pytest.raises(SimError, match=rf"tour.circuit_m is {short}; valid: >= 2 m"):
            unchecked(TourConfig, kind="loop", circuit_m=short)
    cell = RoomSpec(id="cell", label="storage room", polygon_m=((0.0, 0.0), (1.2, 0.0), (1.2, 1.2), (0.0, 1.2)))
    tiny = build_house(HouseSpec(storeys=(StoreySpec(rooms=(cell,), furniture=()),)))
    with pytest.raises(SimError, match="can stop at 1 place; valid: a house with two"):
        plan_tour(tiny, Walkable(tiny), np.random.default_rng(0))
