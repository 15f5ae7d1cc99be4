from dataclasses import replace

import numpy as np
import pytest

from lexis.maths.se3 import between, compose_covariance, inverse, log, rotation_angle
from sim.errors import SimError
from sim.odometry.config import ODOMETRY_PRESETS, OdometryConfig
from sim.odometry.simulation import simulate_odometry, tour_odometry
from sim.tours.tour import TourConfig, plan_tour
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.walkable import Walkable

DRIFTING = [name for name in ODOMETRY_PRESETS if name != "perfect"]


def loops(length_m, rate_hz=10.0):
    """A walk round a rectangle with a ramp, at 0.7 m/s."""
    t = np.arange(0.0, length_m / 0.7, 1.0 / rate_hz)
    yaw = 0.25 * t
    T = np.tile(np.eye(4), (len(t), 1, 1))
    T[:, 0, 0] = T[:, 1, 1] = np.cos(yaw)
    T[:, 1, 0] = np.sin(yaw)
    T[:, 0, 1] = -T[:, 1, 0]
    T[:, :3, 3] = np.stack([2.7 * np.sin(yaw), 2.7 * (1.0 - np.cos(yaw)), 0.2 * np.sin(0.1 * t)], axis=-1)
    return T, t


def increment_errors(T_W_B, odometry):
    return log(inverse(between(T_W_B[:-1], T_W_B[1:])) @ between(odometry.T_O_B[:-1], odometry.T_O_B[1:]))


def final_errors(config, length_m, runs, rate_hz=2.0):
    """Position and yaw errors at the end of many runs."""
    T, t = loops(length_m, rate_hz)
    ends = np.array([simulate_odometry(T, t, config, np.random.default_rng(seed)).T_O_B[-1] for seed in range(runs)])
    turn = ends[:, :3, :3] @ T[-1, :3, :3].T
    return np.linalg.norm(ends[:, :3, 3] - T[-1, :3, 3], axis=1), np.arctan2(turn[:, 1, 0], turn[:, 0, 0])


def test_perfect_is_the_truth(rng):
    T, t = loops(50.0)
    odometry = simulate_odometry(T, t, ODOMETRY_PRESETS["perfect"], rng)
    np.testing.assert_array_equal(odometry.T_O_B, T)
    assert (np.linalg.eigvalsh(odometry.increment_covariance) > 0.0).all()


@pytest.mark.parametrize("preset", DRIFTING)
def test_starts_at_the_truth_and_increments_lead_from_pose_to_pose(preset, rng):
    T, t = loops(50.0)
    poses = simulate_odometry(T, t, ODOMETRY_PRESETS[preset], rng).T_O_B
    np.testing.assert_array_equal(poses[0], T[0])
    composed = poses[0]
    for step in between(poses[:-1], poses[1:]):
        composed = composed @ step
    np.testing.assert_allclose(composed, poses[-1], atol=1e-9)


def nees(error, covariance):
    """Normalised estimation error squared (NEES), per degree of freedom."""
    return np.einsum("...i,...ij,...j", error, np.linalg.inv(covariance), error) / 6.0


@pytest.mark.parametrize("overconfidence", [1.0, 20.0, 200.0])
@pytest.mark.parametrize("preset", DRIFTING)
def test_nees_of_increments_is_the_overconfidence(preset, overconfidence):
    T, t = loops(60.0)
    config = replace(ODOMETRY_PRESETS[preset], overconfidence=overconfidence)
    runs = [simulate_odometry(T, t, config, np.random.default_rng(seed)) for seed in range(30)]
    measured = [nees(increment_errors(T, run), run.increment_covariance[1:]) for run in runs]
    assert np.mean(measured) == pytest.approx(overconfidence, rel=0.1)


@pytest.mark.parametrize(("preset", "low", "high"), [("multicam", 0.7, 1.2), ("degraded", 0.7, 1.3), ("openvins", 0.4, 0.9)])
def test_nees_of_composed_increments_is_as_documented(preset, low, high):
    T, t = loops(24.0, 2.0)
    measured = []
    for seed in range(80):
        run = simulate_odometry(T, t, ODOMETRY_PRESETS[preset], np.random.default_rng(seed))
        covariance = np.zeros((6, 6))
        for step, own in zip(between(run.T_O_B[:-1], run.T_O_B[1:]), run.increment_covariance[1:], strict=True):
            covariance = compose_covariance(covariance, step, own)
        error = log(inverse(between(T[0], T[-1])) @ between(run.T_O_B[0], run.T_O_B[-1]))
        measured.append(nees(error, covariance))
    assert low < np.mean(measured) < high


