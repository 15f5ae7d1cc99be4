"""Geometric verification of loop candidates by PnP (paper, Sec. III-D).

For each candidate of a query keyframe:

1. Match the query's key points to the landmarks of the candidate and of its neighbours on the path; one keyframe alone has
   too few landmarks.
2. Find the query's pose by PnP with LO-RANSAC, since many matches are wrong.
3. Require enough inliers, spread over the image: a poster or another repeated object matches in one spot only.
4. Estimate the covariance of the pose, and refuse a pose whose position the landmarks leave too uncertain.
5. Refuse a loop too far from the current estimate, because odometry drifts only little per metre.
6. Keep the loops with the most inliers, up to `max_edges` per query.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
import poselib
from jaxtyping import Float64, Int

from lexis.config import VerificationConfig
from lexis.features import mutual_matches
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.projection import project, project_jacobian
from lexis.maths.se3 import between, inverse, rotation_angle, skew, transform
from lexis.maths.ties import rounded
from lexis.types import Camera, Covariance, Intrinsics, Keyframe, LoopEdge, Pose, Verdict

_GRID = 6
"""Number of cells along each side of the image, for measuring the spread of inliers."""
_RANSAC = {"min_iterations": 100, "max_iterations": 5000}
"""Numbers of samples that RANSAC draws; the upper limit bounds the time for a false candidate. 5000 samples suffice if one
match in eight is right."""


@dataclass(frozen=True, eq=False)
class _Correspondences:
    """Matches between key points of the query and landmarks; a key point may occur several times."""

    feature_ids: Int[np.ndarray, "k"]
    """Row of every matched key point in the query's features."""
    points: Float64[np.ndarray, "k 3"]
    """Positions of the landmarks in the candidate's body frame [m]."""


@dataclass(frozen=True, eq=False)
class Verification:
    """The loop edges from a new keyframe, and what became of every candidate."""

    edges: tuple[LoopEdge, ...]
    """The confirmed loop edges, those with the most inliers first."""
    verdicts: tuple[Verdict, ...] = ()
    """One verdict for every candidate, in the order of the candidates. A verifier may leave the verdicts out."""


@runtime_checkable
class Verifier(Protocol):
    """A function that confirms or rejects the loop candidates of a new keyframe: `verify`, or one in its place."""

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseGraph, camera: Camera, config: VerificationConfig, /
    ) -> Verification:
        """Return the confirmed loop edges; see `verify` for the arguments and the result."""
        ...


def verify(
    query: Keyframe, candidates: Sequence[int], graph: PoseGraph, camera: Camera, config: VerificationConfig
) -> Verification:
    """Return loop edges from a new keyframe to the candidates that pass verification, and a verdict on each candidate.

    A candidate passes if PnP confirms the loop and the loop is close enough to the current estimate of the poses.

    Args:
        query: the new keyframe, already in the graph.
        candidates: ids of earlier keyframes.
        graph: the keyframes and the current estimate of their poses.
        camera: the camera of all keyframes.
        config: thresholds, and the largest number of edges to return.
    """
    located = Locator(query, graph.keyframes, camera, config)
    return plausible([located.from_match(match) for match in candidates], graph, config)


def plausible(
    located: Sequence[tuple[Verdict, LoopEdge | None]], graph: PoseGraph, config: VerificationConfig
) -> Verification:
    """Keep the loop edges of one new keyframe that are close to the current estimate of the poses.

    At most `max_edges` are kept, those with the most inliers first.

    Args:
        located: for every candidate, the verdict so far, and the loop edge if the candidate has been accepted.
        graph: the current estimate of the poses.
        config: the tolerances, and the largest number of edges.
    """
    judged = [(verdict if edge is None else _compared(verdict, edge, graph, config), edge) for verdict, edge in located]
    fitting = [edge for verdict, edge in judged if edge is not None and verdict.outcome == "accepted"]
    kept = sorted(fitting, key=lambda edge: -edge.inliers)[: config.max_edges]
    surplus = {edge.match for edge in fitting} - {edge.match for edge in kept}
    verdicts = (replace(verdict, outcome="surplus") if verdict.match in surplus else verdict for verdict, _ in judged)
    return Verification(tuple(kept), tuple(verdicts))


