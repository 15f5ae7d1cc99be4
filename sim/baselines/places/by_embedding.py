"""Place recognition by the embedding of the vision-language model alone: global descriptor retrieval, and sequences.

`EmbeddingSimilarity` compares single images. `SequenceMatching` compares the last keyframes with earlier stretches of the
walk, as SeqSLAM does (Milford and Wyeth, ICRA 2012).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from sim.baselines.places.place_method import Scores, SeenKeyframes

_LEAST_SPREAD = 0.02
"""Is added to standard deviations of similarities, so that a stretch of equal images does not enlarge small differences."""


@dataclass(frozen=True)
class EmbeddingSimilarity:
    """Scores keyframes by the cosine similarity of their embeddings with the query's."""

    def scores(self, seen: SeenKeyframes) -> Scores:
        """See `PlaceMethod.scores`; a score is a cosine similarity."""
        return seen.only_eligible(cosines(seen))


@dataclass(frozen=True)
class SequenceMatching:
    """Scores keyframes by the mean similarity along the best straight path through the matrix of similarities.

    The path ends at the query and the keyframe. SeqSLAM compares image differences; here, embeddings are compared. Keyframes
    are equally spaced, so speeds differ little. A path that would begin before the walk is cut off there.
    """

    length: int = 5
    """Number of keyframes in a sequence, the query included."""
    speeds: tuple[float, ...] = (0.8, 0.9, 1.0, 1.1, 1.2)
    """Ratios of the speed on the earlier walk to the speed now."""
    contrast: int = 0
    """Number of eligible keyframes on either side by whose mean and standard deviation each similarity is normalised (the
    local contrast enhancement of SeqSLAM). 0: similarities are not normalised."""

    def scores(self, seen: SeenKeyframes) -> Scores:
        """See `PlaceMethod.scores`; a score is a mean similarity or, with contrast, a mean in standard deviations."""
        similarities = cosines(seen)
        if self.contrast:
            similarities = _enhanced(similarities, seen.eligible, self.contrast)
        return seen.only_eligible(np.max([self._along(similarities, speed) for speed in self.speeds], axis=0))

    def _along(self, similarities: Float64[np.ndarray, "n n"], speed: float) -> Float64[np.ndarray, "n n"]:
        """Return the mean similarity along paths of one speed that end at each pair of a query and an earlier keyframe."""
        total, count = np.zeros_like(similarities), np.zeros_like(similarities)
        for back in range(self.length):
            match_back = round(back * speed)
            rows, columns = len(similarities) - back, len(similarities) - match_back
            if rows > 0 and columns > 0:
                total[back:, match_back:] += similarities[:rows, :columns]
                count[back:, match_back:] += 1
        return np.asarray(total / count)


def cosines(seen: SeenKeyframes) -> Float64[np.ndarray, "n n"]:
    """Return the cosine similarities of the embeddings of all pairs of keyframes."""
    embeddings = seen.embeddings.astype(np.float64)
    return np.asarray(embeddings @ embeddings.T)


def _enhanced(
    similarities: Float64[np.ndarray, "n n"], eligible: Bool[np.ndarray, "n n"], reach: int
) -> Float64[np.ndarray, "n n"]:
    """Normalise each row by mean and standard deviation over the eligible keyframes in a window; others become 0."""
    n = len(similarities)
    values = np.where(eligible, similarities, 0.0)
    first, last = np.maximum(np.arange(n) - reach, 0), np.minimum(np.arange(n) + reach + 1, n)

    def windowed(rows: Float64[np.ndarray, "n n"]) -> Float64[np.ndarray, "n n"]:
        sums = np.pad(np.cumsum(rows, axis=1), ((0, 0), (1, 0)))
        return np.asarray(sums[:, last] - sums[:, first])

    count = np.maximum(windowed(eligible.astype(float)), 1.0)
    mean = windowed(values) / count
    spread = np.sqrt(np.maximum(windowed(values**2) / count - mean**2, 0.0)) + _LEAST_SPREAD
    return np.asarray(np.where(eligible, (similarities - mean) / spread, 0.0))