def test_overconfidence_leaves_the_drift_alone():
    T, t = loops(20.0)
    configs = (ODOMETRY_PRESETS["mono"], replace(ODOMETRY_PRESETS["mono"], overconfidence=100.0))
    honest, bold = (simulate_odometry(T, t, config, np.random.default_rng(0)) for config in configs)
    np.testing.assert_array_equal(honest.T_O_B, bold.T_O_B)


def test_random_walk_grows_with_the_root_of_the_way_and_biases_with_the_way():
    walk = OdometryConfig(position_walk_m=0.02, yaw_walk_rad=0.003)
    biased = OdometryConfig(scale_error=0.01, yaw_bias_rad_m=0.001, bias_correlation_m=1e6)
    for config, exponent in ((walk, 0.5), (biased, 1.0)):
        (_, near), (_, far) = (final_errors(config, length, 120) for length in (20.0, 180.0))
        assert np.log(np.std(far) / np.std(near)) / np.log(9.0) == pytest.approx(exponent, abs=0.1)
    (near, _), (far, _) = (final_errors(OdometryConfig(position_walk_m=0.02), length, 120) for length in (20.0, 180.0))
    assert np.sqrt(np.mean(far**2) / np.mean(near**2)) == pytest.approx(3.0, rel=0.15)


