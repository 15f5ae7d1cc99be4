"""How well predicted room instances are the true ones. All figures compare two partitions of the same keyframes.

An instance is an integer id; the true id of a keyframe is that of the room that holds the camera. So a room that was walked
through without a keyframe, where frames were lost say, is in none of these figures, `count_error` included: how many rooms
those are is told by `coverage` of result.json.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from lexis.evaluation.partitions import iou, overlap

Instances = Int[np.ndarray, "n"]

MATCH_IOU = 0.5
"""Above it, at most one partner exists on either side, so that the matching is unique."""
SHARE = 0.5
"""A room that gives a cluster less than this share of itself, or fills less of it, is no split or merge there."""


@dataclass(frozen=True)
class RoomScores:
    """`rooms` of result.json. All figures are None for fewer than 2 keyframes, which cannot be grouped wrongly."""

    pq: float | None
    """Panoptic quality: the sum of matched IoU over (matches + half of the unmatched on both sides)."""
    precision: float | None
    """Share of predicted instances that are matched one to one at IoU > 0.5."""
    recall: float | None
    """Share of true instances that are."""
    hydra_precision: float | None
    """Hydra's: for every predicted instance, the largest share of it that one true instance covers; their mean."""
    hydra_recall: float | None
    """Hydra's: for every true instance, the largest share of it that one predicted instance covers; their mean."""
    ari: float | None
    """Adjusted Rand index: agreement on pairs of keyframes, 0 for chance and 1 for equal partitions."""
    v_measure: float | None
    """Harmonic mean of homogeneity and completeness."""
    splits: int | None
    """Predicted instances beyond the first that lie mostly (> half) in one and the same true instance."""
    merges: int | None
    """True instances beyond the first that lie mostly (> half) in one and the same predicted instance."""
    count_error: int | None
    """Predicted minus true number of instances, of those that hold keyframes."""


def score_rooms(predicted: Instances, truth: Instances) -> RoomScores:
    """All figures of a partition of keyframes into rooms against the true one."""
    if len(truth) < 2:
        return RoomScores(*[None] * 10)
    table = overlap(predicted, truth)
    ious = iou(table)
    matched = ious[ious > MATCH_IOU]
    p, t = table.shape
    covered_of_predicted = table / table.sum(axis=1, keepdims=True)
    covered_of_true = table / table.sum(axis=0, keepdims=True)
    return RoomScores(
        pq=float(matched.sum() / (len(matched) + (p - len(matched)) / 2 + (t - len(matched)) / 2)),
        precision=len(matched) / p,
        recall=len(matched) / t,
        hydra_precision=float(covered_of_predicted.max(axis=1).mean()),
        hydra_recall=float(covered_of_true.max(axis=0).mean()),
        ari=adjusted_rand_index(table),
        v_measure=v_measure(table),
        splits=_surplus(covered_of_predicted > SHARE, axis=0),
        merges=_surplus(covered_of_true > SHARE, axis=1),
        count_error=p - t,
    )


def adjusted_rand_index(table: Int[np.ndarray, "p t"]) -> float:
    """Hubert and Arabie's index of two partitions, from their overlap; 1 where both are trivial in the same way."""
    together, in_predicted, in_truth = _pairs(table), _pairs(table.sum(axis=1)), _pairs(table.sum(axis=0))
    expected = in_predicted * in_truth / max(_pairs(table.sum(keepdims=True)), 1.0)
    largest = (in_predicted + in_truth) / 2
    return (together - expected) / (largest - expected) if largest != expected else 1.0


def v_measure(table: Int[np.ndarray, "p t"]) -> float:
    """Rosenberg and Hirschberg's V-measure (beta = 1) of two partitions, from their overlap."""
    predicted, truth = _entropy(table.sum(axis=1)), _entropy(table.sum(axis=0))
    mutual = predicted + truth - _entropy(table.ravel())
    homogeneity = mutual / truth if truth > 0 else 1.0
    completeness = mutual / predicted if predicted > 0 else 1.0
    total = homogeneity + completeness
    return float(2 * homogeneity * completeness / total) if total > 0 else 0.0


def _surplus(belongs: Bool[np.ndarray, "p t"], axis: int) -> int:
    return int(np.maximum(belongs.sum(axis=axis) - 1, 0).sum())


def _pairs(counts: Int[np.ndarray, "..."]) -> float:
    """Pairs of keyframes within groups of these sizes."""
    return float((counts * (counts - 1) / 2.0).sum())


def _entropy(counts: Int[np.ndarray, "k"]) -> float:
    shares = counts[counts > 0] / counts.sum()
    return max(-math.fsum(shares * np.log(shares)), 0.0)
