"""Figures of one method of place recognition on one walk: true and false matches, recall, and precision against recall."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.sparse import csr_array

from lexis.config import PlaceRecognitionConfig
from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD, MatchCounts, count_matches
from lexis.evaluation.relative import separation
from sim.baselines.places.place_method import Scores
from sim.bench.peers.place_walks import PlaceWalk

CANDIDATES = PlaceRecognitionConfig.candidates
"""Largest number of keyframes that a method proposes for a query, the default of LEXIS."""
REQUIRED = (1, 3, 5)
"""Numbers N of right matches that a true positive needs, and numbers of candidates among which recall looks."""
PLACES = ("opposite direction", "same room", "look-alike room", "other floor", "elsewhere")
"""The places of false matches. A match is in the opposite direction if it is within 1 m of the query and looks back within
0.5 rad. A look-alike room is another room of the query's label, on any floor. Each case excludes those before it."""


class Ranking(NamedTuple):
    """The candidates for every query of a walk, best first; entries without a candidate have the score -inf."""

    keyframes: Int[np.ndarray, "n candidates"]
    scores: Float64[np.ndarray, "n candidates"]


@dataclass(frozen=True)
class MatchRow:
    """Figures of one method on one walk."""

    preset: str
    seed: int
    method: str
    tp_1: int
    """Number of true positives: queries with at least 1 right match among the candidates; see `count_matches`."""
    fp_1: int
    """Number of false positives: all other queries that were answered."""
    possible_1: int
    """Number of queries for which a right match exists."""
    tp_3: int
    fp_3: int
    possible_3: int
    tp_5: int
    fp_5: int
    possible_5: int
    false_opposite: int
    """Number of false positives at N = 1 whose best match is in this place; see `PLACES`. The five numbers sum to `fp_1`."""
    false_same_room: int
    false_look_alike: int
    false_other_floor: int
    false_elsewhere: int
    recall_at_1: float | None
    """Share of the queries with a right match for which it is the first candidate, if all queries are answered; None if no
    query has a right match."""
    recall_at_3: float | None
    recall_at_5: float | None


FALSE_FIELDS = ("false_opposite", "false_same_room", "false_look_alike", "false_other_floor", "false_elsewhere")
"""Fields of `MatchRow` in the order of `PLACES`."""


@dataclass(frozen=True, eq=False)
class PlaceFigures:
    """A row of figures, and what the curve of precision against recall is made of."""

    row: MatchRow
    best: Float64[np.ndarray, "n"]
    """Score of the best match of every query; -inf without a match."""
    right: Bool[np.ndarray, "n"]
    """Whether the best match is right."""
    hits: Int[np.ndarray, "n"]
    """Number of right matches among the candidates of every query, if all queries are answered."""

    @property
    def answered(self) -> int:
        """Number of queries that were answered."""
        return self.row.tp_1 + self.row.fp_1

    def counts_of(self, answered: int) -> tuple[MatchCounts, ...]:
        """Return the counts at N = 1, 3 and 5 if only this number of queries is answered: those with the best scores.

        Queries without any candidate cannot be answered, so that fewer may be.
        """
        hits = self.hits[np.argsort(-self.best, kind="stable")[: min(answered, int(np.isfinite(self.best).sum()))]]
        possible = (self.row.possible_1, self.row.possible_3, self.row.possible_5)
        found = [int((hits >= n).sum()) for n in REQUIRED]
        return tuple(MatchCounts(tp, len(hits) - tp, each) for tp, each in zip(found, possible, strict=True))


@dataclass(frozen=True, eq=False)
class PrecisionRecall:
    """Precision and recall of best matches while the least score falls from the highest score to the lowest."""

    precision: Float64[np.ndarray, "k"]
    recall: Float64[np.ndarray, "k"]

    @property
    def at_full_precision(self) -> float:
        """Largest recall without a false match."""
        return float(self.recall[self.precision == 1.0].max(initial=0.0))

    @property
    def average_precision(self) -> float:
        """Area under the curve: the mean of the precision over the recall; 0 where the recall is not reached."""
        return float((self.precision * np.diff(self.recall, prepend=0.0)).sum())


def ranked(scores: Scores, count: int = CANDIDATES) -> Ranking:
    """Rank the keyframes for every query, and keep the first `count`; of equal scores, the earlier keyframe is first."""
    first = np.argsort(-scores, axis=1, kind="stable")[:, :count]
    return Ranking(first, np.take_along_axis(scores, first, axis=1))


def answers(ranking: Ranking, least: float) -> list[tuple[int, tuple[int, ...]]]:
    """Return every query with the keyframes proposed for it; none if the best score is below `least`."""
    proposed = np.isfinite(ranking.scores) & (ranking.scores[:, :1] >= least)
    return [(query, tuple(ids[proposed[query]].tolist())) for query, ids in enumerate(ranking.keyframes)]


def figures(walk: PlaceWalk, method: str, scores: Scores, least: float) -> PlaceFigures:
    """Judge the answers of a method to all queries of a walk, with the least score at which it answers."""
    ranking, eligible = ranked(scores), walk.seen.eligible
    given = answers(ranking, least)
    counts = [count_matches(given, csr_array(walk.right & eligible), n) for n in REQUIRED]
    rows = np.arange(len(scores))
    hits = walk.right[rows[:, None], ranking.keyframes] & np.isfinite(ranking.scores)
    false = np.array([bool(ids) for _, ids in given]) & ~hits.any(axis=1)
    where = np.bincount(whereabouts(walk, rows[false], ranking.keyframes[false, 0]), minlength=len(PLACES))
    possible = (walk.right & eligible).any(axis=1)
    recall = [float(hits[possible, :n].any(axis=1).mean()) if possible.any() else None for n in REQUIRED]
    numbers = [number for each in counts for number in (each.tp, each.fp, each.possible)]
    row = MatchRow(walk.preset, walk.seed, method, *numbers, *where.tolist(), *recall)
    return PlaceFigures(row, ranking.scores[:, 0], hits[:, 0], hits.sum(axis=1))


def whereabouts(walk: PlaceWalk, queries: Int[np.ndarray, "m"], matches: Int[np.ndarray, "m"]) -> Int[np.ndarray, "m"]:
    """Return where each false match is, as an index into `PLACES`."""
    distances, angles = separation(walk.T_W_B[queries], walk.T_W_B[matches])
    cases = (
        (distances <= PLACE_M) & (angles >= np.pi - PLACE_RAD),
        walk.rooms[queries] == walk.rooms[matches],
        walk.labels[queries] == walk.labels[matches],
        walk.storeys[queries] != walk.storeys[matches],
    )
    return np.select(cases, range(len(cases)), default=len(cases))


def precision_recall(found: Sequence[PlaceFigures]) -> PrecisionRecall:
    """Return precision against recall of the best matches of all queries, pooled over walks.

    Recall is the share of the queries with a right match whose best match is right.
    """
    best, right = (np.concatenate([getattr(each, name) for each in found]) for name in ("best", "right"))
    order = np.argsort(-best, kind="stable")[: int(np.isfinite(best).sum())]
    true = np.cumsum(right[order])
    last = is_last_of_equal(best[order])
    precision = true / np.arange(1, len(order) + 1)
    recall = true / max(sum(each.row.possible_1 for each in found), 1)
    return PrecisionRecall(precision[last], recall[last])


def is_last_of_equal(scores: Float64[np.ndarray, "k"]) -> Bool[np.ndarray, "k"]:
    """Return which of some sorted scores differ from the next one. Queries with equal scores are answered together."""
    return np.append(scores[:-1] != scores[1:], True)[: len(scores)]
