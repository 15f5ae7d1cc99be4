"""Laws of all methods of place recognition: they find revisits, propose old keyframes only, and ignore the future."""

import numpy as np
import pytest
from helpers.two_laps import PLACES, first_keyframes, replace_embeddings, two_laps

from sim.baselines import places
from sim.baselines.places import (
    BagOfWords,
    EmbeddingSimilarity,
    LabelledRoom,
    RevisitProbability,
    SequenceMatching,
    Vlad,
    WordTree,
)


@pytest.fixture(scope="module")
def methods():
    training = two_laps(np.random.default_rng(1))
    tree = WordTree.learned(training.orb, np.random.default_rng(2), depth=2)
    return {
        "embedding": EmbeddingSimilarity(),
        "sequence": SequenceMatching(length=4),
        "sequence with contrast": SequenceMatching(length=3, contrast=8),
        "words": BagOfWords(tree, consistent=None, normalised=False),
        "words with islands": BagOfWords(tree, gap=2, consistent=1, least=0.02, normalised=False),
        "VLAD": Vlad.learned(training.akaze, np.random.default_rng(2), words=8, dims=0),
        "patch VLAD": Vlad.learned(training.patches, np.random.default_rng(2), words=8, dims=0, kind="patches"),
        "probability": RevisitProbability(),
        "room": LabelledRoom(),
    }


NAMES = (
    "embedding", "sequence", "sequence with contrast", "words", "words with islands", "VLAD", "patch VLAD", "probability",
    "room",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_the_second_lap_finds_the_first(name, methods, rng):
    scores = methods[name].scores(two_laps(rng))[PLACES + 4 :]
    assert (scores.argmax(axis=1) == np.arange(4, PLACES)).mean() >= 0.9


@pytest.mark.parametrize("name", NAMES)
def test_only_eligible_keyframes_are_proposed(name, methods, rng):
    seen = two_laps(rng)
    assert np.isneginf(methods[name].scores(seen)[~seen.eligible]).all()


@pytest.mark.parametrize("name", NAMES)
def test_later_keyframes_do_not_change_earlier_answers(name, methods, rng):
    seen, count = two_laps(rng), PLACES + 6
    beginning = methods[name].scores(first_keyframes(seen, count))
    np.testing.assert_allclose(methods[name].scores(seen)[:count, :count], beginning, rtol=1e-5, atol=1e-6)


def test_contrast_compares_with_eligible_keyframes_only(rng):
    seen, method = two_laps(rng), SequenceMatching(length=1, contrast=3)
    query = PLACES + 4
    others = np.flatnonzero(~seen.eligible[query])  # the query, those just before it, and all later ones
    changed = seen.embeddings.copy()
    changed[others[others != query]] *= -1.0
    found, other = method.scores(seen)[query], method.scores(replace_embeddings(seen, changed))[query]
    np.testing.assert_allclose(found[seen.eligible[query]], other[seen.eligible[query]])


def test_all_exported_methods_are_tested(methods):
    exported = {name for name in places.__all__ if hasattr(getattr(places, name), "scores")} - {"PlaceMethod"}
    assert {type(methods[name]).__name__ for name in NAMES} == exported
