"""`DeadReckoning`: a driving robot's estimate of its pose, which drifts like the odometry of `sim.odometry`."""

import math

import numpy as np

from sim.odometry.config import OdometryConfig
from sim.odometry.simulation import METRES_PER_RADIAN

_BLOCK = 512
"""Number of normally distributed numbers that are drawn at a time, for speed."""


class DeadReckoning:
    """An estimated pose (x, y, yaw) in the plane, to which increments of the true motion are added with errors.

    The errors follow the model of `simulate_odometry` in the plane, but the trajectory need not be known in advance. The
    error of scale and the biases are drawn at random for each object.
    """

    def __init__(self, x: float, y: float, yaw: float, config: OdometryConfig, rng: np.random.Generator) -> None:
        self.x, self.y, self.yaw = x, y, yaw
        self._config, self._rng = config, rng
        self._scale = 1.0 + float(rng.normal(0.0, config.scale_error))
        self._bias: list[float] = rng.standard_normal(3).tolist()
        self._draws: list[float] = []

    def advance(self, forward: float, turn: float) -> None:
        """Add a step of the true motion, with errors: half of `turn` [rad], `forward` [m], and the other half of `turn`."""
        config, moved = self._config, abs(forward) + METRES_PER_RADIAN * abs(turn)
        if moved == 0.0:
            return
        root, kept = math.sqrt(moved), math.exp(-moved / config.bias_correlation_m)
        yaw_noise, x_noise, y_noise, *fresh = self._next(6)
        yaw_bias, x_bias, y_bias = self._bias
        x = self._scale * forward + config.position_walk_m * root * x_noise + config.velocity_bias * moved * x_bias
        y = config.position_walk_m * root * y_noise + config.velocity_bias * moved * y_bias
        middle = self.yaw + turn / 2
        self.x += math.cos(middle) * x - math.sin(middle) * y
        self.y += math.sin(middle) * x + math.cos(middle) * y
        self.yaw += turn + config.yaw_walk_rad * root * yaw_noise + config.yaw_bias_rad_m * moved * yaw_bias
        new = math.sqrt(1.0 - kept * kept)
        self._bias = [kept * bias + new * draw for bias, draw in zip(self._bias, fresh, strict=True)]

    def _next(self, count: int) -> list[float]:
        if len(self._draws) < count:
            self._draws = self._rng.standard_normal(_BLOCK).tolist()
        taken, self._draws = self._draws[:count], self._draws[count:]
        return taken
