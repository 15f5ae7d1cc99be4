"""PnP: the pose of a camera or of a rig from matches between key points and points in space."""

from collections.abc import Sequence

import numpy as np
import poselib
from jaxtyping import Float64, Int

from lexis.maths.projection import project
from lexis.maths.se3 import inverse
from lexis.types import Camera, Intrinsics, Pose

_RANSAC = {"min_iterations": 100, "max_iterations": 5000}
"""Numbers of samples that RANSAC draws; the upper limit bounds the time for a false candidate. 5000 samples suffice if one
match in eight is right."""

Pixels = Float64[np.ndarray, "k 2"]
Points = Float64[np.ndarray, "k 3"]


def solve_pnp(pixels: Pixels, points: Points, intrinsics: Intrinsics, max_error_px: float, seed: int) -> Pose:
    """Return the pose ``T_C_P`` that most matches of one image agree with, by LO-RANSAC.

    Args:
        pixels: positions of the key points in the image [px].
        points: positions of the matched points in their own frame P [m].
        intrinsics: the intrinsics of the camera.
        max_error_px: largest reprojection error of a match that agrees [px].
        seed: seed of the random samples.
    """
    ransac = {"max_reproj_error": max_error_px, "seed": seed, **_RANSAC}
    solution, _ = poselib.estimate_absolute_pose(pixels, points, _as_dict(intrinsics), ransac)
    return _as_matrix(solution)


def refine_rig_pose(
    seen: Sequence[tuple[Float64[np.ndarray, "_ 2"], Float64[np.ndarray, "_ 3"]]], rig: Sequence[Camera], T_B_P: Pose
) -> Pose:
    """Return the pose ``T_B_P`` of a rig that fits its matches best, by least squares of their reprojection errors.

    Args:
        seen: for each camera of the rig, pixels and points as in `solve_pnp`. All matches should be right.
        rig: the cameras.
        T_B_P: the pose to start from.
    """
    places = [_as_camera_pose(np.asarray(inverse(camera.T_B_C))) for camera in rig]
    lenses = [_as_dict(camera.intrinsics) for camera in rig]
    pixels, points = [pixels for pixels, _ in seen], [points for _, points in seen]
    refined, _ = poselib.refine_generalized_absolute_pose(pixels, points, _as_camera_pose(T_B_P), places, lenses)
    return _as_matrix(refined)


def inlier_rows(points_C: Points, pixels: Pixels, intrinsics: Intrinsics, limit_px: float) -> Int[np.ndarray, "i"]:
    """Return the rows of the inliers: matches whose points, in the frame C of the camera [m], project to their pixels.

    A point in front of the camera may project up to `limit_px` away from its pixel.
    """
    in_front = points_C[:, 2] > 0
    safe = np.where(in_front[:, None], points_C, [0.0, 0.0, 1.0])
    errors = np.linalg.norm(project(safe, intrinsics) - pixels, axis=1)
    return np.flatnonzero(in_front & (errors <= limit_px))


def _as_dict(intrinsics: Intrinsics) -> dict[str, object]:
    return {
        "model": "PINHOLE",
        "width": intrinsics.width,
        "height": intrinsics.height,
        "params": [intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy],
    }


def _as_camera_pose(T: Pose) -> poselib.CameraPose:
    pose = poselib.CameraPose()
    pose.R, pose.t = T[:3, :3], T[:3, 3]
    return pose


def _as_matrix(pose: poselib.CameraPose) -> Pose:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = pose.R, pose.t
    return T
