"""`Locator`: the pose of a new keyframe relative to an earlier one, from matched key points (steps 1 to 4 of verification).

With a rig, each camera of the new keyframe is matched to the landmarks of all cameras of the earlier one. A rear camera thus
recognises what a front camera saw. `lexis.verification` lists the steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int

from lexis.config import VerificationConfig
from lexis.features import mutual_matches
from lexis.graph.pose_estimate import PoseEstimate
from lexis.maths.pnp import inlier_rows, refine_rig_pose, solve_pnp
from lexis.maths.projection import project_jacobian
from lexis.maths.rig import camera_angles
from lexis.maths.se3 import between, inverse, skew, transform
from lexis.maths.ties import rounded
from lexis.types import Camera, Covariance, Keyframe, LoopDecision, LoopEdge, Pose

_GRID = 6
"""Number of cells along each side of the image, for measuring the spread of inliers."""
_OVERLAP_RAD = 1.0
"""Two cameras of a rig are matched only if the estimated angle between them is at most this, plus the tolerance for the
estimate [rad]."""
_LEAST_MATCHES = 8
"""Least number of matches of one camera of a rig from which PnP is solved. Fewer are too few to tell right from wrong."""


@dataclass(frozen=True, eq=False)
class _Correspondences:
    """Matches between key points of one image of the query and landmarks; a key point may occur several times."""

    feature_ids: Int[np.ndarray, "k"]
    """Row of every matched key point in the image's features."""
    pixels: Float64[np.ndarray, "k 2"]
    points: Float64[np.ndarray, "k 3"]
    """Positions of the landmarks in the candidate's body frame [m]."""

    def __getitem__(self, rows: Int[np.ndarray, "i"]) -> "_Correspondences":
        return _Correspondences(self.feature_ids[rows], self.pixels[rows], self.points[rows])

    @property
    def size(self) -> int:
        """Number of distinct key points."""
        return len(np.unique(self.feature_ids))


_Seen = tuple[_Correspondences, ...]
"""The correspondences of all cameras of the query."""


@dataclass(frozen=True, eq=False)
class _Fit:
    """The pose of a query, and its inliers: the correspondences that agree with the pose."""

    T_C_match: tuple[Pose, ...]
    """Pose of the candidate's body in each camera of the query."""
    seen: _Seen

    @property
    def size(self) -> int:
        """Number of distinct key points."""
        return sum(each.size for each in self.seen)


