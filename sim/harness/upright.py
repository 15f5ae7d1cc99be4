"""`upright`: estimated poses in a frame whose z axis points up, whatever world frame a SLAM uses."""

import numpy as np

from lexis.maths.se3 import between
from lexis.types import Poses
from sim.harness.finished_run import Run


def upright(run: Run, poses: Poses) -> Poses:
    """Return estimated poses in the odometry frame, whose z axis points up.

    The world frame of a SLAM need not be upright: it may be that of the first camera. The first pose is taken to be that of
    the odometry.
    """
    return np.asarray(run.odometry_poses[0] @ between(poses[0], np.asarray(poses, float)))
