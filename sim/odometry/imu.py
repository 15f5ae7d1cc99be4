"""`ideal_imu` and `corrupted`: what an inertial sensor in the body frame measures along a motion, and with what errors.

The noise is EuRoC's: an ADIS16448 by the densities of its data sheet as the dataset's calibration files state them.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from sim.errors import SimError
from sim.tours.motion import Motion

GRAVITY_M_S2 = 9.81
TURN_ON = (np.radians(0.5), 20e-3 * GRAVITY_M_S2)
"""Standard deviations of turn-on biases that are usual in industrial MEMS sensors, 0.5 °/s and 20 mg [rad/s, m/s²]."""


@dataclass(frozen=True)
class ImuConfig:
    """Rate and continuous-time noise. Raises `SimError` for values that are negative or not finite, or a rate of 0."""

    rate_hz: float = 200.0
    gyroscope_noise: float = 1.6968e-4
    """Density of white noise [rad/s/√Hz]."""
    gyroscope_walk: float = 1.9393e-5
    """Of the bias [rad/s²/√Hz]."""
    accelerometer_noise: float = 2.0e-3
    """[m/s²/√Hz]"""
    accelerometer_walk: float = 3.0e-3
    """[m/s³/√Hz]"""
    gyroscope_turn_on: float = 0.0
    """Standard deviation of the bias, per axis, with which the sensor starts [rad/s]."""
    accelerometer_turn_on: float = 0.0
    """[m/s²]"""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 <= value < np.inf:
                raise SimError(f"imu: {name} is {value}; valid: not negative, finite")
        if self.rate_hz == 0.0:
            raise SimError("imu: rate_hz is 0; valid: positive")


@dataclass(frozen=True, eq=False)
class Imu:
    """Measurements in B."""

    stamps: Float64[np.ndarray, "n"]
    """[s]"""
    angular_velocity: Float64[np.ndarray, "n 3"]
    """[rad/s]"""
    specific_force: Float64[np.ndarray, "n 3"]
    """Acceleration less gravity: +9.81 along z at rest [m/s²]."""
    gyroscope_bias: Float64[np.ndarray, "n 3"]
    """That is contained in the measurements."""
    accelerometer_bias: Float64[np.ndarray, "n 3"]


def ideal_imu(motion: Motion, rate_hz: float = 200.0) -> Imu:
    """Measurements without errors, from the motion's exact derivatives, from its start to its end.

    Integrated at 200 Hz to fourth order (cubics through four samples, two terms of Magnus's series for the rotation) they
    give a minute of the trajectory back within 0.2 mm, sway or not; the trapezoidal rule gives 2-7 cm.
    """
    t = np.arange(round(motion.duration_s * rate_hz) + 1) / rate_hz
    force = motion.acceleration(t) + [0.0, 0.0, GRAVITY_M_S2]
    specific_force = np.einsum("nji,nj->ni", motion.rotation(t), force)
    return Imu(t, motion.angular_velocity(t), specific_force, np.zeros((len(t), 3)), np.zeros((len(t), 3)))


def corrupted(imu: Imu, config: ImuConfig, rng: np.random.Generator) -> Imu:
    """The measurements with white noise and biases, which are drawn once by the turn-on deviations and walk from there.

    Raises `SimError` where the measurements are not at the config's rate.
    """
    step = 1.0 / config.rate_hz
    if not np.allclose(np.diff(imu.stamps), step, rtol=0.0, atol=1e-9):
        raise SimError(f"imu: measurements are not at the config's {config.rate_hz:g} Hz")
    shape = (2, len(imu.stamps), 3)
    noise = rng.standard_normal(shape) * np.sqrt(config.rate_hz)
    walk = np.cumsum(rng.standard_normal(shape) * np.sqrt(step), axis=1)
    turn_on = rng.standard_normal((2, 3))  # drawn last: the noise is the same with and without
    gyroscope_bias = config.gyroscope_walk * (walk[0] - walk[0, 0]) + config.gyroscope_turn_on * turn_on[0]
    accelerometer_bias = config.accelerometer_walk * (walk[1] - walk[1, 0]) + config.accelerometer_turn_on * turn_on[1]
    return Imu(
        imu.stamps,
        imu.angular_velocity + config.gyroscope_noise * noise[0] + gyroscope_bias,
        imu.specific_force + config.accelerometer_noise * noise[1] + accelerometer_bias,
        gyroscope_bias,
        accelerometer_bias,
    )
