"""A body in MuJoCo that drives by its own pose estimate."""

from dataclasses import replace

import numpy as np
import pytest

from sim.errors import SimError
from sim.odometry.config import ODOMETRY_PRESETS, OdometryConfig
from sim.robot import DeadReckoning, Robot
from sim.robot.body import RADIUS_M, Body
from sim.robot.controller import HORIZON_M, LEAST_M, Controller
from sim.robot.local_map import CELL_M, LocalMap
from sim.robot.scan import RangeScanner
from worlds.house import Furniture, build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.variant import variant
from worlds.walkable import Walkable


def two_rooms(door=True):
    """An office and a kitchen, each 4 x 3 m, with a door in the middle of the wall between them."""
    rooms = tuple(
        RoomSpec(id=name, label=name, polygon_m=((x, 0.0), (x + 4.0, 0.0), (x + 4.0, 3.0), (x, 3.0)))
        for name, x in (("office", 0.0), ("kitchen", 4.0))
    )
    opening = OpeningSpec(rooms=("office", "kitchen"), kind="door", start_m=(4.0, 1.0), end_m=(4.0, 2.0))
    return build_house(HouseSpec(storeys=(StoreySpec(rooms=rooms, openings=(opening,) if door else (), furniture=()),)))


@pytest.fixture(scope="module")
def home():
    return build_house(sample_house("home", 600))


def go(house, *waypoints, drift=None, off=(0.0, 0.0, 0.0), seed=0, blind=False):
    """Drive from the first waypoint, facing the second, with a pose estimate that is wrong by `off`."""
    points = np.array([(*point, 0.0)[:3] for point in waypoints])
    toward = points[min(1, len(points) - 1)] - points[0]
    yaw = float(np.arctan2(toward[1], toward[0]))
    x, y, turn = off
    pose = DeadReckoning(
        points[0, 0] + x, points[0, 1] + y, yaw + turn, drift or OdometryConfig(), np.random.default_rng(seed)
    )
    return Robot(house, blind).drive(points[0], yaw, pose, points)


def in_body_frame(points, pose):
    """Return points of shape (n, 2) in the robot's own frame, at a given pose of the robot."""
    cos, sin = np.cos(pose.yaw), np.sin(pose.yaw)
    return (points - (pose.x, pose.y)) @ np.array([[cos, -sin], [sin, cos]])


def test_a_body_touches_a_wall_from_where_its_surface_meets_it():
    body = Body(two_rooms())
    wall = 0.05  # half its thickness
    assert body.place(wall + RADIUS_M + 0.001, 1.5, 0.0) == ()
    touched = body.place(wall + RADIUS_M - 0.001, 1.5, 0.0)
    assert touched and all(name.startswith("wall#") for name in touched)


def test_a_drive_along_free_space_touches_nothing_and_is_hardly_longer_than_the_plan():
    result = go(two_rooms(), (1.0, 1.5), (3.0, 1.5), (7.0, 1.5))
    assert (result.room, result.touched) == ("kitchen", ())
    assert 5.8 <= result.length_m <= 6.2
    np.testing.assert_allclose(result.path[:, 1], 1.5, atol=0.05)


def test_the_robot_goes_round_what_the_map_does_not_know():
    table = Furniture("table", "dining table", "office", 0, (2.0, 1.5, 0.0), 0.3, (0.8, 1.0, 0.7), True)
    result = go(replace(two_rooms(), furniture=(table,)), (0.6, 1.5), (3.4, 1.5), (6.0, 1.5))
    assert (result.room, result.touched) == ("kitchen", ())


def test_passing_the_end_of_a_plan_is_not_arriving():
    """A path may pass below its end, for example below a room upstairs that is the goal of the plan."""
    driven = go(two_rooms(), (1.0, 1.5), (6.0, 1.5), (1.1, 1.5), (1.1, 0.8), (2.0, 0.8), (2.0, 1.0))
    assert driven.length_m > 10.0
    assert not driven.touched


@pytest.mark.parametrize("x", [3.3, 3.7, 4.0, 4.2])
def test_the_robot_stops_where_its_plan_ends_on_either_side_of_a_door_or_in_it(x):
    driven = go(two_rooms(), (1.0, 1.5), (x, 1.5))
    np.testing.assert_allclose(driven.path[-1, :2], [x, 1.5], atol=0.12)


def test_a_drift_that_leads_a_blind_robot_into_the_jamb_is_made_good_by_the_scan():
    house, way, off = two_rooms(), [(1.0, 1.5), (7.0, 1.5)], (0.0, 0.35, 0.0)
    blind, seeing = (go(house, *way, off=off, blind=blind) for blind in (True, False))
    assert blind.room == "office" and blind.touched[0].startswith("wall#")
    np.testing.assert_allclose(blind.path[-1, :2], [4.0 - RADIUS_M, 1.15], atol=0.1)
    assert (seeing.room, seeing.touched) == ("kitchen", ())