class Locator:
    """Computes loop edges from one query keyframe to candidates by PnP.

    Descriptor matches are cached, because neighbouring candidates share landmarks.
    """

    def __init__(
        self,
        query: Keyframe,
        keyframes: Sequence[Keyframe],
        camera: Camera,
        config: VerificationConfig,
        graph: PoseEstimate | None = None,
    ) -> None:
        """With a `graph`, cameras of a rig that look in different directions by its estimate are not compared."""
        self._query = query
        self._keyframes = keyframes
        self._camera = camera
        self._config = config
        self._graph = graph
        self._views = query.views
        self._rotations = np.stack([each.T_B_C[:3, :3] for each in camera.rig])
        self._matches: dict[tuple[int, int, int], Int[np.ndarray, "k 2"]] = {}

    def from_match(self, match: int) -> tuple[LoopDecision, LoopEdge | None]:
        """Judge the candidate with the id `match`, by PnP with the landmarks of the candidate and its neighbours.

        The loop edge is None if too few key points match, too few of them are inliers, or the inliers cover too little of
        the images.
        """
        config, seen = self._config, self._correspondences(match)
        matches = sum(each.size for each in seen)
        decision = LoopDecision(self._query.id, match, "few matches", matches=matches)
        if matches < config.min_inliers:
            return decision, None
        fit = self._fit(seen)
        # One image alone has to confirm the loop. With the sums over all images, false loops would pass more easily.
        cells = max(map(_occupied_cells, fit.seen, self._camera.rig))
        decision = replace(decision, inliers=fit.size, cells=cells)
        if max(each.size for each in fit.seen) < config.min_inliers:
            return replace(decision, outcome="few inliers"), None
        if cells < config.min_cells:
            return replace(decision, outcome="crowded inliers"), None
        T_match_query = inverse(fit.T_C_match[0]) @ inverse(self._camera.T_B_C)
        edge = LoopEdge(self._query.id, match, T_match_query, _covariance(fit, self._camera, config), fit.size)
        return replace(decision, outcome="accepted"), edge

    def _correspondences(self, match: int) -> _Seen:
        """Match each image of the query to the landmarks of the candidate and its neighbours.

        Odometry gives the positions of the neighbours' landmarks in the candidate's frame. The query is matched to each
        camera of each keyframe separately. If it were matched to all landmarks together, two landmarks of the same physical
        point would have similar descriptors and fail the ratio test.
        """
        none = np.zeros(0, int), np.zeros((0, 3))
        found = [[none] for _ in self._views]
        for keyframe in self._pool(match):
            T_match_neighbour = between(self._keyframes[match].T_O_B, keyframe.T_O_B)
            for camera, taken_by in self._facing(keyframe):
                pairs = self._match(keyframe, camera, taken_by)
                points = keyframe.views[taken_by].landmarks.points[pairs[:, 1]]
                found[camera].append((pairs[:, 0], transform(T_match_neighbour, points)))
        seen = []
        for view, matched in zip(self._views, found, strict=True):
            ids = np.concatenate([ids for ids, _ in matched])
            # The points are rounded, because their last digits depend on the processor and may change the result of RANSAC.
            points = rounded(np.concatenate([points for _, points in matched]))
            seen.append(_Correspondences(ids, view.features.keypoints[ids].astype(np.float64), points))
        return tuple(seen)

    def _pool(self, match: int) -> list[Keyframe]:
        """Return the candidate and its neighbours on the path, from the same session."""
        pool = self._keyframes[max(match - self._config.pool, 0) : min(match + self._config.pool + 1, self._query.id)]
        return [keyframe for keyframe in pool if keyframe.session == self._keyframes[match].session]

    def _facing(self, keyframe: Keyframe) -> list[tuple[int, int]]:
        """Return the pairs of a camera of the query and a camera of an earlier keyframe that may show the same things."""
        angles, limit = np.zeros((len(self._views), len(self._views))), np.inf
        if self._graph is not None and len(self._views) > 1:
            T_keyframe_query = between(self._graph.T_W_B[keyframe.id], self._graph.T_W_B[self._query.id])
            angles = camera_angles(T_keyframe_query, self._rotations)
            path_m = self._graph.path_between(keyframe.id, self._query.id)
            limit = _OVERLAP_RAD + self._config.gate_rad + self._config.gate_rad_m * path_m
        return [(camera, taken_by) for taken_by, camera in np.argwhere(angles <= limit).tolist()]

    def _match(self, keyframe: Keyframe, camera: int, taken_by: int) -> Int[np.ndarray, "k 2"]:
        """Match the query's image by `camera` to the landmarks that the camera `taken_by` of a keyframe saw."""
        key = keyframe.id, camera, taken_by
        if key not in self._matches:
            view = keyframe.views[taken_by]
            rows = np.flatnonzero(view.landmarks.feature_ids >= 0)
            landmarks = view.features.descriptors[view.landmarks.feature_ids[rows]]
            matches = mutual_matches(self._views[camera].features.descriptors, landmarks, self._config.ratio)
            self._matches[key] = np.stack([matches[:, 0], rows[matches[:, 1]]], axis=1)
        return self._matches[key]

    def _fit(self, seen: _Seen) -> _Fit:
        """Return the pose of the query with which most key points of all cameras agree, refined for a rig."""
        rig = self._camera.rig
        if len(rig) == 1:
            return self._with_inliers(seen, (self._solved(seen[0], rig[0]),))
        enough = [i for i, each in enumerate(seen) if each.size >= _LEAST_MATCHES]
        poses = [rig[i].T_B_C @ self._solved(seen[i], rig[i]) for i in enough]
        fits = [self._with_inliers(seen, self._in_cameras(T_B_match)) for T_B_match in poses]
        if not fits or not (best := max(fits, key=lambda fit: fit.size)).size:
            return _Fit((), tuple(each[np.zeros(0, int)] for each in seen))
        T_B_match = rig[0].T_B_C @ best.T_C_match[0]
        T_B_match = refine_rig_pose([(each.pixels, each.points) for each in best.seen], rig, T_B_match)
        refined = self._with_inliers(seen, self._in_cameras(T_B_match))
        return max(refined, best, key=lambda fit: fit.size)

    def _solved(self, seen: _Correspondences, camera: Camera) -> Pose:
        limit_px, seed = self._config.max_reprojection_px, self._config.seed
        return solve_pnp(seen.pixels, seen.points, camera.intrinsics, limit_px, seed)

    def _in_cameras(self, T_B_match: Pose) -> tuple[Pose, ...]:
        return tuple(np.asarray(inverse(camera.T_B_C) @ T_B_match) for camera in self._camera.rig)

    def _with_inliers(self, seen: _Seen, T_C_match: tuple[Pose, ...]) -> _Fit:
        """Return the pose with its inliers, the correspondences that agree with it.

        The solver's own inliers are not used, because they may belong to an earlier pose than the returned pose.
        """
        limit_px = self._config.max_reprojection_px
        inliers = (
            each[inlier_rows(transform(T, each.points), each.pixels, camera.intrinsics, limit_px)]
            for each, T, camera in zip(seen, T_C_match, self._camera.rig, strict=True)
        )
        return _Fit(T_C_match, tuple(inliers))


