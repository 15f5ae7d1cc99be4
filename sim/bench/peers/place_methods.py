"""`lexis-sim bench fig5`: LEXIS and other methods of place recognition on the same rendered walks (the paper's Fig. 5).

Every method proposes up to ten earlier keyframes for each keyframe, or none if the best of them has a low score.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from operator import add
from types import MappingProxyType

import numpy as np
from scipy.special import logit

from lexis.config import PlaceRecognitionConfig
from lexis.evaluation.place_recognition import MatchCounts
from sim.baselines.places.bag_of_words import BagOfWords
from sim.baselines.places.by_embedding import EmbeddingSimilarity, SequenceMatching
from sim.baselines.places.descriptors import training_descriptors
from sim.baselines.places.lexis_places import LabelledRoom, RevisitProbability
from sim.baselines.places.place_method import PlaceMethod
from sim.baselines.places.vlad import Kind, Vlad
from sim.baselines.places.word_tree import WordTree
from sim.bench.peers.own_methods import scores_on
from sim.bench.peers.place_figures import FALSE_FIELDS, REQUIRED, PlaceFigures, PrecisionRecall, figures, precision_recall
from sim.bench.peers.place_walks import PlaceWalk
from sim.bench.row_files import mean_and_std

_SEED = 5
ORB_LEVELS = 5
"""Number of levels of the vocabulary tree of ORB words: the best of 3 to 5. With ten branches per node, there are 100 000
words."""


@dataclass(frozen=True)
class Contestant:
    """A method of place recognition with its settings."""

    make: Callable[[], PlaceMethod]
    """Makes the method; its vocabulary is learned then."""
    least: float
    """Least score of the best keyframe at which the method answers a query."""


@lru_cache(maxsize=8)
def word_tree(depth: int) -> WordTree:
    """Return the vocabulary tree of training images, with ten branches per node."""
    return WordTree.learned(training_descriptors().orb, np.random.default_rng(_SEED), depth=depth)


@lru_cache(maxsize=8)
def vlad(words: int, dims: int, kind: Kind = "akaze") -> Vlad:
    """Return VLAD with words and whitening of training images."""
    return Vlad.learned(getattr(training_descriptors(), kind), np.random.default_rng(_SEED), words, dims, kind)


def bag_of_words(depth: int, **settings: object) -> BagOfWords:
    """Return DBoW2's scheme with a vocabulary tree of training images; see `BagOfWords` for the settings."""
    return BagOfWords(word_tree(depth), **settings)  # type: ignore[arg-type]


METHODS: Mapping[str, Contestant] = MappingProxyType(
    {
        "LEXIS": Contestant(RevisitProbability, float(logit(PlaceRecognitionConfig.least_probability))),
        "LEXIS, stricter": Contestant(RevisitProbability, 2.276),
        "LEXIS, by room": Contestant(LabelledRoom, 0.896),
        "embedding": Contestant(EmbeddingSimilarity, 0.910),
        "embedding sequences": Contestant(partial(SequenceMatching, length=5), 0.867),
        "ORB words": Contestant(partial(bag_of_words, ORB_LEVELS, normalised=False, consistent=None), 0.0759),
        "ORB words, DBoW2": Contestant(
            partial(bag_of_words, ORB_LEVELS, consistent=1, gap=6, normalised=False, least=0.02), 0.0760
        ),
        "AKAZE VLAD": Contestant(partial(vlad, 16, 0), 0.271),
        "patch VLAD": Contestant(partial(vlad, 128, 0, kind="patches"), 0.430),
    }
)
"""Methods with the settings that `place_tuning` found on other houses: `lexis-sim bench fig5 --tune` with the homes 100 to
104 and the offices (ori) 100 and 101, but those of patch VLAD on the homes 100 and 101 and the office 100 alone. The first
one has the defaults of LEXIS instead, which answer more queries because a false candidate costs LEXIS a verification
only."""


_NO_CONTESTANTS: Mapping[str, Contestant] = MappingProxyType({})


def compare_place_methods(
    walks: Iterable[PlaceWalk], own: Mapping[str, Contestant] = _NO_CONTESTANTS
) -> Iterator[PlaceFigures]:
    """Let every method of `METHODS`, and then the methods `own` of the user, answer the queries of the same walks.

    Raises `OwnMethodError`, which names the house, if one of `own` raises an exception, or returns what is not valid.
    """
    contestants = {**METHODS, **own}
    methods = {name: each.make() for name, each in contestants.items()}
    for walk in walks:
        for name, method in methods.items():
            yield figures(walk, name, scores_on(walk, method), contestants[name].least)


@dataclass(frozen=True)
class PlaceTotal:
    """Figures of one method over all walks of a preset: counts are sums; recalls are means over walks with revisits."""

    counts: tuple[MatchCounts, ...]
    """Counts for N = 1, 3 and 5."""
    false_places: tuple[int, ...]
    """Numbers of false positives at N = 1 by the place of the best match; see `PLACES`."""
    recalls: tuple[float | None, ...]
    """Recall among the first 1, 3 and 5 candidates, if all queries are answered; None without a revisit."""
    curve: PrecisionRecall
    """Precision against recall over the queries of all walks."""


def equally_often(found: Sequence[PlaceFigures]) -> dict[str, dict[str, tuple[MatchCounts, ...]]]:
    """Count the matches of LEXIS if it answers as many queries of each walk as each other method, by preset and method.

    LEXIS answers the queries of which it is most certain. With equally many answers, a method with more true matches has
    fewer false ones, so that neither method gains by the choice of its least score. The counts are for N = 1, 3 and 5,
    and summed over walks. The figures `found` are in the order of `compare_place_methods`: LEXIS is first for every walk.
    """
    lexis = next(iter(METHODS))
    sums: dict[str, dict[str, tuple[MatchCounts, ...]]] = {}
    for each in found:
        if each.row.method == lexis:
            own = each
            continue
        methods = sums.setdefault(each.row.preset, {})
        before = methods.get(each.row.method, (MatchCounts(0, 0, 0),) * len(REQUIRED))
        methods[each.row.method] = tuple(map(add, before, own.counts_of(each.answered)))
    return sums


def totals(found: Sequence[PlaceFigures]) -> dict[str, dict[str, PlaceTotal]]:
    """Sum up the walks, by preset and method."""
    groups: dict[str, dict[str, list[PlaceFigures]]] = {}
    for each in found:
        groups.setdefault(each.row.preset, {}).setdefault(each.row.method, []).append(each)
    return {preset: {name: _total(mine) for name, mine in methods.items()} for preset, methods in groups.items()}


def _total(found: Sequence[PlaceFigures]) -> PlaceTotal:
    def of(name: str) -> list[int]:
        return [getattr(each.row, name) for each in found]

    counts = tuple(MatchCounts(*(sum(of(f"{name}_{n}")) for name in ("tp", "fp", "possible"))) for n in REQUIRED)
    false = tuple(sum(of(name)) for name in FALSE_FIELDS)
    recalls = tuple(mean_and_std(getattr(each.row, f"recall_at_{n}") for each in found)[0] for n in REQUIRED)
    return PlaceTotal(counts, false, recalls, precision_recall(found))
