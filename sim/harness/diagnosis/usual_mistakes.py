"""`usual_mistakes`: mistakes of a new SLAM or program that its figures do not explain, such as floors counted from 1."""

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from lexis.maths.se3 import between, rotation_angle
from lexis.types import Poses
from sim.harness.finished_run import Run

_DIFFERS_RAD, _AGREES_RAD = 0.4, 0.1
"""Angles [rad] between the rotations of the SLAM and of the odometry since the first frame, as medians. The numbers of the
quaternions are in another order if the angle exceeds the first one, and with the numbers reordered stays below the second
one, by which odometry hardly drifts."""


def usual_mistakes(run: Run) -> Iterator[str]:
    """Yield a sentence for every mistake that is found in an estimate."""
    if offset := _floor_offset(run):
        yield f"Every floor is {abs(offset)} too {'high' if offset > 0 else 'low'}; floors are numbered from 0, the lowest."
    poses = run.estimate.T_W_B
    if poses is not None and _turns_with_other_order(poses, run.odometry_poses):
        yield "The quaternions seem to be written as qw qx qy qz; valid: qx qy qz qw, which would agree with the odometry."


def _floor_offset(run: Run) -> int:
    """Return by how much all estimated floors are too high; 0 if they are right or wrong in different ways."""
    floors = run.estimate.floors
    if floors is None:
        return 0
    judged = (floors >= 0) & ~run.on_stairs
    offsets = np.unique(floors[judged] - run.true_floors[judged])
    return int(offsets[0]) if len(offsets) == 1 else 0


def _turns_with_other_order(estimated: Poses, odometry: Poses) -> bool:
    """Whether the rotations are those of the odometry if the quaternions that are read as x y z w are w x y z."""
    quaternions = Rotation.from_matrix(estimated[:, :3, :3]).as_quat()
    reordered = estimated.copy()
    reordered[:, :3, :3] = Rotation.from_quat(np.roll(quaternions, -1, axis=1)).as_matrix()
    return _median_rad(estimated, odometry) > _DIFFERS_RAD and _median_rad(reordered, odometry) < _AGREES_RAD


def _median_rad(estimated: Poses, odometry: Poses) -> float:
    """Return the median angle between the rotations of both trajectories since their first frame [rad]."""
    since_first = (between(poses[:1], poses) for poses in (estimated, odometry))
    return float(np.median(rotation_angle(between(*since_first))))
