"""`first_wrong_motion`: the first motion of an estimate that differs clearly from the true motion.

Motions are relative poses of the body, so that neither the alignment of the whole path nor earlier errors affect them.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial.transform import Rotation

from lexis.maths.se3 import between, rotation_angle
from lexis.types import Poses
from sim.harness.finished_run import Run
from sim.wording import joined

_STRETCH_S = 0.5
"""Least duration of a compared motion [s]. At high frame rates, the motion from one frame to the next is too short."""
_MOVE_M, _TURN_RAD = 0.1, 0.1
"""Least errors of a motion that count as clear: of the translation [m] and of the rotation [rad]."""
_SHARE = 0.1
"""A clear error is also at least this share of the true translation or rotation."""
_WORSE = 3.0
"""A clear error is also at least this multiple of the odometry's error of the same motion."""
_SHOWN_M, _SHOWN_DEG = 0.02, 1.0
"""Smallest parts of a motion that are put into words."""
_MOVES = (("ahead", "back"), ("to the left", "to the right"), ("up", "down"))
"""Directions of the translation along the axes of the body, positive and negative."""
_TURNS = (
    ("rolls {} to the right", "rolls {} to the left"),
    ("tilts {} down", "tilts {} up"),
    ("turns {} to the left", "turns {} to the right"),
)
"""Directions of the rotation about the axes of the body, positive and negative."""


@dataclass(frozen=True)
class WrongMotion:
    """A motion of the estimate from one row to a later row that differs clearly from the true motion."""

    start: int
    end: int
    what: str
    """The motion of the estimate and the true motion, in words."""


def first_wrong_motion(run: Run) -> WrongMotion | None:
    """Return the first motion with an error that stands out.

    Each frame is compared with the first frame at least `_STRETCH_S` later. An error of the translation or of the rotation
    stands out if it is large, and much larger than the odometry's error of the same motion. The result is None if no error
    stands out, and for a SLAM that estimates no poses.
    """
    if run.estimate.T_W_B is None:
        return None
    times = run.session.tour.stamps[run.estimate.frames]
    ends = np.searchsorted(times, times + (_STRETCH_S - 1e-6))
    starts = np.flatnonzero(ends < len(times))
    ends = ends[starts]
    true, odometry, estimated = (
        between(poses[starts], poses[ends])
        for poses in (run.true_poses, run.odometry_poses, np.asarray(run.estimate.T_W_B, np.float64))
    )
    moved = _stands_out(
        _move_errors(estimated, true), _move_errors(odometry, true), np.linalg.norm(true[:, :3, 3], axis=1), _MOVE_M
    )
    turned = _stands_out(
        rotation_angle(between(true, estimated)), rotation_angle(between(true, odometry)), rotation_angle(true), _TURN_RAD
    )
    if not (moved | turned).any():
        return None
    k = int(np.argmax(moved | turned))
    start, end = int(starts[k]), int(ends[k])
    since_s, until_s = times[[start, end]] - run.session.tour.stamps[0]
    estimate, robot = _told(estimated[k], true[k], bool(moved[k]), bool(turned[k]))
    return WrongMotion(start, end, f"from {since_s:.1f} s to {until_s:.1f} s the estimate {estimate}, but the robot {robot}")


def _move_errors(motions: Poses, true: Poses) -> Float64[np.ndarray, "n"]:
    """Return the errors of the translations [m], in the body frame at the start of each motion."""
    return np.asarray(np.linalg.norm(motions[:, :3, 3] - true[:, :3, 3], axis=1))


def _stands_out(
    errors: Float64[np.ndarray, "n"], odometry: Float64[np.ndarray, "n"], true: Float64[np.ndarray, "n"], least: float
) -> Bool[np.ndarray, "n"]:
    """Return for which motions the error is clear. `odometry` are the odometry's errors, `true` the sizes of the motions."""
    return np.asarray((errors > least) & (errors > _SHARE * true) & (errors > _WORSE * odometry))


def _told(
    estimated: Float64[np.ndarray, "4 4"], true: Float64[np.ndarray, "4 4"], moved: bool, turned: bool
) -> tuple[str, str]:
    """Describe the estimated and the true motion, as far as their translation (`moved`) or rotation (`turned`) differs."""
    told = [list[str](), list[str]()]
    if moved:
        for clauses, parts in zip(told, _shown(estimated[:3, 3], true[:3, 3], _SHOWN_M), strict=True):
            said = [f"{abs(part):.2f} m {_MOVES[axis][part < 0]}" for axis, part in parts]
            clauses.append(f"moves {joined(said, 'and')}" if said else "does not move")
    if turned:
        for clauses, parts in zip(told, _shown(_angles_deg(estimated), _angles_deg(true), _SHOWN_DEG), strict=True):
            said = [_TURNS[axis][part < 0].format(f"{abs(part):.0f}°") for axis, part in parts]
            clauses.append(joined(said, "and") if said else "does not turn")
    return joined(told[0], "and"), joined(told[1], "and")


def _angles_deg(T: Float64[np.ndarray, "4 4"]) -> Float64[np.ndarray, "3"]:
    """Return the rotation of a motion as a vector along its axis, as long as its angle [deg]."""
    return np.asarray(Rotation.from_matrix(T[:3, :3]).as_rotvec(degrees=True))


def _shown(
    estimated: Float64[np.ndarray, "3"], true: Float64[np.ndarray, "3"], least: float
) -> tuple[list[tuple[int, float]], list[tuple[int, float]]]:
    """Return the parts of two vectors, as (axis, part), that matter for their lengths or for their difference."""
    size, apart = max(np.linalg.norm(estimated), np.linalg.norm(true)), np.linalg.norm(estimated - true)
    axes = [
        axis
        for axis in range(3)
        if max(abs(estimated[axis]), abs(true[axis])) > 0.2 * size or abs(estimated[axis] - true[axis]) > 0.5 * apart
    ]
    first, second = ([(axis, float(v[axis])) for axis in axes if abs(v[axis]) >= least] for v in (estimated, true))
    return first, second
