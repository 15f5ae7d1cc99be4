"""Recall@1 of place recognition: whether the keyframe most similar to a revisit was taken at the same place."""

import numpy as np
from jaxtyping import Bool, Float, Float64, Int

from lexis.evaluation.loops import REVISIT_S, true_revisits
from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD
from lexis.evaluation.relative import separation
from lexis.maths.ties import reaches
from lexis.types import Poses


def found_at_1(
    similarities: Float[np.ndarray, "n n"],
    T_W_B: Poses,
    stamps: Float64[np.ndarray, "n"],
    groups: Int[np.ndarray, "n"] | None = None,
) -> Bool[np.ndarray, "revisits"]:
    """Return for each revisit whether its best match is within 1 m and 0.5 rad of it.

    The queries are the revisits: keyframes within 1 m and 0.5 rad of a keyframe at least 10 s earlier (as defined by
    `lexis.evaluation.loops.true_revisits`). The candidates are all keyframes of the house except those within 10 s of the
    query.

    Args:
        similarities: similarities of all pairs of keyframes; the match with the largest one is the best.
        T_W_B: true poses.
        stamps: time stamps [s].
        groups: if given, the candidates are restricted to the query's group, such as the
            keyframes of one label; a query without candidates counts as not found.
    """
    queries = true_revisits(T_W_B, stamps)
    eligible = reaches(np.abs(stamps[queries, None] - stamps[None, :]), REVISIT_S)
    if groups is not None:
        eligible &= groups[queries, None] == groups[None, :]
    best = np.where(eligible, similarities[queries], -np.inf).argmax(axis=1)
    return np.asarray(_same_place(T_W_B, queries, best) & eligible.any(axis=1))


def share(found: Bool[np.ndarray, "n"]) -> float | None:
    """Return the share of true entries; None for an empty array."""
    return float(found.mean()) if len(found) else None


def _same_place(T_W_B: Poses, a: Int[np.ndarray, "q"], b: Int[np.ndarray, "q"]) -> Bool[np.ndarray, "q"]:
    metres, radians = separation(T_W_B[a], T_W_B[b])
    return np.asarray((metres <= PLACE_M) & (radians <= PLACE_RAD))