def test_without_a_path_the_robot_stops_in_front_of_the_wall():
    result = go(two_rooms(door=False), (1.0, 1.5), (7.0, 1.5))
    assert (result.room, result.touched) == ("office", ())


@pytest.mark.parametrize(("wall_ends_at", "goes_round"), [(0.7, True), (1.4, False)])
def test_a_wall_is_passed_round_its_near_end_but_not_round_a_far_one(wall_ends_at, goes_round):
    """An example is the wall between two flights of stairs into which the drifted route runs."""
    around, start = LocalMap(LEAST_M), np.array([0.0, 0.6])
    route = np.linspace(start, [0.0, 0.6 - HORIZON_M], 18)
    wall = np.stack([np.arange(-1.8, wall_ends_at, 0.02), np.zeros(round((wall_ends_at + 1.8) / 0.02))], axis=1)
    around.add(wall - start, *start, 0.0, 0.0)
    way = around.plan_path(start, route)
    lengths = np.linalg.norm(np.diff(way, axis=0), axis=1)
    assert np.allclose(way[0], start) and lengths.max() < 1.5 * CELL_M
    assert (np.linalg.norm(way[-1] - route[-1]) < CELL_M) == goes_round
    assert (way[-1, 1] < 0.0) == goes_round


@pytest.mark.parametrize("aside_m", [0.0, 0.02, 0.04, 0.06])
def test_the_robot_drives_through_a_gap_that_lies_between_the_cells_of_the_ordinary_grid(aside_m):
    """The robot's centre may pass the gap on a strip 4 cm wide, `aside_m` from the route."""
    half = LEAST_M + 0.02
    y = np.concatenate([np.arange(-2.0, -half, 0.02), [-half, half], np.arange(half, 2.0, 0.02)])
    gap = np.concatenate([np.stack([np.full(len(y), x), y + aside_m], axis=1) for x in np.arange(0.5, 1.0, 0.05)])
    controller = Controller(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))
    pose = DeadReckoning(0.0, 0.0, 0.0, OdometryConfig(), np.random.default_rng(0))
    for _ in range(150):
        controller.see(in_body_frame(gap, pose), pose, 0.0)
        if (motion := controller.step(pose)) is None:
            break
        pose.advance(*motion)
        assert np.linalg.norm(in_body_frame(gap, pose), axis=1).min() > RADIUS_M
    np.testing.assert_allclose([pose.x, pose.y], [2.0, 0.0], atol=0.1)


def follow(way, start, obstacles, height=lambda pose: 0.0):
    """Steer through waypoints (n, 3) for 20 s from the pose (x, y, yaw) `start`, with a full view of `obstacles` (m, 2).

    The result has the positions after each step.
    """
    controller, pose = Controller(way), DeadReckoning(*start, OdometryConfig(), np.random.default_rng(0))
    path = []
    for _ in range(200):
        controller.see(in_body_frame(obstacles, pose), pose, height(pose))
        if (motion := controller.step(pose)) is None:
            break
        pose.advance(*motion)
        path.append((pose.x, pose.y))
    return np.array(path)


def two_flights(end_m):
    """Two flights along y, 0.9 m wide, with a railing between them at x = 0, and a landing from y = `end_m` on."""
    along, across = np.arange(-3.0, end_m, 0.02), np.arange(-0.9, 0.9, 0.02)
    sides = [np.stack([np.full(len(along), x), along], axis=1) for x in (-0.9, 0.0, 0.9)]
    return np.concatenate([*sides, np.stack([across, np.full(len(across), end_m + 0.9)], axis=1)])


@pytest.mark.parametrize("beyond_m", [0.1, 0.2, 0.3])
def test_the_robot_goes_round_the_end_of_a_railing_beyond_the_turn_of_its_route(beyond_m):
    """A route turns back on the landing between two flights, and has drifted: the landing lies `beyond_m` farther ahead."""
    plan = np.array([[-0.45, -2.0], [-0.45, 0.0], [-0.2, 0.2], [0.05, 0.0], [0.05, -1.0], [0.45, -2.0]])
    way = np.column_stack((plan, [1.2, 0.0, 0.0, 0.0, -0.6, -1.2]))
    np.testing.assert_allclose(follow(way, (-0.3, -1.5, np.pi / 2), two_flights(beyond_m))[-1], way[-1, :2], atol=0.1)


