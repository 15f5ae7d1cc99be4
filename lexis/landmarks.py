"""Triangulation of landmarks, the 3-D points of a keyframe that PnP needs (paper, Sec. III-D), from RGB and odometry alone.

The keyframe is the reference view and its neighbouring frames are the supports. The steps are:

1. Match the reference's key points to every support, only near the epipolar lines that follow from the odometry. This leaves
   few candidates per key point, and so few wrong matches.
2. Fit every point to its matches by Gauss-Newton on the reprojection errors.
3. Discard single views with a large error and fit again, because one wrong match spoils the first fit.
4. Keep the points that enough views agree on and that are seen with enough parallax, since depth is unreliable otherwise.

A point is parametrised as ``theta = (x, y, rho)``: its ray ``(x, y, 1)`` in the reference camera and its inverse depth
``rho``. In another camera, its homogeneous position ``q = R (x, y, 1) + rho t`` is linear in theta, and stays
well-conditioned even for very distant points.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int

from lexis.config import LandmarkConfig
from lexis.features import mutual_matches
from lexis.maths.projection import project, project_jacobian, rays
from lexis.maths.se3 import between, inverse, skew, transform
from lexis.types import NO_LANDMARKS, Camera, Features, Intrinsics, Landmarks, Pose

_MIN_BASELINE_M = 0.01
"""Smallest distance between the cameras of two matched views [m]. If they are closer, noise dominates the epipolar lines."""
_ITERATIONS = 4
_DAMPING = 1e-12
"""Damping that is added to a Hessian in Gauss-Newton, as a share of the Hessian's trace."""
_FIRST_FIT_TOLERANCE = 3.0
"""After the first fit, errors of up to this many times `max_reprojection_px` are allowed, because one wrong view can spoil
that fit."""

Thetas = Float64[np.ndarray, "n 3"]


@dataclass(frozen=True, eq=False)
class View:
    """The features of one image, and the odometry pose of the body when the image was taken."""

    T_O_B: Pose
    features: Features


@dataclass(frozen=True, eq=False)
class _Tracks:
    """Key points of the reference (view 0) with their matches in the supports (the other views)."""

    pixels: Float64[np.ndarray, "n views 2"]
    seen: Bool[np.ndarray, "n views"]
    """Whether each key point has a match in each view."""
    T_V_R: Float64[np.ndarray, "views 4 4"]
    """Transforms from the reference camera to the camera of every view."""
    intrinsics: Intrinsics

    def __getitem__(self, rows: Int[np.ndarray, "k"] | Bool[np.ndarray, "n"]) -> "_Tracks":
        return replace(self, pixels=self.pixels[rows], seen=self.seen[rows])

    def homogeneous(self, theta: Thetas) -> Float64[np.ndarray, "n views 3"]:
        """Return the homogeneous position ``q`` of every point in every view: its position in that camera times ``rho``."""
        ray = np.concatenate([theta[:, :2], np.ones((len(theta), 1))], axis=1)
        rotated = np.einsum("vij,nj->nvi", self.T_V_R[:, :3, :3], ray)
        return np.asarray(rotated + theta[:, None, 2:] * self.T_V_R[:, :3, 3])

    def errors(self, theta: Thetas) -> Float64[np.ndarray, "n views"]:
        """Reprojection errors in all views, with or without a match; infinite for points behind a camera [px]."""
        q = self.homogeneous(theta)
        errors = np.linalg.norm(project(q, self.intrinsics) - self.pixels, axis=2)
        return np.where((q[..., 2] > 0) & (theta[:, 2:] > 0), errors, np.inf)


def triangulate(reference: View, supports: Sequence[View], camera: Camera, config: LandmarkConfig) -> Landmarks:
    """Triangulate the key points of the reference view, a keyframe, from the support views around it.

    Only points that at least `min_views` views agree on become landmarks, so the result may be empty.
    """
    if not len(reference.features.keypoints):
        return NO_LANDMARKS
    tracks = _match(reference, supports, camera, config)
    ids = np.flatnonzero(tracks.seen.sum(axis=1) >= config.min_views)
    tracks = tracks[ids]
    first = tracks.errors(_fit(tracks))
    tracks = replace(tracks, seen=tracks.seen & (first <= _FIRST_FIT_TOLERANCE * config.max_reprojection_px))
    theta = _fit(tracks)
    good = _is_good(theta, tracks, config)
    return Landmarks(transform(camera.T_B_C, _points(theta[good])), ids[good])


def _match(reference: View, supports: Sequence[View], camera: Camera, config: LandmarkConfig) -> _Tracks:
    """Match the key points of the reference to those of every support, only near the epipolar lines.

    Supports closer to the reference than `_MIN_BASELINE_M` get no matches.
    """
    T_O_C = np.stack([view.T_O_B @ camera.T_B_C for view in (reference, *supports)])
    T_V_R = between(T_O_C, T_O_C[0])
    keypoints, descriptors = reference.features.keypoints, reference.features.descriptors
    pixels = np.zeros((len(keypoints), len(T_V_R), 2))
    seen = np.zeros((len(keypoints), len(T_V_R)), bool)
    pixels[:, 0], seen[:, 0] = keypoints, True
    for view, (support, T_S_R) in enumerate(zip(supports, T_V_R[1:], strict=True), start=1):
        if np.linalg.norm(T_S_R[:3, 3]) < _MIN_BASELINE_M:
            continue
        distances = _epipolar_distances(keypoints, support.features.keypoints, T_S_R, camera.intrinsics)
        near = distances <= config.epipolar_px
        matches = mutual_matches(descriptors, support.features.descriptors, config.ratio, near, config.max_hamming)
        pixels[matches[:, 0], view] = support.features.keypoints[matches[:, 1]]
        seen[matches[:, 0], view] = True
    return _Tracks(pixels, seen, T_V_R, camera.intrinsics)


