"""Accuracy of place recognition: the counts of true and false positives in the paper's Fig. 5."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from lexis.evaluation.relative import pairs_within, separation
from lexis.types import Poses

PLACE_M, PLACE_RAD = 1.0, 0.5
"""Largest distance [m] and angle [rad] between the true poses of a query and a right match."""


@dataclass(frozen=True)
class Counts:
    """Numbers of place recognition queries by outcome: true positives, false positives, and possible true positives."""

    tp: int
    """Number of true positives: queries with at least N right matches, where N is the argument `n` of `count_matches`."""
    fp: int
    """Number of false positives: all other queries for which a match was proposed."""
    possible: int
    """Number of queries that could be true positives, because at least N of the keyframes that are old enough are right
    matches."""

    def __add__(self, other: "Counts") -> "Counts":
        """Return the counts of two sets of queries together."""
        return Counts(self.tp + other.tp, self.fp + other.fp, self.possible + other.possible)

    @property
    def precision(self) -> float | None:
        """Share of true positives among all positives; None without positives."""
        return self.tp / (self.tp + self.fp) if self.tp + self.fp else None


def at_one_place(T_W_B: Poses) -> Bool[np.ndarray, "n n"]:
    """Whether each pair of true poses is within 1 m and 0.5 rad."""
    first, second = pairs_within(T_W_B, PLACE_M)
    near = np.zeros((len(T_W_B), len(T_W_B)), bool)
    near[first, second] = separation(T_W_B, first, second)[1] <= PLACE_RAD
    return near


def count_matches(
    candidates: Sequence[tuple[int, Sequence[int]]],
    eligible: Bool[np.ndarray, "n n"],
    right: Bool[np.ndarray, "n n"],
    n: int,
) -> Counts:
    """Count true and false positives among the queries, at N = `n` required matches.

    The paper: "If N matches were situated within a distance/angle threshold, we counted it as a true positive; otherwise, a
    false positive". Here, a query is a true positive if at least N of all matches proposed for it are right. It is a false
    positive otherwise, also if fewer than N matches were proposed. A query without proposals counts as neither. Most queries
    of a walk are at a place for the first time and cannot be true positives; `Counts.possible` counts those that can. A
    proposed keyframe that is not old enough, such as the query itself, is not right, and a keyframe that is proposed twice
    counts once.

    Args:
        candidates: the query keyframes, each with the keyframes proposed for it.
        eligible: for every keyframe as the query (rows), whether each keyframe (columns) is old enough to be proposed.
        right: for every pair of keyframes, whether they are at the same place; see `at_one_place`.
        n: the number N; 1, 3 and 5 in the paper.
    """
    right = right & eligible
    found = [int(right[query, list(set(proposed))].sum()) for query, proposed in candidates if len(proposed)]
    there = right.sum(axis=1)[[query for query, _ in candidates]]
    tp = sum(count >= n for count in found)
    return Counts(tp, len(found) - tp, possible=int((there >= n).sum()))