def test_the_robot_does_not_drive_back_for_a_jag_in_its_route():
    """The waypoints in a narrow corridor go back by 15 cm."""
    x = np.arange(-1.0, 4.0, 0.05)
    corridor = np.concatenate([np.stack([x, np.full(len(x), y)], axis=1) for y in (-0.32, 0.32)])
    way = np.array([[0.0, 0.0, 0.0], [1.2, 0.0, 0.0], [1.05, 0.02, 0.0], [3.0, 0.0, 0.0]])
    path = follow(way, (0.0, 0.0, 0.0), corridor)
    assert np.diff(path[:, 0]).min() >= 0.0 and path[-1, 0] > 2.9


@pytest.mark.parametrize("aside_m", [0.15, 0.2, 0.3, 0.4])
def test_the_robot_does_not_go_back_up_the_flight_that_it_came_down(aside_m):
    """The route down the next flight has drifted to the other side of the railing, `aside_m` into the first flight."""
    x = -aside_m
    way = np.array([[-0.45, -2.0, 1.2], [-0.45, 0.4, 0.0], [x, 0.4, 0.0], [x, -1.3, -0.8], [0.45, -2.0, -1.2]])

    def climbed_m(pose):
        above_landing_m = 0.6 * max(-pose.y, 0.0) * (1.0 if pose.x < 0.0 else -1.0)
        return above_landing_m - 1.2

    path = follow(way, (-0.45, -2.0, np.pi / 2), two_flights(0.0), climbed_m)
    np.testing.assert_allclose(path[-1], way[-1, :2], atol=0.1)


@pytest.mark.parametrize("stands_m", [1.0, 1.05])
def test_the_robot_tries_another_detour_where_the_first_one_ends(stands_m):
    """A wall across the route seems to have no end at first; then its end comes into view."""
    controller = Controller(np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]))
    pose = DeadReckoning(0.0, 0.0, 0.0, OdometryConfig(), np.random.default_rng(0))
    for step in range(250):
        y = np.arange(-2.0, 2.0 if step < 50 else 0.6, 0.05)
        wall = np.stack([np.full(len(y), stands_m), y], axis=1)
        controller.see(in_body_frame(wall, pose), pose, 0.0)
        motion = controller.step(pose)
        if motion is None:
            break
        pose.advance(*motion)
    np.testing.assert_allclose([pose.x, pose.y], [3.0, 0.0], atol=0.12)


def test_a_robot_scans_before_each_step(monkeypatch):
    """The estimated pose drifts, in turns on the spot as well, and with it the obstacles of earlier scans."""
    steps, scan, advance = [], RangeScanner.scan, DeadReckoning.advance

    def count_scan(self, yaw):
        steps.append(0)
        return scan(self, yaw)

    def count_motion(self, forward, turn):
        steps[-1] += 1
        advance(self, forward, turn)

    monkeypatch.setattr(RangeScanner, "scan", count_scan)
    monkeypatch.setattr(DeadReckoning, "advance", count_motion)
    result = go(two_rooms(), (1.0, 1.5), (3.0, 1.5), (0.8, 1.5))
    assert result.length_m > 3.0
    assert max(steps) == 1


@pytest.mark.parametrize("degrees", [0.0, 22.5, 45.0])
def test_the_robot_drives_straight_past_what_stands_close_to_its_route_on_both_sides(degrees):
    """Local paths prefer more clearance than the straight line has, and wind between the pieces of furniture."""
    ahead = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    aside = np.array([-ahead[1], ahead[0]])
    side = np.linspace(0.3, 1.0, 15)[:, None] * aside
    pieces = np.concatenate([x * ahead + (-1.0) ** i * side for i, x in enumerate(np.arange(1.0, 5.5, 0.8))])
    controller = Controller(np.append([[0.0, 0.0], 6.0 * ahead], np.zeros((2, 1)), axis=1))
    pose = DeadReckoning(0.0, 0.0, np.radians(degrees), OdometryConfig(), np.random.default_rng(0))
    driven_m = 0.0
    while (motion := controller.step(pose)) is not None:
        pose.advance(*motion)
        hits = in_body_frame(pieces, pose)
        controller.see(hits[np.linalg.norm(hits, axis=1) < 3.0], pose, 0.0)
        assert np.linalg.norm(hits, axis=1).min() > RADIUS_M
        driven_m += motion[0]
    assert 5.9 <= driven_m <= 6.0