def test_gravity_bounds_roll_and_pitch_but_not_yaw():
    T, t = loops(400.0)
    config = ODOMETRY_PRESETS["degraded"]
    poses = np.array([simulate_odometry(T, t, config, np.random.default_rng(seed)).T_O_B for seed in range(8)])
    tilt = np.arccos(np.clip(poses[:, :, 2, 2], -1.0, 1.0))
    late = tilt[:, len(t) // 10 :]
    assert np.sqrt(np.mean(late**2)) == pytest.approx(np.sqrt(2.0) * config.tilt_rad, rel=0.1)
    assert tilt.max() < 6.0 * config.tilt_rad
    turn = poses[:, -1, :3, :3] @ T[-1, :3, :3].T
    assert np.std(np.arctan2(turn[:, 1, 0], turn[:, 0, 0])) > 10.0 * config.tilt_rad


def test_drift_does_not_depend_on_the_frame_rate():
    config = ODOMETRY_PRESETS["multicam"]
    (slow_m, slow_rad), (fast_m, fast_rad) = (final_errors(config, 60.0, 120, rate) for rate in (2.0, 16.0))
    assert np.mean(fast_m) == pytest.approx(np.mean(slow_m), rel=0.2)
    assert np.std(fast_rad) == pytest.approx(np.std(slow_rad), rel=0.2)


def test_biases_are_forgotten_over_their_correlation_length():
    config = OdometryConfig(yaw_bias_rad_m=0.001, bias_correlation_m=10.0)
    for length, exponent in ((1.0, 1.0), (200.0, 0.5)):
        (_, near), (_, far) = (final_errors(config, length * k, 150, 10.0 if length < 2 else 2.0) for k in (1.0, 2.0))
        assert np.log2(np.std(far) / np.std(near)) == pytest.approx(exponent, abs=0.15)


def test_what_is_reported_is_a_part_of_what_is_integrated():
    T, t = loops(20.0, 100.0)
    frames = np.arange(0, len(t), 10)
    whole = simulate_odometry(T, t, ODOMETRY_PRESETS["mono"], np.random.default_rng(3))
    part = simulate_odometry(T, t, ODOMETRY_PRESETS["mono"], np.random.default_rng(3), frames)
    np.testing.assert_array_equal(part.T_O_B, whole.T_O_B[frames])
    variance = whole.increment_covariance[1:, 5, 5].cumsum()[frames[1:] - 1]
    np.testing.assert_allclose(part.increment_covariance[1:, 5, 5].cumsum(), variance, rtol=0.05)


def test_tours_are_integrated_at_100_hz_or_more(tours, monkeypatch):
    seen = []
    poses_at = type(tours[0].motion).poses_at
    record = lambda motion, stamps, height: seen.append(stamps) or poses_at(motion, stamps, height)  # noqa: E731
    monkeypatch.setattr(type(tours[0].motion), "poses_at", record)
    for rate in (100.0, 333.0):
        config = replace(ODOMETRY_PRESETS["perfect"], rate_hz=rate)
        run = tour_odometry(tours[0], config, np.random.default_rng(0))
        np.testing.assert_allclose(run.T_O_B, tours[0].T_W_B, atol=1e-9)
        assert np.diff(seen[-1]).max() <= 1.0 / rate + 1e-9


def test_same_seed_same_drift():
    T, t = loops(30.0)
    first, again, other = (
        simulate_odometry(T, t, ODOMETRY_PRESETS["mono"], np.random.default_rng(seed)) for seed in (4, 4, 5)
    )
    np.testing.assert_array_equal(first.T_O_B, again.T_O_B)
    assert not np.allclose(first.T_O_B, other.T_O_B)


DOCUMENTED = {
    "multicam": ((0.14, 0.63), (0.26, 1.03), (0.37, 1.43)),
    "mono": ((0.21, 1.11), (0.38, 1.76), (0.54, 2.41)),
    "degraded": ((0.26, 2.36), (0.54, 4.15), (0.78, 6.10)),
    "openvins": ((0.07, 0.85), (0.13, 1.06), (0.19, 1.26)),
}


@pytest.fixture(scope="module")
def tours():
    houses = [build_house(sample_house("home", seed).model_copy(update={"clutter": 0.0})) for seed in (11, 12)]
    return [plan_tour(h, Walkable(h), np.random.default_rng(0), TourConfig(length_m=100.0)) for h in houses]


@pytest.mark.parametrize("preset", DRIFTING)
def test_presets_drift_as_documented(preset, tours):
    measured = []
    for tour in tours:
        for seed in range(20):
            drifted = tour_odometry(tour, ODOMETRY_PRESETS[preset], np.random.default_rng(seed)).T_O_B
            measured.append([rpe(tour.T_W_B, drifted, length) for length in (8.0, 24.0, 48.0)])
    found = np.mean(measured, axis=0)
    assert preset in DOCUMENTED, f"no row for {preset}; measured: {found.round(2).tolist()}"
    np.testing.assert_allclose(found, DOCUMENTED[preset], rtol=0.15)


def test_perfect_does_not_drift_along_a_tour(tours):
    drifted = tour_odometry(tours[0], ODOMETRY_PRESETS["perfect"], np.random.default_rng(0)).T_O_B
    assert rpe(tours[0].T_W_B, drifted, 48.0) == pytest.approx((0.0, 0.0), abs=1e-5)


def rpe(T_W_B, T_O_B, length_m):
    """Mean relative pose error over path segments of a given length: [m], [deg]."""
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(T_W_B[:, :3, 3], axis=0), axis=1)))
    start = np.arange(0, np.searchsorted(s, s[-1] - length_m), 10)
    end = np.searchsorted(s, s[start] + length_m)
    error = inverse(between(T_W_B[start], T_W_B[end])) @ between(T_O_B[start], T_O_B[end])
    return np.linalg.norm(error[:, :3, 3], axis=1).mean(), np.rad2deg(rotation_angle(error)).mean()


def test_bad_arguments_name_what_is_valid(rng):
    T, t = loops(5.0)
    with pytest.raises(SimError, match=r"yaw_walk_rad is -1.*valid"):
        OdometryConfig(yaw_walk_rad=-1.0)
    with pytest.raises(SimError, match=r"overconfidence is 0.5; valid: >= 1"):
        OdometryConfig(overconfidence=0.5)
    with pytest.raises(SimError, match=r"rate_hz is 50.*>= 100 Hz"):
        OdometryConfig(rate_hz=50.0)
    with pytest.raises(SimError, match=r"reported indices are .*; valid: ascending from 0"):
        simulate_odometry(T, t, OdometryConfig(), rng, np.array([0, 5, 4]))
    with pytest.raises(SimError, match="stamps do not ascend at index 3; valid"):
        simulate_odometry(T, np.where(np.arange(len(t)) == 3, -1.0, t), OdometryConfig(), rng)
    with pytest.raises(SimError, match="pose 2 is not a rigid motion"):
        simulate_odometry(np.where(np.arange(len(T))[:, None, None] == 2, 2.0 * T, T), t, OdometryConfig(), rng)
