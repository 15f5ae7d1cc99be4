"""`lexis-sim bench fig5 --tune`: the settings and the least scores with which methods of place recognition do best.

The benchmark uses settings that were found on other houses than those of its figures.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from sim.baselines.places.by_embedding import EmbeddingSimilarity, SequenceMatching
from sim.baselines.places.lexis_places import LabelledRoom, RevisitProbability
from sim.baselines.places.place_method import PlaceMethod
from sim.bench.peers.own_methods import scores_on
from sim.bench.peers.place_figures import REQUIRED, is_last_of_equal, ranked
from sim.bench.peers.place_methods import bag_of_words, vlad
from sim.bench.peers.place_walks import PlaceWalk

Axis = Sequence[Mapping[str, Any]]
"""Choices of one or more settings. The first choice is the start of the search."""
_ISLANDS = tuple(
    {"consistent": consistent, "gap": gap, "normalised": normalised, "least": least}
    for consistent in (1, 0, 3)
    for gap in (3, 6)
    for normalised, least in ((True, 0.3), (True, 0.1), (False, 0.1), (False, 0.05), (False, 0.02))
)
"""Choices for the islands of DBoW2. Their least scores depend on whether scores are normalised."""


@dataclass(frozen=True)
class SettingsSearch:
    """A method and the settings that are tried."""

    make: Callable[..., PlaceMethod]
    """Makes the method with given settings."""
    axes: Sequence[Axis] = ()


@dataclass(frozen=True)
class Tuned:
    """The best settings of one method."""

    method: str
    settings: Mapping[str, Any]
    least: float
    """Least score of the best keyframe at which the method answers a query."""
    f1: float
    """Mean of the F1 scores at N = 1, 3 and 5, over all queries of the walks."""


def _each(name: str, *values: object) -> Axis:
    return [{name: value} for value in values]


SEARCHES: Mapping[str, SettingsSearch] = MappingProxyType(
    {
        "LEXIS, stricter": SettingsSearch(RevisitProbability),
        "LEXIS, by room": SettingsSearch(LabelledRoom),
        "embedding": SettingsSearch(EmbeddingSimilarity),
        "embedding sequences": SettingsSearch(
            SequenceMatching, (_each("length", 5, 2, 3, 8, 12), _each("contrast", 0, 10, 30, 100))
        ),
        "ORB words": SettingsSearch(
            partial(bag_of_words, consistent=None),
            (_each("depth", 4, 3, 5), _each("features", 1000, 500), _each("normalised", True, False)),
        ),
        "ORB words, DBoW2": SettingsSearch(bag_of_words, (_each("depth", 5, 4), _ISLANDS)),
        "AKAZE VLAD": SettingsSearch(vlad, (_each("words", 64, 8, 16, 32, 128), _each("dims", 128, 0, 64, 256))),
        "patch VLAD": SettingsSearch(
            partial(vlad, kind="patches"), (_each("words", 128, 64, 256, 512), _each("dims", 0, 128))
        ),
    }
)
"""The search for each method of `METHODS` that has something to tune."""


def tune(walks: Sequence[PlaceWalk], searches: Mapping[str, SettingsSearch] | None = None) -> Iterator[Tuned]:
    """Tune each method on walks, one axis of its settings after the other.

    `searches` holds what is tried, by the name of the method. None or empty: `SEARCHES`. Raises `OwnMethodError`, which
    names the house, if a method of the user's own raises an exception, or returns what is not valid.
    """
    for name, search in (searches or SEARCHES).items():
        settings = {key: value for axis in search.axes for key, value in axis[0].items()}
        least, f1 = best_least(search.make(**settings), walks)
        for axis in search.axes:
            for choice in axis[1:]:
                tried = {**settings, **choice}
                other_least, other_f1 = best_least(search.make(**tried), walks)
                if other_f1 > f1:
                    settings, least, f1 = tried, other_least, other_f1
        yield Tuned(name, settings, least, f1)


def best_least(method: PlaceMethod, walks: Sequence[PlaceWalk]) -> tuple[float, float]:
    """Find the least score for answers that has the largest mean F1 score, and return it with this F1 score."""
    rankings = [(walk, ranked(scores_on(walk, method))) for walk in walks]
    best = np.concatenate([ranking.scores[:, 0] for _, ranking in rankings])
    hits = np.concatenate(
        [
            (np.take_along_axis(walk.right, ranking.keyframes, axis=1) & np.isfinite(ranking.scores)).sum(axis=1)
            for walk, ranking in rankings
        ]
    )
    there = np.concatenate([(walk.right & walk.seen.eligible).sum(axis=1) for walk in walks])
    order = np.argsort(-best, kind="stable")[: int(np.isfinite(best).sum())]
    if not len(order):
        return np.inf, 0.0
    answered = np.arange(1, len(order) + 1)
    f1 = np.mean([2 * np.cumsum(hits[order] >= n) / (answered + (there >= n).sum()) for n in REQUIRED], axis=0)
    f1 = np.where(is_last_of_equal(best[order]), f1, 0.0)
    return float(best[order][f1.argmax()]), float(f1.max())
