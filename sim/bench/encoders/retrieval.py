"""Recall@1: whether the keyframe most like a revisit was taken at the same place."""

import numpy as np
from jaxtyping import Bool, Float, Float64, Int

from lexis.evaluation.loops import REVISIT_S, true_revisits
from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD
from lexis.evaluation.relative import separation
from lexis.types import Poses


def found_at_1(
    descriptors: Float[np.ndarray, "n d"],
    T_W_B: Poses,
    stamps: Float64[np.ndarray, "n"],
    groups: Int[np.ndarray, "n"] | None = None,
) -> Bool[np.ndarray, "revisits"]:
    """Of every revisit, whether its best match is within 1 m and 0.5 rad.

    Queries are keyframes near one at least 10 s earlier (the contract's revisits); candidates are all keyframes of the house
    but those within 10 s of the query.

    Args:
        descriptors: of every keyframe, unit norm, compared by cosine.
        T_W_B: true poses.
        stamps: [s].
        groups: with them, candidates are those of the query's group alone, as LEXIS seeks in rooms of one label; a query
            without any is a miss.
    """
    queries = true_revisits(T_W_B, stamps)
    eligible = np.abs(stamps[queries, None] - stamps[None, :]) >= REVISIT_S
    if groups is not None:
        eligible &= groups[queries, None] == groups[None, :]
    best = np.where(eligible, descriptors[queries] @ descriptors.T, -np.inf).argmax(axis=1)
    return np.asarray(_same_place(T_W_B, queries, best) & eligible.any(axis=1))


def share(found: Bool[np.ndarray, "n"]) -> float | None:
    """How many of them; None of none."""
    return float(found.mean()) if len(found) else None


def _same_place(T_W_B: Poses, a: Int[np.ndarray, "q"], b: Int[np.ndarray, "q"]) -> Bool[np.ndarray, "q"]:
    metres, radians = separation(T_W_B, a, b)
    return np.asarray((metres <= PLACE_M) & (radians <= PLACE_RAD))
