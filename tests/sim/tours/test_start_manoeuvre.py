"""The start manoeuvre excites an IMU on the spot, keeps the walker's limits, and leaves the walk after it unchanged."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from sim.odometry.imu import ideal_imu
from sim.tours.tour import TourConfig, plan_tour
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.walkable import Walkable

CONFIG = TourConfig(start_manoeuvre=True)
RADIUS_M = 0.25


@pytest.fixture(scope="module", params=[("home", 11), ("uh2-apt", 12)], ids=lambda p: p[0])
def house(request):
    return build_house(sample_house(*request.param))


@pytest.fixture(scope="module")
def plan(house):
    walkable = Walkable(house, RADIUS_M)
    return lambda config: plan_tour(house, walkable, np.random.default_rng(0), config).motion


@pytest.fixture(scope="module")
def motion(plan):
    return plan(CONFIG)


@pytest.fixture(scope="module")
def walk(plan):
    return plan(TourConfig())


def lead(motion, walk):
    """Duration of the manoeuvre [s]."""
    return motion.duration_s - walk.duration_s


def norm(values):
    return np.linalg.norm(values, axis=1)


def test_the_walk_follows_unchanged(motion, walk):
    t = np.arange(0.0, walk.duration_s, 0.05)
    start = lead(motion, walk)
    assert 4.0 < start < 7.0
    np.testing.assert_allclose(motion.poses_at(start + t, 1.4), walk.poses_at(t, 1.4), atol=1e-9)
    np.testing.assert_allclose(motion.acceleration(start + t), walk.acceleration(t), atol=1e-6)


@pytest.mark.parametrize(("rate_hz", "share"), [(10, 0.6), (20, 0.5), (30, 0.3)])
def test_the_mean_acceleration_changes_from_frame_to_frame(rate_hz, share, motion, walk):
    """It changes by at least 0.5 m/s² in many frames; ORB-SLAM3 needs one such frame to initialise its IMU."""
    imu = ideal_imu(motion, 600.0)
    frames = round(lead(motion, walk) * rate_hz)
    per_frame = 600 // rate_hz
    means = imu.specific_force[: frames * per_frame].reshape(frames, per_frame, 3).mean(axis=1)
    assert (norm(np.diff(means, axis=0)) >= 0.5).mean() > share


def test_the_manoeuvre_turns_and_moves_the_body_only_a_little(motion, walk):
    t = np.arange(0.0, lead(motion, walk), 0.005)
    away = norm(motion.position(t) - motion.position(np.zeros(1)))
    assert 0.02 < away.max() < 0.04
    angles = motion.attitude(t) - motion.attitude(np.zeros(1))
    assert (np.ptp(angles, axis=0)[1:] > [0.08, 0.2]).all() and (np.abs(angles) < 0.2).all()
    assert away[0] == 0.0 and norm(motion.velocity(t[:1]))[0] == 0.0


def test_the_body_keeps_clear_of_everything_solid(house, motion, walk):
    """The body keeps its radius away from everything solid, minus the few centimetres by which it sways."""
    feet = motion.position(np.arange(0.0, lead(motion, walk), 0.02))
    solids = [(w.footprint, w.bottom_m, w.top_m) for w in house.walls]
    solids += [(f.footprint, f.position[2], f.position[2] + f.size[2]) for f in house.furniture if f.solid]
    solids += [(leaf.footprint, leaf.position[2], leaf.position[2] + leaf.size[2]) for leaf in house.leaves]
    beside = [shape for shape, low, high in solids if low < feet[0, 2] + 1.9 and high > feet[0, 2] + 0.05]
    assert shapely.distance(shapely.points(feet[:, :2])[:, None], beside).min() > RADIUS_M - 0.04


@pytest.mark.parametrize("weaker", [1.0, 0.4])
def test_the_limits_of_the_walker_are_kept(weaker, plan):
    full = TourConfig()
    config = replace(
        CONFIG,
        speed_m_s=weaker * full.speed_m_s,
        acceleration_m_s2=weaker * full.acceleration_m_s2,
        turn_rate_rad_s=weaker * full.turn_rate_rad_s,
    )
    motion = plan(config)
    t = np.arange(0.0, 8.0, 1e-3)
    limits = config.limits
    assert norm(motion.velocity(t)).max() <= limits.speed_m_s
    assert norm(motion.acceleration(t)).max() <= limits.acceleration_m_s2
    assert norm(motion.attitude(t, 1)).max() <= limits.turn_rate_rad_s
    assert norm(motion.attitude(t, 2)).max() <= limits.turn_acceleration_rad_s2


@pytest.mark.parametrize("frequency_hz", [50.0])
def test_derivatives_are_continuous_where_the_walk_begins(frequency_hz, motion, walk):
    """The acceleration agrees with the positions, also where the manoeuvre ends and the walk begins."""
    t = lead(motion, walk) + np.arange(-1.0, 1.0, 1.0 / frequency_hz)
    h = 1e-3
    numeric = (motion.position(t + h) - 2 * motion.position(t) + motion.position(t - h)) / h**2
    np.testing.assert_allclose(motion.acceleration(t), numeric, atol=2e-3)