def _epipolar_distances(
    reference: Float32[np.ndarray, "n 2"], support: Float32[np.ndarray, "m 2"], T_S_R: Pose, intrinsics: Intrinsics
) -> Float32[np.ndarray, "n m"]:
    """Return the distances of the support's key points from the epipolar lines of the reference's key points [px].

    The sum is written term by term, because a matrix product would wake the threads of BLAS. These threads keep a core busy
    while they wait, which costs more than the product itself, and twenty times as much if all cores are busy.
    """
    essential = skew(T_S_R[:3, 3]) @ T_S_R[:3, :3]
    lines = rays(reference, intrinsics) @ essential.T @ np.linalg.inv(intrinsics.matrix)
    lines /= np.maximum(np.linalg.norm(lines[:, :2], axis=1, keepdims=True), 1e-12)
    (a, b, c), (u, v) = lines.T.astype(np.float32), support.T
    distances = np.multiply.outer(a, u)
    distances += np.multiply.outer(b, v)
    distances += c[:, None]
    return np.asarray(np.abs(distances, out=distances))


def _fit(tracks: _Tracks) -> Thetas:
    """Fit all points by Gauss-Newton on the reprojection errors, starting at a linear estimate of the inverse depth."""
    theta = rays(tracks.pixels[:, 0], tracks.intrinsics)
    theta[:, 2] = _linear_inverse_depth(theta, tracks)
    q_by_theta = np.concatenate([tracks.T_V_R[:, :3, :2], tracks.T_V_R[:, :3, 3:]], axis=2)
    seen = tracks.seen[..., None]
    for _ in range(_ITERATIONS):
        q = tracks.homogeneous(theta)
        residuals = np.where(seen, project(q, tracks.intrinsics) - tracks.pixels, 0.0)
        jacobians = np.where(seen[..., None], project_jacobian(q, tracks.intrinsics) @ q_by_theta, 0.0)
        jacobians = jacobians.reshape(len(theta), 2 * len(tracks.T_V_R), 3)
        transposed = np.swapaxes(jacobians, 1, 2)
        hessians = transposed @ jacobians
        # Damping is relative to the trace, because the Hessian becomes huge if a false match puts a point into
        # the plane z = 0 of a camera.
        hessians += (_DAMPING * np.trace(hessians, axis1=1, axis2=2) + 1e-6)[:, None, None] * np.eye(3)
        gradients = transposed @ residuals.reshape(len(theta), 2 * len(tracks.T_V_R), 1)
        theta = theta - np.linalg.solve(hessians, gradients)[..., 0]
    return theta


def _linear_inverse_depth(theta: Thetas, tracks: _Tracks) -> Float64[np.ndarray, "n"]:
    """Inverse depths by least squares of ``ray x (R (x, y, 1) + rho t) = 0`` over the views, with fixed reference rays."""
    observed = rays(tracks.pixels, tracks.intrinsics)[..., :2]
    at_infinity = tracks.homogeneous(theta * [1.0, 1.0, 0.0])
    translations = tracks.T_V_R[:, :3, 3]
    seen = tracks.seen[..., None]
    constant = np.where(seen, observed * at_infinity[..., 2:] - at_infinity[..., :2], 0.0)
    slope = np.where(seen, observed * translations[:, 2:] - translations[:, :2], 0.0)
    return np.asarray(-(constant * slope).sum(axis=(1, 2)) / np.maximum((slope**2).sum(axis=(1, 2)), 1e-12))


def _is_good(theta: Thetas, tracks: _Tracks, config: LandmarkConfig) -> Bool[np.ndarray, "n"]:
    """Whether enough views are left, their reprojection errors are small, and the parallax is large enough."""
    errors = np.where(tracks.seen, tracks.errors(theta), 0.0)
    good = np.asarray((errors <= config.max_reprojection_px).all(axis=1) & tracks.seen[:, 0])
    good &= tracks.seen.sum(axis=1) >= config.min_views
    good[good] = _parallax(theta[good], tracks[good]) >= config.min_parallax_rad
    return good


def _parallax(theta: Thetas, tracks: _Tracks) -> Float64[np.ndarray, "n"]:
    """Largest angle between any two viewing rays of a point [rad]."""
    directions = _points(theta)[:, None] - inverse(tracks.T_V_R)[:, :3, 3]
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    cosines = directions @ np.swapaxes(directions, 1, 2)
    both = tracks.seen[:, :, None] & tracks.seen[:, None, :]
    return np.asarray(np.arccos(np.clip(np.where(both, cosines, 1.0).min(axis=(1, 2)), -1.0, 1.0)))


def _points(theta: Thetas) -> Float64[np.ndarray, "n 3"]:
    """Return the positions of the points in the reference camera's frame [m]."""
    return np.asarray(np.concatenate([theta[:, :2], np.ones((len(theta), 1))], axis=1) / theta[:, 2:])
