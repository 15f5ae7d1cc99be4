"""Accuracy of place recognition: the counts of true and false positives in the paper's Fig. 5."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.sparse import csr_array

from lexis.config import PlaceRecognitionConfig
from lexis.evaluation.relative import pairs_within, separation
from lexis.place_recognition import is_old_enough
from lexis.types import Poses

PLACE_M, PLACE_RAD = 1.0, 0.5
"""Largest distance [m] and angle [rad] between the true poses of a query and a right match."""


@dataclass(frozen=True)
class MatchCounts:
    """Numbers of place recognition queries by outcome: true positives, false positives, and possible true positives."""

    tp: int
    """Number of true positives: queries with at least N right matches, where N is the argument `n` of `count_matches`."""
    fp: int
    """Number of false positives: all other queries for which a match was proposed."""
    possible: int
    """Number of keyframes that could be true positives, because at least N of the keyframes that are old enough are right
    matches."""

    def __add__(self, other: "MatchCounts") -> "MatchCounts":
        """Return the counts of two sets of queries together."""
        return MatchCounts(self.tp + other.tp, self.fp + other.fp, self.possible + other.possible)

    @property
    def precision(self) -> float | None:
        """Share of true positives among all positives; None without positives."""
        return self.tp / (self.tp + self.fp) if self.tp + self.fp else None


def at_one_place(T_W_B: Poses) -> Bool[np.ndarray, "n n"]:
    """Whether each pair of true poses is within 1 m and 0.5 rad."""
    first, second = pairs_within(T_W_B, PLACE_M)
    near = np.zeros((len(T_W_B), len(T_W_B)), bool)
    near[first, second] = separation(T_W_B[first], T_W_B[second])[1] <= PLACE_RAD
    return near


def right_matches(
    T_W_B: Poses, stamps: Float64[np.ndarray, "n"], path_m: Float64[np.ndarray, "n"], config: PlaceRecognitionConfig
) -> tuple[Int[np.ndarray, "m"], Int[np.ndarray, "m"]]:
    """Queries and their right matches, as indices of all such pairs in order.

    A right match is within 1 m and 0.5 rad of the query by the true poses, and old enough to be proposed; see
    `is_old_enough` for the stamps [s], the odometry path `path_m` up to each pose [m], and `config`. Memory grows with the
    number of pairs within 1 m, and not with the number of all pairs.
    """
    query, match = pairs_within(T_W_B, PLACE_M)
    old = is_old_enough(stamps[query] - stamps[match], path_m[query] - path_m[match], config)
    query, match = query[old], match[old]
    near = separation(T_W_B[query], T_W_B[match])[1] <= PLACE_RAD
    return query[near], match[near]


def count_matches(candidates: Sequence[tuple[int, Sequence[int]]], right: csr_array, n: int) -> MatchCounts:
    """Count true and false positives among the queries, at N = `n` required matches.

    The paper: "If N matches were situated within a distance/angle threshold, we counted it as a true positive; otherwise, a
    false positive". Here, a query is a true positive if at least N of all matches proposed for it are right. It is a false
    positive otherwise, also if fewer than N matches were proposed. A query without proposals counts as neither, whether
    `candidates` lists it or not. Most keyframes of a walk are at a place for the first time and cannot be true positives;
    `MatchCounts.possible` counts those that can, among all rows of `right`. A proposed keyframe that is not old enough, such
    as the query itself, is not right, and a keyframe that is proposed twice counts once.

    Args:
        candidates: the query keyframes, each once, with the keyframes proposed for it.
        right: sparse matrix that is not zero where a keyframe (column) is a right match of a query (row), and old enough.
        n: the number N; 1, 3 and 5 in the paper.
    """
    right_of = np.split(right.indices, right.indptr[1:-1])
    found = [len(set(proposed) & set(right_of[query].tolist())) for query, proposed in candidates if len(proposed)]
    tp = sum(count >= n for count in found)
    return MatchCounts(tp, len(found) - tp, possible=int((np.diff(right.indptr) >= n).sum()))
