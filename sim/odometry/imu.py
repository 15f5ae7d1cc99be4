"""A simulated inertial sensor: `ideal_imu` computes error-free measurements, and `with_noise` adds bias and noise.

The default noise parameters are those of the sensor ADIS16448 in the calibration files of EuRoC.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt
from jaxtyping import Float64

from lexis.settings import Settings
from sim.errors import SimError
from sim.tours.motion import Motion

GRAVITY_M_S2 = 9.81
TURN_ON = (np.radians(0.5), 20e-3 * GRAVITY_M_S2)
"""Usual standard deviations of the initial biases of industrial MEMS sensors, 0.5 °/s and 20 mg [rad/s, m/s²]."""


@dataclass(frozen=True)
class ImuConfig(Settings, place="imu", error=SimError):
    """Rate of an inertial sensor, and densities of its noise in continuous time."""

    rate_hz: Annotated[float, Gt(0)] = 200.0
    """Measurements per second [Hz]."""
    gyroscope_noise: Annotated[float, Ge(0)] = 1.6968e-4
    """Density of the gyroscope's white noise [rad/s/√Hz]."""
    gyroscope_walk: Annotated[float, Ge(0)] = 1.9393e-5
    """Density of the noise that drives the random walk of the gyroscope's bias [rad/s²/√Hz]."""
    accelerometer_noise: Annotated[float, Ge(0)] = 2.0e-3
    """Density of the accelerometer's white noise [m/s²/√Hz]."""
    accelerometer_walk: Annotated[float, Ge(0)] = 3.0e-3
    """Density of the noise that drives the random walk of the accelerometer's bias [m/s³/√Hz]."""
    gyroscope_turn_on: Annotated[float, Ge(0)] = 0.0
    """Standard deviation, per axis, of the gyroscope's bias when the sensor starts [rad/s]."""
    accelerometer_turn_on: Annotated[float, Ge(0)] = 0.0
    """Standard deviation, per axis, of the accelerometer's bias when the sensor starts [m/s²]."""


@dataclass(frozen=True, eq=False)
class Imu:
    """Measurements of an inertial sensor in the body frame B, and its biases."""

    stamps: Float64[np.ndarray, "n"]
    """Times of the measurements, from the start of the motion [s]."""
    angular_velocity: Float64[np.ndarray, "n 3"]
    """Angular velocity of B relative to W, expressed in B [rad/s]."""
    specific_force: Float64[np.ndarray, "n 3"]
    """Acceleration of B minus gravity, expressed in B [m/s²]: +9.81 along z if B is level and at rest."""
    gyroscope_bias: Float64[np.ndarray, "n 3"]
    """Bias that `angular_velocity` contains [rad/s]."""
    accelerometer_bias: Float64[np.ndarray, "n 3"]
    """Bias that `specific_force` contains [m/s²]."""


def ideal_imu(motion: Motion, rate_hz: float = 200.0) -> Imu:
    """Compute error-free measurements from the start to the end of a motion, from the motion's exact derivatives.

    If measurements at 200 Hz are integrated to fourth order (cubics through four samples, two terms of Magnus's series for
    the rotation), the result is within 0.2 mm of the trajectory after a minute, with or without sway. With the trapezoidal
    rule, the error is 2 to 7 cm.
    """
    t = np.arange(round(motion.duration_s * rate_hz) + 1) / rate_hz
    force = motion.acceleration(t) + [0.0, 0.0, GRAVITY_M_S2]
    specific_force = np.einsum("nji,nj->ni", motion.rotation(t), force)
    return Imu(t, motion.angular_velocity(t), specific_force, np.zeros((len(t), 3)), np.zeros((len(t), 3)))


def with_noise(imu: Imu, config: ImuConfig, rng: np.random.Generator) -> Imu:
    """Add white noise and biases to measurements.

    Each bias starts with a random value, whose standard deviation is the turn-on value in `config`, and then drifts as a
    random walk. Raises `SimError` if the measurements do not have the rate in `config`.
    """
    step = 1.0 / config.rate_hz
    if not np.allclose(np.diff(imu.stamps), step, rtol=0.0, atol=1e-9):
        raise SimError(f"imu: measurements are not at {config.rate_hz:g} Hz; valid: measurements at the rate in the config")
    shape = (2, len(imu.stamps), 3)
    noise = rng.standard_normal(shape) * np.sqrt(config.rate_hz)
    walk = np.cumsum(rng.standard_normal(shape) * np.sqrt(step), axis=1)
    turn_on = rng.standard_normal((2, 3))  # drawn last, so that initial biases do not change the noise
    gyroscope_bias = config.gyroscope_walk * (walk[0] - walk[0, 0]) + config.gyroscope_turn_on * turn_on[0]
    accelerometer_bias = config.accelerometer_walk * (walk[1] - walk[1, 0]) + config.accelerometer_turn_on * turn_on[1]
    return Imu(
        imu.stamps,
        imu.angular_velocity + config.gyroscope_noise * noise[0] + gyroscope_bias,
        imu.specific_force + config.accelerometer_noise * noise[1] + accelerometer_bias,
        gyroscope_bias,
        accelerometer_bias,
    )