def _occupied_cells(seen: _Correspondences, camera: Camera) -> int:
    """Return the number of cells of the image grid that contain an inlier."""
    size = camera.intrinsics.width, camera.intrinsics.height
    cells = np.floor((seen.pixels + 0.5) / size * _GRID)
    return len(np.unique(np.clip(cells, 0, _GRID - 1), axis=0))


def _covariance(fit: _Fit, camera: Camera, config: VerificationConfig) -> Covariance:
    """Return the covariance of ``T_match_query`` [rad², m²].

    It follows from the reprojections of the inliers, with a constant added for the error that all landmarks share. An inlier
    that is matched several times counts once.
    """
    information = np.zeros((6, 6))
    for each, T_C_match, taken_by in zip(fit.seen, fit.T_C_match, camera.rig, strict=True):
        _, first = np.unique(each.feature_ids, return_index=True)
        jacobian = _ray_jacobian(transform(T_C_match, each.points)[first], taken_by)
        information = information + jacobian.T @ jacobian / config.ray_sigma_rad**2
    floor = np.repeat([config.rotation_sigma_rad, config.translation_sigma_m], 3) ** 2
    return np.linalg.inv(information + 1e-9 * np.eye(6)) + np.diag(floor)


def _ray_jacobian(points_C: Float64[np.ndarray, "i 3"], camera: Camera) -> Float64[np.ndarray, "rows 6"]:
    """Return the derivative, with respect to ``T_match_query``, of the directions to points.

    ``T_match_query`` is perturbed on the right, rotation first. A direction is the offset of a pixel from the principal
    point, divided by the focal lengths [about rad].
    """
    points_B = transform(camera.T_B_C, points_C)
    rotation = camera.T_B_C[:3, :3].T
    by_pose = np.concatenate([rotation @ skew(points_B), np.broadcast_to(-rotation, (len(points_B), 3, 3))], axis=2)
    focal = np.array([camera.intrinsics.fx, camera.intrinsics.fy])
    return np.asarray((project_jacobian(points_C, camera.intrinsics) @ by_pose / focal[:, None]).reshape(-1, 6))