def _compared(verdict: Verdict, edge: LoopEdge, graph: PoseGraph, config: VerificationConfig) -> Verdict:
    """Refuse a loop that is far from the current estimate.

    The tolerance grows with the path between the two keyframes, as drift does.
    """
    estimated = between(graph.T_W_B[edge.match], graph.T_W_B[edge.query])
    path_m = graph.path_between(edge.match, edge.query)
    distance = float(np.linalg.norm(edge.T_match_query[:3, 3] - estimated[:3, 3]))
    angle = float(rotation_angle(between(edge.T_match_query, estimated)))
    near = distance <= config.gate_m + config.gate_share * path_m
    fits = near and angle <= config.gate_rad + config.gate_rad_m * path_m
    outcome = verdict.outcome if fits else "far from the estimate"
    return replace(verdict, outcome=outcome, misfit_m=distance, misfit_rad=angle)


class Locator:
    """Computes loop edges from one query keyframe to candidates by PnP.

    Descriptor matches are cached, because neighbouring candidates share landmarks.
    """

    def __init__(self, query: Keyframe, keyframes: Sequence[Keyframe], camera: Camera, config: VerificationConfig) -> None:
        self._query = query
        self._keyframes = keyframes
        self._camera = camera
        self._config = config
        self._matches: dict[int, Int[np.ndarray, "k 2"]] = {}

    def from_match(self, match: int) -> tuple[Verdict, LoopEdge | None]:
        """Judge the candidate with the id `match`, by PnP with the landmarks of the candidate and its neighbours.

        The loop edge is None if too few key points match, too few of them are inliers, the inliers cover too little of the
        image, or the position is too uncertain.
        """
        config, intrinsics = self._config, self._camera.intrinsics
        seen = self._correspondences(match)
        verdict = Verdict(self._query.id, match, "few matches", matches=len(np.unique(seen.feature_ids)))
        if len(np.unique(seen.feature_ids)) < config.min_inliers:
            return verdict, None
        pixels = self._query.features.keypoints[seen.feature_ids].astype(np.float64)
        T_C_match = _solve_pnp(pixels, seen.points, intrinsics, config)
        points_C = transform(T_C_match, seen.points)
        inliers = _inliers(points_C, pixels, intrinsics, config.max_reprojection_px)
        unique, first = np.unique(seen.feature_ids[inliers], return_index=True)
        cells = _occupied_cells(pixels[inliers], intrinsics)
        verdict = replace(verdict, inliers=len(unique), cells=cells)
        if len(unique) < config.min_inliers:
            return replace(verdict, outcome="few inliers"), None
        if cells < config.min_cells:
            return replace(verdict, outcome="crowded inliers"), None
        T_match_query = inverse(T_C_match) @ inverse(self._camera.T_B_C)
        covariance = _covariance(points_C[inliers][first], self._camera, config)
        if np.linalg.eigvalsh(covariance[3:, 3:])[-1] > config.max_sigma_m**2:
            return replace(verdict, outcome="uncertain position"), None
        edge = LoopEdge(self._query.id, match, T_match_query, covariance, len(unique))
        return replace(verdict, outcome="accepted"), edge

    def _correspondences(self, match: int) -> _Correspondences:
        """Match the query to the landmarks of the candidate and its neighbours.

        Odometry gives the positions of the neighbours' landmarks in the candidate's frame. The query is matched to each
        keyframe separately. If it were matched to all landmarks together, two landmarks of the same physical point would
        have similar descriptors and fail the ratio test.
        """
        pool = range(max(match - self._config.pool, 0), min(match + self._config.pool + 1, self._query.id))
        ids, points = [], []
        for keyframe in (self._keyframes[neighbour] for neighbour in pool):
            if keyframe.session != self._keyframes[match].session:
                continue
            T_match_neighbour = between(self._keyframes[match].T_O_B, keyframe.T_O_B)
            pairs = self._match(keyframe)
            ids.append(pairs[:, 0])
            points.append(transform(T_match_neighbour, keyframe.landmarks.points[pairs[:, 1]]))
        # The points are rounded, because their last digits depend on the processor and may change the result of RANSAC.
        return _Correspondences(np.concatenate(ids), rounded(np.concatenate(points)))

    def _match(self, keyframe: Keyframe) -> Int[np.ndarray, "k 2"]:
        if keyframe.id not in self._matches:
            rows = np.flatnonzero(keyframe.landmarks.feature_ids >= 0)
            landmarks = keyframe.features.descriptors[keyframe.landmarks.feature_ids[rows]]
            matches = mutual_matches(self._query.features.descriptors, landmarks, self._config.ratio)
            self._matches[keyframe.id] = np.stack([matches[:, 0], rows[matches[:, 1]]], axis=1)
        return self._matches[keyframe.id]