@pytest.mark.parametrize("away_m", [0.26, 0.3, 0.6])
def test_no_path_leads_through_a_wall(away_m):
    around = LocalMap(LEAST_M)
    wall = np.stack([np.full(200, away_m), np.linspace(-2.0, 2.0, 200)], axis=1)
    around.add(wall, 0.0, 0.0, 0.0, 0.0)
    assert around.plan_path(np.zeros(2), np.linspace([0.0, 0.0], [HORIZON_M, 0.0], 18))[:, 0].max() < away_m


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_detour_closer_to_the_route_is_taken(side):
    """The other path is no longer than this one, and nothing shows that it is blocked."""
    around, start = LocalMap(LEAST_M), np.zeros(2)
    y = np.arange(-0.6, 0.6, 0.02)
    around.add(np.stack([np.full(len(y), 0.8), y], axis=1), 0.0, 0.0, 0.0, 0.0)
    route = np.concatenate([np.linspace([0.0, 0.0], [0.8, side], 13), np.linspace([0.8, side], [1.6, 0.0], 13)])
    way = around.plan_path(start, route)
    beside = np.abs(way[:, 0] - 0.8) < CELL_M
    assert beside.any() and (side * way[beside, 1] > 0.6).all()


def test_stairs_are_climbed_and_descended_without_a_touch(home):
    line = home.stairs[0].walking_line
    for way, storey in ((line, 1), (line[::-1], 0)):
        result = go(home, *way)
        assert result.touched == ()
        assert result.path[-1, 2] == pytest.approx(home.storeys[storey].floor_m, abs=1e-6)


def test_contacts_do_not_depend_on_the_pose_estimate(home):
    """A robot that is lost by a metre cannot drive through walls: every pose of its path is free of contacts."""
    walkable = Walkable(home)
    a, b = (int(walkable.nodes_in(room.id)[0]) for room in (home.rooms[0], home.rooms[1]))
    result = go(home, *walkable.path(a, b), off=(0.7, -0.7, 0.3), drift=ODOMETRY_PRESETS["degraded"])
    body = Body(home)
    assert not any(body.place(*point) for point in result.path[: len(result.path) - bool(result.touched)])


def test_the_same_seed_is_the_same_drive(home):
    walkable = Walkable(home)
    way = walkable.path(*(int(walkable.nodes_in(room.id)[0]) for room in (home.rooms[0], home.rooms[1])))
    first, again, other = (go(home, *way, drift=ODOMETRY_PRESETS["multicam"], seed=seed).path for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert first.shape != other.shape or not np.array_equal(first, other)


def test_bad_waypoints_and_starts_are_named():
    with pytest.raises(SimError, match="valid: at least one, all finite"):
        go(two_rooms(), (np.nan, 0.0))
    with pytest.raises(SimError, match="nothing to stand on"):
        go(two_rooms(), (-3.0, 1.5), (1.0, 1.5))


@pytest.mark.parametrize("down", [False, True], ids=["up", "down"])
def test_a_robot_rides_a_lift_to_the_other_storey(down):
    house = build_house(variant(sample_house("home", 100, clutter=0.0), climb="lift"))
    line = house.stairs[0].walking_line[:: -1 if down else 1]
    result = go(house, *line)
    assert result.touched == () and house.room_by_id[result.room].storey == (0 if down else 1)
    np.testing.assert_allclose(result.path[-1], line[-1], atol=0.15)


@pytest.mark.parametrize(
    "between", [((0.28, 0.3), (0.72, 0.3)), ((0.42, 0.0), (0.58, 0.5))], ids=["at both ends", "in the middle"]
)
def test_a_robot_rides_to_the_storey_of_the_plan_even_if_parts_of_its_steps_are_walked(between):
    """`between` are waypoints in the lift, each as a share of the rise and a distance aside [m]."""
    house = build_house(variant(sample_house("home", 100, clutter=0.0), climb="lift"))
    line = house.stairs[0].walking_line
    inside = int(np.flatnonzero(np.diff(line[:, 2]) > 2.0)[0])
    foot, head = line[inside], line[inside + 1]
    points = [foot + share * (head - foot) + [aside_m, 0.0, 0.0] for share, aside_m in between]
    result = go(house, *line[: inside + 1], *points, *line[inside + 1 :])
    assert result.touched == () and house.room_by_id[result.room].storey == 1


def test_a_robot_outside_of_a_lift_does_not_rise():
    result = go(two_rooms(), (1.0, 1.5), (3.0, 1.5), (3.0, 1.5, 2.9), (7.0, 1.5, 2.9))
    assert (result.room, result.touched) == ("office", ())
    np.testing.assert_allclose(result.path[-1], (3.0, 1.5, 0.0), atol=0.15)


@pytest.mark.parametrize("away_m", [10_001.0, 1e6, 1e12, 1e150])
def test_a_route_far_beyond_the_house_is_refused_instead_of_driven_for_hours(away_m):
    with pytest.raises(SimError, match=r"^drive: the route is .* m long; valid: up to 10000 m$"):
        go(two_rooms(), (1.0, 1.5), (1.0 + away_m, 1.5))
