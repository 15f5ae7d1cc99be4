"""Place recognition of LEXIS behind the interface of its baselines: by the probability of a revisit, and as in the paper.

LEXIS uses the poses that it estimates, which no other method here is given.
"""

from dataclasses import dataclass, field

import numpy as np

from lexis.config import PlaceRecognitionConfig
from lexis.place_recognition import revisit_log_odds
from sim.baselines.places.by_embedding import cosines
from sim.baselines.places.place_method import Scores, SeenKeyframes


@dataclass(frozen=True)
class RevisitProbability:
    """Scores keyframes by the log odds of a revisit, the default method of LEXIS.

    LEXIS itself leaves out very improbable keyframes; here, they fill up the candidates of a query that is answered.
    """

    config: PlaceRecognitionConfig = field(default_factory=PlaceRecognitionConfig)

    def scores(self, seen: SeenKeyframes) -> Scores:
        """See `PlaceMethod.scores`; a score is the logarithm of odds."""
        scores, (rows, columns) = np.full(seen.eligible.shape, -np.inf), np.nonzero(seen.eligible & seen.active)
        pairs = cosines(seen)[rows, columns], seen.estimated_m[rows, columns], seen.estimated_rad[rows, columns]
        scores[rows, columns] = revisit_log_odds(*pairs, self.config)
        return scores


@dataclass(frozen=True)
class LabelledRoom:
    """Scores the keyframes of the closest room that has the query's label by cosine similarity, as in the paper."""

    def scores(self, seen: SeenKeyframes) -> Scores:
        """See `PlaceMethod.scores`; a score is a cosine similarity."""
        return np.where(seen.in_room, seen.only_eligible(cosines(seen)), -np.inf)
