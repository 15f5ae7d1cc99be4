"""Errors of an estimated trajectory: absolute trajectory error and relative pose error."""

import numpy as np
from jaxtyping import Float64

from lexis.maths.paths import arc_length
from lexis.maths.se3 import between, inverse
from lexis.maths.ties import MILLIONTH
from lexis.types import Pose, Poses

Points = Float64[np.ndarray, "n 3"]

LEAST_POSES = 3
"""Least number of poses for which the absolute trajectory error is computed. With fewer poses, the alignment is ambiguous or
removes the error."""
STRETCHES_M = (8.0, 24.0)
"""Lengths of path over which the harness reports the relative pose error [m]."""


def align(estimate: Points, truth: Points) -> Pose:
    """Return T_truth_estimate, the rigid motion that best aligns estimate and truth (Umeyama, 1991, without scale)."""
    centre, true_centre = estimate.mean(axis=0), truth.mean(axis=0)
    u, _, vt = np.linalg.svd((truth - true_centre).T @ (estimate - centre))
    # This matrix keeps the rotation right-handed where the SVD would give a reflection.
    handed = np.diag([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    result = np.eye(4)
    result[:3, :3] = u @ handed @ vt
    result[:3, 3] = true_centre - result[:3, :3] @ centre
    return result


def aligned(estimate: Poses, truth: Poses) -> Poses:
    """Move the estimated poses onto the true poses by the same alignment that `ate_rmse` uses.

    With fewer than 3 poses, which cannot be aligned, move the estimate so that its first pose equals the first true pose.
    """
    if len(truth) < LEAST_POSES:
        return np.asarray(truth[0] @ inverse(estimate[0]) @ estimate)
    return np.asarray(align(estimate[:, :3, 3], truth[:, :3, 3]) @ estimate)


def ate_rmse(estimate: Points, truth: Points) -> float | None:
    """Absolute trajectory error: RMSE of positions after SE(3) alignment [m], as in `evo_ape tum -a`; None for < 3 poses."""
    if len(truth) < LEAST_POSES:
        return None
    T = align(estimate, truth)
    residuals = estimate @ T[:3, :3].T + T[:3, 3] - truth
    return float(np.sqrt(np.mean(np.sum(residuals**2, axis=1))))


def rpe_translation(estimate: Poses, truth: Poses, delta_m: float) -> float | None:
    """Return the relative pose error: the RMSE of the translation error over stretches of `delta_m` of true path [m].

    Every pose begins a stretch, which ends at the first pose at least `delta_m` of path later, so stretches may overlap. The
    result is None if the path is shorter than `delta_m`.
    """
    path = arc_length(truth[:, :3, 3])
    ends = np.searchsorted(path, path + delta_m - MILLIONTH)  # as `lexis.maths.ties.reaches`
    starts = np.flatnonzero(ends < len(path))
    if not len(starts):
        return None
    ends = ends[starts]
    error = between(between(truth[starts], truth[ends]), between(estimate[starts], estimate[ends]))
    return float(np.sqrt(np.mean(np.sum(error[:, :3, 3] ** 2, axis=1))))
