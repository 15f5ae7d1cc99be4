"""Accuracy of predicted room instances. All metrics compare two partitions of the same keyframes.

An instance is an integer id; the true id of a keyframe is the id of the room in which the camera was. Keyframes with a
negative predicted id belong to no predicted instance, but they count in the sizes of the true ones. A room without
keyframes, for example because frames were lost, therefore enters none of these metrics, not even `count_error`. The number
of such rooms is given by `coverage` in result.json.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from lexis.evaluation.partitions import iou, overlap

Instances = Int[np.ndarray, "n"]

MATCH_IOU = 0.5
"""IoU above which a predicted and a true instance match; at 0.5, each instance has at most one match."""
SHARE = 0.5
"""An instance lies mostly in an instance of the other partition if more than this share of its keyframes are in the
latter."""


@dataclass(frozen=True)
class RoomScores:
    """Metrics of room instances; the field `rooms` of result.json.

    All metrics are None if there are fewer than 2 keyframes, because these cannot be grouped wrongly.
    """

    pq: float | None
    """Panoptic quality: the sum of the IoUs of matches, divided by the number of matches plus half the number of unmatched
    instances, true or predicted."""
    precision: float | None
    """Share of predicted instances with a match (IoU > 0.5); None if there are no predicted instances."""
    recall: float | None
    """Share of true instances with a match (IoU > 0.5)."""
    hydra_precision: float | None
    """Precision as defined by Hydra: for each predicted instance, the largest share of its keyframes that are in one true
    instance; the mean over the predicted instances, or None if there are none."""
    hydra_recall: float | None
    """Recall as defined by Hydra: for each true instance, the largest share of its keyframes that are in one predicted
    instance; the mean over the true instances."""
    ari: float | None
    """Adjusted Rand index: agreement on pairs of keyframes, 0 for chance and 1 for equal partitions. A keyframe without a
    predicted instance counts as an instance of its own."""
    v_measure: float | None
    """V-measure: the harmonic mean of the homogeneity and the completeness of the predicted instances. A keyframe without a
    predicted instance counts as an instance of its own."""
    splits: int | None
    """Number of surplus predicted instances: if several predicted instances lie mostly (more than half) in the same true
    instance, all but one of them are surplus."""
    merges: int | None
    """Number of surplus true instances: if several true instances lie mostly (more than half) in the same predicted
    instance, all but one of them are surplus."""
    count_error: int | None
    """Predicted minus true number of instances with keyframes."""


def score_rooms(predicted: Instances, truth: Instances) -> RoomScores:
    """Compute all metrics of a predicted partition of keyframes into rooms; -1 in `predicted` stands for no room."""
    if len(truth) < 2:
        return RoomScores(*[None] * 10)
    whole = overlap(predicted, truth)
    is_room = np.unique(predicted) >= 0
    table, sizes = whole[is_room], whole.sum(axis=0, keepdims=True)
    ious = iou(table, sizes)
    matched = ious[ious > MATCH_IOU]
    p, t = table.shape
    covered_of_predicted = table / table.sum(axis=1, keepdims=True)
    covered_of_true = table / sizes
    pairs = overlap(each_alone(predicted), truth)
    return RoomScores(
        pq=float(matched.sum() / (len(matched) + (p - len(matched)) / 2 + (t - len(matched)) / 2)),
        precision=len(matched) / p if p else None,
        recall=len(matched) / t,
        hydra_precision=float(covered_of_predicted.max(axis=1).mean()) if p else None,
        hydra_recall=float(covered_of_true.max(axis=0, initial=0.0).mean()),
        ari=adjusted_rand_index(pairs),
        v_measure=v_measure(pairs),
        splits=_count_beyond_first(covered_of_predicted > SHARE, axis=0),
        merges=_count_beyond_first(covered_of_true > SHARE, axis=1),
        count_error=p - t,
    )


def each_alone(instances: Instances) -> Instances:
    """Return the instances with a different negative id for every keyframe that is in none."""
    return np.where(instances < 0, -1 - np.arange(len(instances)), instances)


def adjusted_rand_index(table: Int[np.ndarray, "p t"]) -> float:
    """Hubert and Arabie's adjusted Rand index of two partitions, from the table of `overlap`.

    It is 1 if both partitions consist of a single instance, or if both put every keyframe into an instance of its own.
    """
    together, in_predicted, in_truth = _pairs(table), _pairs(table.sum(axis=1)), _pairs(table.sum(axis=0))
    expected = in_predicted * in_truth / max(_pairs(table.sum(keepdims=True)), 1.0)
    largest = (in_predicted + in_truth) / 2
    return (together - expected) / (largest - expected) if largest != expected else 1.0


def v_measure(table: Int[np.ndarray, "p t"]) -> float:
    """Rosenberg and Hirschberg's V-measure (beta = 1) of two partitions, from the table of `overlap`."""
    predicted, truth = _entropy(table.sum(axis=1)), _entropy(table.sum(axis=0))
    mutual = predicted + truth - _entropy(table.ravel())
    homogeneity = mutual / truth if truth > 0 else 1.0
    completeness = mutual / predicted if predicted > 0 else 1.0
    total = homogeneity + completeness
    return float(2 * homogeneity * completeness / total) if total > 0 else 0.0


def _count_beyond_first(belongs: Bool[np.ndarray, "p t"], axis: int) -> int:
    return int(np.maximum(belongs.sum(axis=axis) - 1, 0).sum())


def _pairs(counts: Int[np.ndarray, "..."]) -> float:
    """Return the number of pairs of keyframes within groups of the given sizes."""
    return float((counts * (counts - 1) / 2.0).sum())


def _entropy(counts: Int[np.ndarray, "k"]) -> float:
    shares = counts[counts > 0] / counts.sum()
    return max(-math.fsum(shares * np.log(shares)), 0.0)
