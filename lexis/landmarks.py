"""Landmarks: 3-D points of a keyframe, triangulated from RGB and odometry alone (paper, Sec. III-D needs them for PnP).

Matches to neighbouring frames are guided by the epipolar geometry that the odometry gives. A point is then
``theta = (x, y, rho)``: its ray ``(x, y, 1)`` in the keyframe's camera and its inverse depth ``rho``. Seen from
another camera its homogeneous position ``q = R (x, y, 1) + rho t`` is linear in theta, and stays well-conditioned
however far the point is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from lexis.config import LandmarkConfig
from lexis.features import mutual_matches
from lexis.projection import project, project_jacobian, rays
from lexis.se3 import between, inverse, skew, transform
from lexis.types import Camera, Features, Intrinsics, Landmarks, Pose, Poses

_MIN_BASELINE_M = 0.01
"""Below this, the epipolar lines and the parallax are odometry noise."""
_ITERATIONS = 4


@dataclass(frozen=True, eq=False)
class View:
    """Features of one image and where the odometry says it was taken."""

    T_O_B: Pose
    features: Features


@dataclass(frozen=True, eq=False)
class _Tracks:
    """Key points of the reference (view 0) with their matches in the other views."""

    pixels: Float64[np.ndarray, "n views 2"]
    seen: Bool[np.ndarray, "n views"]


def triangulate(reference: View, supports: Sequence[View], camera: Camera, config: LandmarkConfig) -> Landmarks:
    """Points of the reference's key points that at least `min_views` images agree on; none is a valid answer."""
    T_O_C = np.stack([view.T_O_B @ camera.T_B_C for view in (reference, *supports)])
    T_V_R = between(T_O_C, T_O_C[0])
    tracks = _match(reference, supports, T_V_R, camera.intrinsics, config)
    candidates = np.flatnonzero(tracks.seen.sum(axis=1) >= config.min_views)
    if len(candidates) == 0:
        return Landmarks(np.zeros((0, 3)), candidates)
    tracks = _Tracks(tracks.pixels[candidates], tracks.seen[candidates])
    theta = _fit(tracks, T_V_R, camera.intrinsics)
    tracks = _Tracks(tracks.pixels, tracks.seen & (_errors(theta, tracks, T_V_R, camera.intrinsics) <= _drop_px(config)))
    theta = _fit(tracks, T_V_R, camera.intrinsics)
    good = _is_good(theta, tracks, T_V_R, camera.intrinsics, config)
    return Landmarks(transform(camera.T_B_C, _points(theta[good])), candidates[good])


def _match(
    reference: View, supports: Sequence[View], T_V_R: Poses, intrinsics: Intrinsics, config: LandmarkConfig
) -> _Tracks:
    """Match the reference to every support that has a baseline, near the epipolar lines."""
    count = len(reference.features.keypoints)
    pixels = np.zeros((count, len(T_V_R), 2))
    seen = np.zeros((count, len(T_V_R)), bool)
    pixels[:, 0], seen[:, 0] = reference.features.keypoints, True
    for view, (support, T_S_R) in enumerate(zip(supports, T_V_R[1:], strict=True), start=1):
        if np.linalg.norm(T_S_R[:3, 3]) < _MIN_BASELINE_M:
            continue
        near = _near_epipolar_line(reference.features, support.features, T_S_R, intrinsics, config.epipolar_px)
        descriptors = reference.features.descriptors, support.features.descriptors
        matches = mutual_matches(*descriptors, config.ratio, near, config.max_hamming)
        pixels[matches[:, 0], view] = support.features.keypoints[matches[:, 1]]
        seen[matches[:, 0], view] = True
    return _Tracks(pixels, seen)


def _near_epipolar_line(
    reference: Features, support: Features, T_S_R: Pose, intrinsics: Intrinsics, distance_px: float
) -> Bool[np.ndarray, "n m"]:
    """Which key points of the support lie within a distance of which reference key point's epipolar line."""
    essential = skew(T_S_R[:3, 3]) @ T_S_R[:3, :3]
    K_inverse = np.linalg.inv(intrinsics.matrix)
    lines = rays(reference.keypoints, intrinsics) @ (K_inverse.T @ essential).T
    lines /= np.maximum(np.linalg.norm(lines[:, :2], axis=1, keepdims=True), 1e-12)
    pixels = support.keypoints.astype(np.float64)
    return np.abs(lines[:, :2] @ pixels.T + lines[:, 2:]) <= distance_px


