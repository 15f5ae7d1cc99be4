"""Whether proposed matches are at the query's place: the counts of the paper's Fig. 5."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexis.evaluation.relative import separation
from lexis.types import Poses

PLACE_M, PLACE_RAD = 1.0, 0.5
"""A match is right within this distance and angle of the query's true pose."""


@dataclass(frozen=True)
class Counts:
    """Queries by outcome."""

    tp: int
    fp: int


def count_matches(candidates: Sequence[tuple[int, Sequence[int]]], T_W_B: Poses, n: int) -> Counts:
    """True and false positives at N = `n`: is a query backed by at least N right matches?

    "If N matches were situated within a distance/angle threshold, we counted it as a true positive; otherwise, a false
    positive": a query with at least N right matches among all that were proposed for it is a TP. A query for which nothing
    was proposed makes no claim and counts as neither; one with fewer than N proposals cannot have N right ones and is an FP.

    Args:
        candidates: of every query keyframe, the keyframes proposed.
        T_W_B: true poses of all keyframes.
        n: the paper takes 1, 3 and 5.
    """
    right = [_right(query, proposed, T_W_B) for query, proposed in candidates if len(proposed)]
    tp = sum(count >= n for count in right)
    return Counts(tp, len(right) - tp)


def _right(query: int, proposed: Sequence[int], T_W_B: Poses) -> int:
    distance, angle = separation(T_W_B, np.full(len(proposed), query), np.asarray(proposed))
    return int(np.count_nonzero((distance <= PLACE_M) & (angle <= PLACE_RAD)))
