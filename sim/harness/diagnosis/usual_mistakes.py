"""`usual_mistakes`: mistakes of a new SLAM or program that its figures do not explain, such as floors counted from 1."""

import math
from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from lexis.evaluation.loops import true_edges
from lexis.maths.se3 import between, inverse, rotation_angle
from lexis.types import Camera, Poses
from sim.harness.finished_run import Run

_DIFFERS_RAD, _AGREES_RAD = 0.4, 0.1
"""Angles [rad] between the rotations of the SLAM and of the odometry since the first frame, as medians. Rotations are in
another convention if the angle exceeds the first one, and once converted stays below the second one, by which odometry
hardly drifts."""
_CONSTANT_RAD = 1e-3
"""Largest angle between the first rotation and any other one, for rotations that count as equal [rad]."""
_LONGEST_DELAY_S = 2.0
"""Longest delay of the poses that is recognised [s]."""
_DELAYED = 0.5
"""Poses count as delayed if this decreases the misfit of their turns to less than this share."""
_FEW_TRUE, _MOST_TRUE = 0.5, 0.8
"""Shares of true loops as they are, at most, and once inverted, at least, for loops that count as inverted."""


def usual_mistakes(run: Run) -> Iterator[str]:
    """Yield a sentence for every mistake that is found in an estimate."""
    if offset := _floor_offset(run):
        yield f"Every floor is {abs(offset)} too {'high' if offset > 0 else 'low'}; floors are numbered from 0, the lowest."
    if run.estimate.T_W_B is not None:
        yield from _of_rotations(run.estimate.T_W_B, run.odometry_poses, run.session.camera)
        if delay_s := _delay_s(run, run.estimate.T_W_B):
            yield (
                f"The poses seem to be {abs(delay_s):.3g} s too {'late' if delay_s > 0 else 'early'}, by the rotations of "
                "the odometry; valid: poses with the stamps of their images."
            )
    if _has_inverted_loops(run):
        yield (
            "The relative poses of the loops seem to be inverted; valid: T_match_query, the pose of the later body in the "
            "frame of the earlier one."
        )


def _floor_offset(run: Run) -> int:
    """Return by how much all estimated floors are too high; 0 if they are right or wrong in different ways."""
    floors = run.estimate.floors
    if floors is None:
        return 0
    judged = (floors >= 0) & ~run.on_stairs
    offsets = np.unique(floors[judged] - run.true_floors[judged])
    return int(offsets[0]) if len(offsets) == 1 else 0


def _of_rotations(estimated: Poses, odometry: Poses, camera: Camera) -> Iterator[str]:
    """Yield what is wrong with rotations that do not follow the odometry, if they would in another convention."""
    if _median_rad(estimated, odometry) <= _DIFFERS_RAD:
        return
    if (rotation_angle(between(estimated[:1], estimated)) < _CONSTANT_RAD).all():
        yield "All rotations are equal, although the robot turns; valid: the orientations of the body."
    for converted, problem in (
        (_with_other_order(estimated), "The quaternions seem to be written as qw qx qy qz; valid: qx qy qz qw"),
        (
            estimated @ inverse(camera.T_B_C),
            "The poses seem to be those of the camera; valid: T_W_C @ inverse(T_B_C)",
        ),
        (inverse(estimated), "The poses seem to be inverted; valid: T_W_B, which maps points of the body to the world"),
    ):
        if _median_rad(np.asarray(converted), odometry) < _AGREES_RAD:
            yield f"{problem}, which would agree with the odometry."


def _with_other_order(estimated: Poses) -> Poses:
    """Return the poses with rotations from the quaternions w x y z, where they were read as x y z w."""
    quaternions = Rotation.from_matrix(estimated[:, :3, :3]).as_quat()
    reordered = estimated.copy()
    reordered[:, :3, :3] = Rotation.from_quat(np.roll(quaternions, -1, axis=1)).as_matrix()
    return reordered


def _median_rad(estimated: Poses, odometry: Poses) -> float:
    """Return the median angle between the rotations of both trajectories since their first frame [rad]."""
    since_first = (between(poses[:1], poses) for poses in (estimated, odometry))
    return float(np.median(rotation_angle(between(*since_first))))


def _delay_s(run: Run, estimated: Poses) -> float:
    """Return by how much all poses are too late [s], negative if they are too early; 0 unless it is evident.

    The turns of the estimate are compared with those of the odometry some frames earlier or later.
    """
    count, frames = len(run.session), run.estimate.frames
    if run.scenario.faults or len(run.given) < count:
        return 0.0
    odometry = np.array([run.given[frame].T_O_B for frame in range(count)])
    period_s = 1.0 / run.scenario.frame_rate_hz
    most = math.ceil(_LONGEST_DELAY_S / period_s)
    inner = (frames[:-1] >= most) & (frames[1:] < count - most)
    if not inner.any():
        return 0.0
    first, second = frames[:-1][inner], frames[1:][inner]
    turns = between(estimated[:-1][inner], estimated[1:][inner])
    delays = np.arange(-most, most + 1)
    misfits = [_rms_rad(between(turns, between(odometry[first - d], odometry[second - d]))) for d in delays.tolist()]
    best, evident = int(np.argmin(misfits)), _DELAYED * misfits[most]
    if misfits[best] >= evident or _rms_rad(turns) <= evident:  # poses that hardly turn show no delay
        return 0.0
    return float(delays[best]) * period_s


def _rms_rad(motions: Poses) -> float:
    return float(np.sqrt(np.mean(rotation_angle(motions) ** 2)))


def _has_inverted_loops(run: Run) -> bool:
    loops = run.estimate.loops
    if loops is None or not len(loops.query):
        return False
    given, inverted = (
        true_edges(loops.query, loops.match, T, run.true_poses).mean()
        for T in (loops.T_match_query, np.asarray(inverse(loops.T_match_query)))
    )
    return bool(given <= _FEW_TRUE and inverted >= _MOST_TRUE)
