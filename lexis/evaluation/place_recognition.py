"""Whether proposed matches are at the query's place: the counts of the paper's Fig. 5."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from lexis.evaluation.relative import separation
from lexis.types import Poses

PLACE_M, PLACE_RAD = 1.0, 0.5
"""A match is right within this distance and angle of the query's true pose."""


@dataclass(frozen=True)
class Counts:
    """Queries by outcome."""

    tp: int
    fp: int
    possible: int
    """Queries that could be true positives: at least N keyframes that may be proposed are at their place."""


def count_matches(
    candidates: Sequence[tuple[int, Sequence[int]]], eligible: Bool[np.ndarray, "n n"], T_W_B: Poses, n: int
) -> Counts:
    """True and false positives at N = `n`: is a query backed by at least N right matches?

    "If N matches were situated within a distance/angle threshold, we counted it as a true positive; otherwise, a false
    positive": a query with at least N right matches among all that were proposed for it is a TP. A query for which nothing
    was proposed makes no claim and counts as neither; one with fewer than N proposals cannot have N right ones and is an FP.
    Most queries of a walk are at a place for the first time, so that only `possible` of them can be TPs at all.

    Args:
        candidates: of every query keyframe, the keyframes proposed.
        eligible: row per query keyframe: which keyframes are old enough to be proposed.
        T_W_B: true poses of all keyframes.
        n: the paper takes 1, 3 and 5.
    """
    right = [len(_at_the_place(query, np.asarray(proposed), T_W_B)) for query, proposed in candidates if len(proposed)]
    there = [len(_at_the_place(query, np.flatnonzero(eligible[query]), T_W_B)) for query, _ in candidates]
    tp = sum(count >= n for count in right)
    return Counts(tp, len(right) - tp, possible=sum(count >= n for count in there))


def _at_the_place(query: int, others: Int[np.ndarray, "m"], T_W_B: Poses) -> Int[np.ndarray, "k"]:
    """Those of the other keyframes that are within 1 m and 0.5 rad of the query's true pose."""
    near = others[np.linalg.norm(T_W_B[others, :3, 3] - T_W_B[query, :3, 3], axis=1) <= PLACE_M]
    _, angle = separation(T_W_B, np.full(len(near), query), near)
    return np.asarray(near[angle <= PLACE_RAD])
