"""Precision of loop edges, and their recall of true revisits."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD
from lexis.evaluation.relative import pairs_within, separation
from lexis.maths.se3 import between, rotation_angle
from lexis.maths.ties import reaches, rounded
from lexis.types import Poses

TRUE_M, TRUE_RAD = 0.5, 0.2
"""Largest errors of the relative pose of a true edge [m, rad]."""
REVISIT_S = 10.0
"""Least time between a revisit and an earlier keyframe of the same place [s]."""


@dataclass(frozen=True)
class LoopScores:
    """Metrics of loop closure; the field `loops` of result.json."""

    proposed: int
    """Number of pairs of query and candidate that were passed to verification."""
    verified: int
    """Number of proposed pairs that verification accepted as loop edges."""
    true: int
    """Number of loop edges within 0.5 m and 0.2 rad of the true relative pose."""
    false: int
    """Number of loop edges farther than 0.5 m or 0.2 rad from the true relative pose."""
    precision: float | None
    """Share of loop edges that are true; None without an edge."""
    recall: float | None
    """Share of true revisits from which at least one true loop edge leads to a keyframe at least 10 s earlier; None without
    a revisit."""
    error_m: float | None
    """Root mean square of the errors in position of the true edges [m]; None without one."""
    error_rad: float | None
    """Root mean square of the errors in rotation of the true edges [rad]; None without one."""


def score_loops(
    proposed: int,
    query: Int[np.ndarray, "m"],
    match: Int[np.ndarray, "m"],
    T_match_query: Float64[np.ndarray, "m 4 4"],
    T_W_B: Poses,
    stamps: Float64[np.ndarray, "n"],
) -> LoopScores:
    """Compute all metrics of loop closure.

    Args:
        proposed: number of pairs of query and candidate that were passed to verification.
        query: later keyframe of every edge.
        match: earlier keyframe of every edge.
        T_match_query: relative pose of every edge.
        T_W_B: true poses of all keyframes.
        stamps: stamps of all keyframes [s].
    """
    errors = _errors(query, match, T_match_query, T_W_B)
    is_true = within_limits(errors)
    revisits = true_revisits(T_W_B, stamps)
    joins_visits = reaches(stamps[query] - stamps[match], REVISIT_S)
    found = np.isin(revisits, query[is_true & joins_visits])
    return LoopScores(
        proposed=proposed,
        verified=len(query),
        true=int(is_true.sum()),
        false=int((~is_true).sum()),
        precision=float(is_true.mean()) if len(query) else None,
        recall=float(found.mean()) if len(revisits) else None,
        error_m=_root_mean_square(np.linalg.norm(errors[is_true, :3, 3], axis=1)),
        error_rad=_root_mean_square(rotation_angle(errors[is_true])),
    )


def true_edges(
    query: Int[np.ndarray, "m"], match: Int[np.ndarray, "m"], T_match_query: Float64[np.ndarray, "m 4 4"], T_W_B: Poses
) -> Bool[np.ndarray, "m"]:
    """Whether the relative pose of each edge is within 0.5 m and 0.2 rad of the truth."""
    return within_limits(_errors(query, match, T_match_query, T_W_B))


def within_limits(errors: Float64[np.ndarray, "m 4 4"]) -> Bool[np.ndarray, "m"]:
    """Whether each edge is true, by the errors `T_true^-1 T_measured` of the relative poses."""
    off_m = rounded(np.linalg.norm(errors[:, :3, 3], axis=1))
    return np.asarray((off_m <= TRUE_M) & (rounded(rotation_angle(errors)) <= TRUE_RAD))


def true_revisits(T_W_B: Poses, stamps: Float64[np.ndarray, "n"]) -> Int[np.ndarray, "k"]:
    """Ids of the revisits: keyframes within 1 m and 0.5 rad of a keyframe at least 10 s earlier, by their true poses."""
    later, earlier = _close_pairs(T_W_B, stamps)
    _, angle = separation(T_W_B[later], T_W_B[earlier])
    return np.unique(later[angle <= PLACE_RAD])


def opposite_revisits(T_W_B: Poses, stamps: Float64[np.ndarray, "n"]) -> Int[np.ndarray, "k"]:
    """Ids of the keyframes at places seen before, but only from the opposite direction.

    By their true poses, these are keyframes within 1 m of a keyframe at least 10 s earlier whose heading is opposite to
    within 0.5 rad. Revisits in the same direction (`true_revisits`) do not count.
    """
    later, earlier = _close_pairs(T_W_B, stamps)
    _, angle = separation(T_W_B[later], T_W_B[earlier])
    return np.setdiff1d(later[angle >= np.pi - PLACE_RAD], true_revisits(T_W_B, stamps))


def opposite_edges(query: Int[np.ndarray, "m"], match: Int[np.ndarray, "m"], T_W_B: Poses) -> Bool[np.ndarray, "m"]:
    """Whether the body looks in opposite directions at the two ends of each edge: by more than a right angle."""
    return np.asarray(rotation_angle(between(T_W_B[match], T_W_B[query])) > np.pi / 2)


def _errors(
    query: Int[np.ndarray, "m"], match: Int[np.ndarray, "m"], T_match_query: Float64[np.ndarray, "m 4 4"], T_W_B: Poses
) -> Float64[np.ndarray, "m 4 4"]:
    """Return the error of the relative pose of each edge, `T_true^-1 T_measured`."""
    return np.asarray(between(between(T_W_B[match], T_W_B[query]), T_match_query))


def _root_mean_square(errors: Float64[np.ndarray, "k"]) -> float | None:
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else None


def _close_pairs(
    T_W_B: Poses, stamps: Float64[np.ndarray, "n"]
) -> tuple[Int[np.ndarray, "pairs"], Int[np.ndarray, "pairs"]]:
    """Return the later and the earlier keyframe of all pairs within 1 m of each other and at least 10 s apart."""
    later, earlier = pairs_within(T_W_B, PLACE_M)
    apart = reaches(stamps[later] - stamps[earlier], REVISIT_S)  # stamps are rounded
    return later[apart], earlier[apart]
