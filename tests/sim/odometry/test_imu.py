"""Integrating the noise-free IMU reproduces the trajectory; the noise has the sensor's parameters."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim.errors import SimError
from sim.odometry.imu import GRAVITY_M_S2, TURN_ON, Imu, ImuConfig, ideal_imu, with_noise
from sim.tours.tour import TourConfig, plan_tour
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.walkable import Walkable

RATE_HZ = 200


@pytest.fixture(scope="module", params=["none", "hand-held", "quadruped"])
def motion(request):
    house = build_house(sample_house("uh2-apt", 12))
    config = TourConfig(sway=request.param, pitch_on_stairs=True)
    return plan_tour(house, Walkable(house), np.random.default_rng(0), config).motion


def integrated(imu, T_W_B, velocity):
    """Positions and rotations at every stamp, by cubics through four samples each and two terms of the Magnus expansion."""
    dt = 1.0 / RATE_HZ
    rate = imu.angular_velocity
    turns = Rotation.from_rotvec(dt * step_means(rate) + dt**2 / 12 * np.cross(rate[:-1], rate[1:]))
    rotation = [Rotation.from_matrix(T_W_B[:3, :3])]
    for turn in turns:
        rotation.append(rotation[-1] * turn)
    rotation = Rotation.concatenate(rotation)
    acceleration = rotation.apply(imu.specific_force) - [0.0, 0.0, GRAVITY_M_S2]
    velocity = velocity + dt * summed(step_means(acceleration))
    return T_W_B[:3, 3] + dt * summed(step_means(velocity)), rotation


def step_means(values):
    """Mean values over the steps between samples."""
    ends = [[4, -6, 4, -1] @ values[:4]], [[-1, 4, -6, 4] @ values[-4:]]  # the cubic of the last four samples, extrapolated
    wide = np.concatenate([ends[0], values, ends[1]])
    return (13 * (wide[1:-2] + wide[2:-1]) - wide[:-3] - wide[3:]) / 24


def summed(steps):
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def test_integrating_gives_the_trajectory_back(motion):
    """The error stays below 1 mm and 0.001 degrees over three minutes at 200 Hz."""
    imu = ideal_imu(motion)
    for start in range(0, 3 * 60 * RATE_HZ, 60 * RATE_HZ):
        part = Imu(*(getattr(imu, name)[start : start + 60 * RATE_HZ + 1] for name in vars(imu)))
        truth = motion.poses_at(part.stamps, 1.4)
        position, rotation = integrated(part, truth[0], motion.velocity(part.stamps[:1])[0])
        assert np.linalg.norm(position - truth[:, :3, 3], axis=1).max() < 1e-3
        assert np.rad2deg((rotation.inv() * Rotation.from_matrix(truth[:, :3, :3])).magnitude().max()) < 1e-3


def test_at_rest_it_feels_gravity_only(motion):
    imu = ideal_imu(motion)
    for k in (0, -1):
        np.testing.assert_allclose(imu.specific_force[k], [0.0, 0.0, GRAVITY_M_S2], atol=0.05)
        np.testing.assert_allclose(imu.angular_velocity[k], 0.0, atol=0.01)
    assert len(imu.stamps) == round(motion.duration_s * RATE_HZ) + 1


@pytest.mark.parametrize("rate_hz", [100.0, 400.0])
def test_noise_has_the_sensors_densities_whatever_the_rate(rate_hz, rng):
    still, config = silence(int(600 * rate_hz), rate_hz), ImuConfig(rate_hz)
    imu = with_noise(still, config, rng)
    for measured, bias, noise, walk in (
        (imu.angular_velocity, imu.gyroscope_bias, config.gyroscope_noise, config.gyroscope_walk),
        (imu.specific_force, imu.accelerometer_bias, config.accelerometer_noise, config.accelerometer_walk),
    ):
        assert np.std(measured - bias) == pytest.approx(noise * np.sqrt(rate_hz), rel=0.01)
        assert np.std(bias[int(rate_hz) :] - bias[: -int(rate_hz)]) == pytest.approx(walk, rel=0.1)  # over 1 s
        np.testing.assert_array_equal(bias[0], 0.0)


def test_the_turn_on_bias_is_recovered_at_standstill():
    """The mean over a minute at rest is the stated bias; the remaining noise is that of the sensor without the bias."""
    still, quiet = silence(60 * RATE_HZ, 200.0), ImuConfig(gyroscope_walk=0.0, accelerometer_walk=0.0)
    biased = replace(quiet, gyroscope_turn_on=TURN_ON[0], accelerometer_turn_on=TURN_ON[1])
    plain, imu = (with_noise(still, config, np.random.default_rng(3)) for config in (quiet, biased))
    for measured, bias, without, noise, turn_on in (
        (imu.angular_velocity, imu.gyroscope_bias, plain.angular_velocity, quiet.gyroscope_noise, TURN_ON[0]),
        (imu.specific_force, imu.accelerometer_bias, plain.specific_force, quiet.accelerometer_noise, TURN_ON[1]),
    ):
        assert (bias == bias[0]).all() and bias[0].all() and np.abs(bias).max() < 4 * turn_on
        np.testing.assert_allclose(measured.mean(axis=0), bias[0], atol=4 * noise / np.sqrt(60))
        np.testing.assert_allclose(measured - bias, without, atol=1e-12)


def test_turn_on_biases_have_the_stated_deviations():
    config, moment = ImuConfig(gyroscope_turn_on=0.01, accelerometer_turn_on=0.2), silence(2, 200.0)
    drawn = [with_noise(moment, config, np.random.default_rng(seed)) for seed in range(1000)]
    assert np.std([imu.gyroscope_bias[0] for imu in drawn]) == pytest.approx(0.01, rel=0.05)
    assert np.std([imu.accelerometer_bias[0] for imu in drawn]) == pytest.approx(0.2, rel=0.05)


def test_same_seed_same_noise():
    still = silence(1000, 200.0)
    first, again, other = (with_noise(still, ImuConfig(), np.random.default_rng(seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.specific_force, again.specific_force)
    assert not np.allclose(first.specific_force, other.specific_force)


def test_bad_values_name_what_is_valid(rng):
    with pytest.raises(SimError, match=r"gyroscope_walk is -1.*valid"):
        ImuConfig(gyroscope_walk=-1.0)
    with pytest.raises(SimError, match=r"rate_hz is 0.*valid: > 0 Hz"):
        ImuConfig(rate_hz=0.0)
    with pytest.raises(SimError, match="not at 100 Hz; valid: measurements at the rate in the config"):
        with_noise(silence(10, 200.0), ImuConfig(100.0), rng)


def silence(samples, rate_hz):
    return Imu(np.arange(samples) / rate_hz, *(np.zeros((samples, 3)) for _ in range(4)))