def _fit(tracks: _Tracks, T_V_R: Poses, intrinsics: Intrinsics) -> Float64[np.ndarray, "n 3"]:
    """Gauss-Newton on the reprojection errors, from the linear estimate of the inverse depth."""
    theta = rays(tracks.pixels[:, 0], intrinsics)
    theta[:, 2] = _linear_inverse_depth(theta, tracks, T_V_R, intrinsics)
    slopes = np.concatenate([T_V_R[:, :3, :2], T_V_R[:, :3, 3:]], axis=2)
    seen = tracks.seen[..., None]
    for _ in range(_ITERATIONS):
        homogeneous = _homogeneous(theta, T_V_R)
        residuals = np.where(seen, project(homogeneous, intrinsics) - tracks.pixels, 0.0)
        jacobians = np.where(seen[..., None], project_jacobian(homogeneous, intrinsics) @ slopes, 0.0)
        jacobians = jacobians.reshape(len(theta), -1, 3)
        transposed = np.swapaxes(jacobians, 1, 2)
        hessians = transposed @ jacobians + 1e-6 * np.eye(3)
        theta = theta - np.linalg.solve(hessians, transposed @ residuals.reshape(len(theta), -1, 1))[..., 0]
    return theta


def _linear_inverse_depth(
    theta: Float64[np.ndarray, "n 3"], tracks: _Tracks, T_V_R: Poses, intrinsics: Intrinsics
) -> Float64[np.ndarray, "n"]:
    """Least squares of ``rays x (R (x, y, 1) + rho t) = 0`` over the views, the ray of the reference being kept."""
    observed = rays(tracks.pixels, intrinsics)[..., :2]
    directions = _homogeneous(theta * [1.0, 1.0, 0.0], T_V_R)
    constant = np.where(tracks.seen[..., None], observed * directions[..., 2:] - directions[..., :2], 0.0)
    slope = np.where(tracks.seen[..., None], observed * T_V_R[:, 2:3, 3] - T_V_R[:, :2, 3], 0.0)
    return -(constant * slope).sum(axis=(1, 2)) / np.maximum((slope**2).sum(axis=(1, 2)), 1e-12)


def _homogeneous(theta: Float64[np.ndarray, "n 3"], T_V_R: Poses) -> Float64[np.ndarray, "n views 3"]:
    """``q`` of every point in every view: the point in that camera, times its inverse depth in the reference."""
    ray = np.concatenate([theta[:, :2], np.ones((len(theta), 1))], axis=1)
    return np.einsum("vij,nj->nvi", T_V_R[:, :3, :3], ray) + theta[:, None, 2:] * T_V_R[:, :3, 3]


def _errors(
    theta: Float64[np.ndarray, "n 3"], tracks: _Tracks, T_V_R: Poses, intrinsics: Intrinsics
) -> Float64[np.ndarray, "n views"]:
    """Reprojection errors; infinite behind a camera [px]."""
    homogeneous = _homogeneous(theta, T_V_R)
    errors = np.linalg.norm(project(homogeneous, intrinsics) - tracks.pixels, axis=2)
    return np.where((homogeneous[..., 2] > 0) & (theta[:, 2:] > 0), errors, np.inf)


def _drop_px(config: LandmarkConfig) -> float:
    """A single wrong view spoils the first fit for all, so that judgement is lenient [px]."""
    return 3.0 * config.max_reprojection_px


def _is_good(
    theta: Float64[np.ndarray, "n 3"],
    tracks: _Tracks,
    T_V_R: Poses,
    intrinsics: Intrinsics,
    config: LandmarkConfig,
) -> Bool[np.ndarray, "n"]:
    errors = np.where(tracks.seen, _errors(theta, tracks, T_V_R, intrinsics), 0.0)
    fits = (errors <= config.max_reprojection_px).all(axis=1)
    enough = tracks.seen[:, 0] & (tracks.seen.sum(axis=1) >= config.min_views)
    good = fits & enough
    good[good] = _parallax(theta[good], tracks.seen[good], T_V_R) >= config.min_parallax_rad
    return good


def _points(theta: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 3"]:
    """In the camera frame of the reference [m]."""
    return np.concatenate([theta[:, :2], np.ones((len(theta), 1))], axis=1) / theta[:, 2:]


def _parallax(
    theta: Float64[np.ndarray, "n 3"], seen: Bool[np.ndarray, "n views"], T_V_R: Poses
) -> Float64[np.ndarray, "n"]:
    """Largest angle between any two of the rays that see a point [rad]."""
    centres = inverse(T_V_R)[:, :3, 3]
    directions = _points(theta)[:, None] - centres
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    cosines = directions @ np.swapaxes(directions, 1, 2)
    both = seen[:, :, None] & seen[:, None, :]
    return np.arccos(np.clip(np.where(both, cosines, 1.0).min(axis=(1, 2)), -1.0, 1.0))
