"""A SLAM that ends its process, as one with a fault in compiled code does. It is importable in other processes."""

import os
import signal

from sim.harness.adapters import OdometryOnly


class AbortingSlam(OdometryOnly):
    """Kills its process at the fifth observation."""

    def process(self, observation):
        if observation.index == 5:
            os.kill(os.getpid(), signal.SIGKILL)
        super().process(observation)
