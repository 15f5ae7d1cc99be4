"""A SLAM that ends its process without an exception. Worker processes import it from this module."""

import os

import numpy as np

from sim.harness.adapters import OdometryOnly


class AbortingSlam(OdometryOnly):
    """Ends its process at the observation that has one pose, as a fatal error of compiled code does."""

    def __init__(self, T_O_B: np.ndarray) -> None:
        self._fatal = T_O_B

    def process(self, observation):
        """End the process at the fatal pose."""
        if np.array_equal(observation.T_O_B, self._fatal):
            os._exit(1)
        super().process(observation)
