"""DBoW2's scheme: the L1 score, islands, and temporal consistency."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.two_laps import PLACES, two_laps

from sim.baselines.places import BagOfWords, WordTree
from sim.baselines.places.bag_of_words import l1_scores


@pytest.fixture(scope="module")
def tree():
    return WordTree.learned(two_laps(np.random.default_rng(1)).orb, np.random.default_rng(2), depth=3)


def test_the_score_is_one_minus_half_of_the_l1_distance(rng):
    histograms = rng.random((6, 20)) * (rng.random((6, 20)) < 0.4)
    histograms /= histograms.sum(axis=1, keepdims=True)
    distance = np.abs(histograms[:, None] - histograms[None]).sum(axis=2)
    np.testing.assert_allclose(l1_scores(histograms), np.tril(1.0 - distance / 2.0, -1), atol=1e-12)


def test_a_match_needs_consistent_matches_before_it(tree, rng):
    seen = two_laps(rng, flipped=0.0)
    broken = rng.integers(0, 256, (60, 32), np.uint8)
    seen = replace(seen, orb=tuple(broken if i == PLACES + 7 else each for i, each in enumerate(seen.orb)))
    for consistent in (0, 1, 3):
        method = BagOfWords(tree, consistent=consistent, normalised=False, least=0.9, gap=1)
        answered = np.flatnonzero(np.isfinite(method.scores(seen)).any(axis=1)) - PLACES
        expected = [*range(consistent, 7), *range(8 + consistent, PLACES)]
        assert answered.tolist() == expected


@pytest.mark.parametrize(("gap", "kept"), [(1, [10]), (2, [8, 10])])
def test_matches_within_the_gap_are_one_island_and_only_one_is_proposed(tree, rng, gap, kept):
    seen, query = two_laps(rng, flipped=0.0), PLACES + 10
    orb = list(seen.orb)
    orb[8] = np.concatenate([orb[query][:45], orb[8][:15]])  # the query's corners are seen two places before it, too
    method = BagOfWords(tree, consistent=0, gap=gap, least=0.6, normalised=False)
    assert np.flatnonzero(np.isfinite(method.scores(replace(seen, orb=tuple(orb)))[query])).tolist() == kept


def test_the_island_with_the_largest_sum_is_kept(tree, rng):
    seen, query = two_laps(rng, flipped=0.0), PLACES + 10
    orb = list(seen.orb)
    orb[1] = np.concatenate([orb[query][:45], orb[1][:15]])  # most of the query's corners are seen far away, too
    both = BagOfWords(tree, consistent=None, normalised=False).scores(replace(seen, orb=tuple(orb)))[query]
    kept = BagOfWords(tree, consistent=0, normalised=False, least=0.6, gap=1).scores(replace(seen, orb=tuple(orb)))[query]
    assert np.flatnonzero(both >= 0.6).tolist() == [1, 10] and np.flatnonzero(np.isfinite(kept)).tolist() == [10]


def test_a_normalised_score_is_relative_to_the_keyframe_before(tree, rng):
    seen = two_laps(rng)
    raw, normalised = (BagOfWords(tree, consistent=None, normalised=each).scores(seen) for each in (False, True))
    compared = l1_scores(tree.histograms(seen.orb))
    query = PLACES + 5
    expected = raw[query] / compared[query, query - 1]
    np.testing.assert_allclose(normalised[query, seen.eligible[query]], expected[seen.eligible[query]])