def _solve_pnp(
    pixels: Float64[np.ndarray, "k 2"],
    points: Float64[np.ndarray, "k 3"],
    intrinsics: Intrinsics,
    config: VerificationConfig,
) -> Pose:
    """Return the camera pose ``T_C_match`` that most correspondences agree with, by LO-RANSAC."""
    camera = {
        "model": "PINHOLE",
        "width": intrinsics.width,
        "height": intrinsics.height,
        "params": [intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy],
    }
    ransac = {"max_reproj_error": config.max_reprojection_px, "seed": config.seed, **_RANSAC}
    solution, _ = poselib.estimate_absolute_pose(pixels, points, camera, ransac)
    T_C_match = np.eye(4)
    T_C_match[:3, :3], T_C_match[:3, 3] = solution.R, solution.t
    return T_C_match


def _inliers(
    points_C: Float64[np.ndarray, "k 3"], pixels: Float64[np.ndarray, "k 2"], intrinsics: Intrinsics, limit_px: float
) -> Int[np.ndarray, "i"]:
    """Return the rows of the correspondences that agree with the pose.

    The solver's own inliers are not used, because they may belong to an earlier pose than the returned pose.
    """
    in_front = points_C[:, 2] > 0
    safe = np.where(in_front[:, None], points_C, [0.0, 0.0, 1.0])
    errors = np.linalg.norm(project(safe, intrinsics) - pixels, axis=1)
    return np.flatnonzero(in_front & (errors <= limit_px))


def _occupied_cells(pixels: Float64[np.ndarray, "i 2"], intrinsics: Intrinsics) -> int:
    """Return the number of cells of the image grid that contain an inlier."""
    cells = np.floor((pixels + 0.5) / [intrinsics.width, intrinsics.height] * _GRID)
    return len(np.unique(np.clip(cells, 0, _GRID - 1), axis=0))


def _covariance(points_C: Float64[np.ndarray, "i 3"], camera: Camera, config: VerificationConfig) -> Covariance:
    """Return the covariance of ``T_match_query`` [rad², m²].

    It follows from the reprojections of the inliers, with a constant added for the error that all landmarks share.
    """
    points_B = transform(camera.T_B_C, points_C)
    rotation = camera.T_B_C[:3, :3].T
    # Derivative of the points in C by a perturbation of T_match_query on the right, rotation first.
    by_pose = np.concatenate([rotation @ skew(points_B), np.broadcast_to(-rotation, (len(points_B), 3, 3))], axis=2)
    jacobian = (project_jacobian(points_C, camera.intrinsics) @ by_pose).reshape(-1, 6)
    information = jacobian.T @ jacobian / config.pixel_sigma**2
    floor = np.repeat([config.rotation_sigma_rad, config.translation_sigma_m], 3) ** 2
    return np.linalg.inv(information + 1e-9 * np.eye(6)) + np.diag(floor)
