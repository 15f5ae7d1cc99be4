"""Place recognition by ORB and a bag of binary words, the scheme of DBoW2 (Gálvez-López and Tardós, T-RO 2012, Sec. V).

1. Images are compared by the L1 score of their tf-idf histograms over the words of a vocabulary tree.
2. Scores are divided by the score of the query with the keyframe before it, which is what a good match can reach.
3. Matches that are close in the walk form an island. Only the island with the largest sum of scores is kept.
4. The island must overlap with the islands of the preceding queries (temporal consistency).

The geometric check that follows in DBoW2 is left out, because no method here verifies its matches.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from sim.baselines.places.place_method import Scores, SeenKeyframes
from sim.baselines.places.word_tree import WordTree

_LEAST_NEIGHBOUR = 0.005
"""A query whose score with the keyframe before it is smaller is not answered, as in DBoW2: the camera turned too fast."""


@dataclass(frozen=True, eq=False)
class BagOfWords:
    """Scores keyframes by the words that their images share with the query's."""

    tree: WordTree
    features: int = 1000
    """Number of ORB key points that are used of an image, the strongest ones."""
    normalised: bool = True
    """Whether scores are divided by the score of the query with the keyframe before it."""
    least: float = 0.3
    """Least score of a match in an island."""
    gap: int = 3
    """Largest difference between the numbers of neighbouring keyframes in an island, and between consistent islands."""
    consistent: int | None = 1
    """Number of preceding queries whose islands must be consistent with the query's. None: all keyframes are scored, without
    islands."""

    def scores(self, seen: SeenKeyframes) -> Scores:
        """See `PlaceMethod.scores`; a score is the L1 score or, normalised, about 1 for a perfect match."""
        every = seen.only_eligible(self._compared(seen))
        if self.consistent is None:
            return every
        scores, streak, before = np.full_like(every, -np.inf), 0, None
        for query, row in enumerate(every):
            island = self._best_island(row)
            if island is None:
                streak, before = 0, None
                continue
            follows = before is not None and island[0] <= before[1] + self.gap and before[0] <= island[1] + self.gap
            streak, before = streak + 1 if follows else 0, island
            if streak >= self.consistent:
                part = slice(island[0], island[1] + 1)
                scores[query, part] = np.where(row[part] >= self.least, row[part], -np.inf)
        return scores

    def _compared(self, seen: SeenKeyframes) -> Float64[np.ndarray, "n n"]:
        raw = _word_scores(self.tree, self.features, seen)
        if not self.normalised:
            return raw
        neighbour = np.append(0.0, raw.diagonal(-1))[:, None]
        return np.where(neighbour >= _LEAST_NEIGHBOUR, raw / np.maximum(neighbour, _LEAST_NEIGHBOUR), -np.inf)

    def _best_island(self, row: Float64[np.ndarray, "n"]) -> tuple[int, int] | None:
        """Return the first and the last keyframe of the island with the largest sum of scores; None without a match."""
        matches = np.flatnonzero(row >= self.least)
        if not matches.size:
            return None
        first = np.flatnonzero(np.diff(matches, prepend=-self.gap - 1) > self.gap)
        best = int(np.add.reduceat(row[matches], first).argmax())
        last = np.append(first[1:], len(matches))[best] - 1
        return int(matches[first[best]]), int(matches[last])


@lru_cache(maxsize=16)
def _word_scores(tree: WordTree, features: int, seen: SeenKeyframes) -> Float64[np.ndarray, "n n"]:
    """Return the scores of all pairs of images, and remember them, since other settings are tuned on the same scores."""
    return l1_scores(tree.histograms([descriptors[:features] for descriptors in seen.orb]))


def l1_scores(histograms: Float64[np.ndarray, "n words"]) -> Float64[np.ndarray, "n n"]:
    """Return the score of every histogram (rows) with all histograms before it.

    The score is 1 - |v - w| / 2, which is 1 for equal histograms.
    """
    scores = np.zeros((len(histograms), len(histograms)))
    for query, own in enumerate(histograms):
        words = np.flatnonzero(own)
        scores[query, :query] = np.minimum(histograms[:query, words], own[words]).sum(axis=1)
    return scores
