"""The derivatives of a motion agree with its position and attitude, and its speed keeps every limit."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim.errors import SimError
from sim.tours.motion import Motion
from sim.tours.pace import Limits, paced
from sim.tours.sway import draw_sway

LIMITS = Limits()
H = 1e-4


def walked(points, kind="none", limits=LIMITS, seed=0):
    """A motion along a polyline, facing ahead."""
    line = np.array(points, dtype=np.float64)
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.linspace(0.0, s[-1], round(s[-1] / 0.01) + 1)
    line = np.stack([np.interp(at, s, axis) for axis in line.T], axis=-1)
    yaw = np.unwrap(np.arctan2(*np.diff(line[:, :2], axis=0).T[::-1]))
    smooth = np.convolve(np.pad(yaw, (20, 21), mode="edge"), np.full(41, 1 / 41), mode="valid")
    view = np.column_stack([np.append(smooth, smooth[-1])[: len(line)], 0.2 * np.sin(at)])
    return paced(line, view, limits, draw_sway(kind, np.random.default_rng(seed)))


@pytest.fixture(scope="module", params=["none", "hand-held", "quadruped"])
def motion(request):
    return walked([[0, 0, 0], [3, 0, 0], [3, 2, 0.5], [1, 2, 0.5]], request.param)


@pytest.fixture(scope="module")
def times(motion):
    return np.random.default_rng(1).uniform(0.01, motion.duration_s - 0.01, 500)


def difference(f, t):
    return (f(t + H) - f(t - H)) / (2 * H)


def test_each_derivative_is_that_of_the_one_before(motion, times):
    np.testing.assert_allclose(motion.velocity(times), difference(motion.position, times), atol=1e-6)
    np.testing.assert_allclose(motion.acceleration(times), difference(motion.velocity, times), atol=1e-5)
    np.testing.assert_allclose(motion.yaw_rate(times), difference(motion.yaw, times), atol=1e-6)
    for order in (1, 2):
        slope = difference(lambda t, order=order: motion.attitude(t, order - 1), times)
        np.testing.assert_allclose(motion.attitude(times, order), slope, atol=1e-5)


def test_angular_velocity_turns_the_body(motion, times):
    before, after = (Rotation.from_matrix(motion.rotation(t)) for t in (times - H, times + H))
    np.testing.assert_allclose(motion.angular_velocity(times), (before.inv() * after).as_rotvec() / (2 * H), atol=1e-5)


def test_attitude_is_that_of_the_rotation(motion, times):
    yaw, pitch, roll = Rotation.from_matrix(motion.rotation(times)).as_euler("ZYX").T
    np.testing.assert_allclose(motion.attitude(times)[:, :2], np.column_stack([roll, pitch]), atol=1e-9)
    np.testing.assert_allclose(np.cos(motion.yaw(times) - yaw), 1.0)


def test_acceleration_has_no_jumps(motion):
    """Halving the step halves the largest change: the second derivative is continuous and has a bounded slope."""
    wide, narrow = (
        np.abs(np.diff(motion.acceleration(np.arange(0.0, motion.duration_s, step)), axis=0)).max() for step in (2e-3, 1e-3)
    )
    assert narrow == pytest.approx(wide / 2, rel=0.05)


def test_it_begins_and_ends_at_rest_and_stays_there(motion):
    ends = np.array([0.0, motion.duration_s])
    for derivative in (motion.velocity, motion.acceleration, motion.angular_velocity):
        np.testing.assert_allclose(derivative(ends), 0.0, atol=0.02)
    outside = motion.poses_at(np.array([-5.0, motion.duration_s + 5.0]), 1.0)
    np.testing.assert_allclose(outside, motion.poses_at(ends, 1.0), atol=1e-6)


@pytest.mark.parametrize(
    "points",
    [
        [[0, 0, 0], [5, 0, 0]],
        [[0, 0, 0], [2, 0, 0], [2, 2, 0]],
        [[0, 0, 0], [2.005, 0, 0], [0, 0, 0]],  # it turns between two points
        [[0, 0, 0], [2, 0, 0], [4, 0, 1.4], [6, 0, 1.4]],
        [[0, 0, 0], [0.05, 0, 0]],
    ],
    ids=["straight", "corner", "about-turn", "stairs", "step"],
)
@pytest.mark.parametrize("limits", [LIMITS, Limits(1.5, 0.5, 3.0, 10.0)], ids=["walk", "sluggish"])
def test_every_limit_is_kept_at_every_time(points, limits):
    motion = walked(points, limits=limits)
    t = np.arange(0.0, motion.duration_s, 1e-3)
    attitude = motion.attitude(t, 1), motion.attitude(t, 2)
    for value, limit in (
        (motion.velocity(t), limits.speed_m_s),
        (motion.acceleration(t), limits.acceleration_m_s2),
        (attitude[0], limits.turn_rate_rad_s),
        (attitude[1], limits.turn_acceleration_rad_s2),
    ):
        assert np.linalg.norm(value, axis=1).max() <= limit * (1 + 1e-9)
    np.testing.assert_allclose(motion.position(np.array([0.0, motion.duration_s])), [points[0], points[-1]], atol=1e-9)


def test_a_straight_path_is_walked_nearly_as_fast_as_possible():
    """Smoothing may cost half a second at each end, and the speed changes at 70 % of the allowed acceleration."""
    motion = walked([[0, 0, 0], [7, 0, 0]])
    fastest = 7.0 / LIMITS.speed_m_s + LIMITS.speed_m_s / LIMITS.acceleration_m_s2
    assert fastest <= motion.duration_s <= fastest + 1.0


def test_sway_is_as_large_as_a_walkers_and_stands_still_with_it():
    for kind in ("hand-held", "quadruped"):
        motion = walked([[0, 0, 0], [7, 0, 0]], kind)
        still = Motion(motion.controls, motion.knot_s)
        t = np.linspace(3.0, 8.0, 1000)
        off = np.linalg.norm(motion.position(t) - still.position(t), axis=1)
        tilt = np.rad2deg(np.abs(motion.attitude(t)[:, 0]).max())
        assert 0.004 < off.max() < 0.03 and 0.3 < tilt < 3.0
        np.testing.assert_allclose(motion.position(np.zeros(1)), still.position(np.zeros(1)), atol=1e-6)
    with pytest.raises(SimError, match=r"sway 'drunken' is unknown; valid: none, hand-held, quadruped"):
        draw_sway("drunken", np.random.default_rng(0))
