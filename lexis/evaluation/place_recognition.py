"""Accuracy of place recognition: the counts of true and false positives in the paper's Fig. 5."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from lexis.evaluation.relative import separation
from lexis.types import Poses

PLACE_M, PLACE_RAD = 1.0, 0.5
"""Largest distance [m] and angle [rad] between the true poses of a query and a right match."""


@dataclass(frozen=True)
class Counts:
    """Numbers of queries by outcome."""

    tp: int
    """True positives."""
    fp: int
    """False positives."""
    possible: int
    """Queries that could be true positives, because at least N right matches exist among the eligible keyframes."""


def count_matches(
    candidates: Sequence[tuple[int, Sequence[int]]], eligible: Bool[np.ndarray, "n n"], T_W_B: Poses, n: int
) -> Counts:
    """Count true and false positives among the queries, at N = `n` required matches.

    The paper: "If N matches were situated within a distance/angle threshold, we counted it as a true positive; otherwise, a
    false positive". Here, a query is a true positive if at least N of all matches proposed for it are right. It is a false
    positive otherwise, also if fewer than N matches were proposed. A query without proposals counts as neither. Most queries
    of a walk are at a place for the first time, so only `possible` of them can be true positives.

    Args:
        candidates: the query keyframes, each with the keyframes proposed for it.
        eligible: for every keyframe as the query (rows), whether each keyframe is old enough to be proposed.
        T_W_B: true poses of all keyframes.
        n: the number N; 1, 3 and 5 in the paper.
    """
    right = [len(_at_the_place(query, np.asarray(proposed), T_W_B)) for query, proposed in candidates if len(proposed)]
    there = [len(_at_the_place(query, np.flatnonzero(eligible[query]), T_W_B)) for query, _ in candidates]
    tp = sum(count >= n for count in right)
    return Counts(tp, len(right) - tp, possible=sum(count >= n for count in there))


def _at_the_place(query: int, others: Int[np.ndarray, "m"], T_W_B: Poses) -> Int[np.ndarray, "k"]:
    """The keyframes among `others` whose true pose is within 1 m and 0.5 rad of the query's."""
    near = others[np.linalg.norm(T_W_B[others, :3, 3] - T_W_B[query, :3, 3], axis=1) <= PLACE_M]
    _, angle = separation(T_W_B, np.full(len(near), query), near)
    return np.asarray(near[angle <= PLACE_RAD])
