"""Sequences of embeddings: one keyframe is the plain similarity, and longer ones tell look-alike places apart."""

import numpy as np
from helpers.two_laps import PLACES, replace_embeddings, two_laps

from sim.baselines.places import EmbeddingSimilarity, SequenceMatching


def test_a_sequence_of_one_keyframe_is_the_cosine_similarity(rng):
    seen = two_laps(rng)
    one = SequenceMatching(length=1).scores(seen)
    np.testing.assert_allclose(one, EmbeddingSimilarity().scores(seen))


def test_a_sequence_tells_places_apart_that_look_exactly_alike(rng):
    seen = two_laps(rng, noise=0.05)
    embeddings = seen.embeddings.copy()
    twins, query = (3, 10), PLACES + 10
    embeddings[[*twins, query]] = embeddings[3]
    alike = replace_embeddings(seen, embeddings)
    single, sequence = (method.scores(alike)[query] for method in (EmbeddingSimilarity(), SequenceMatching(length=4)))
    assert np.isclose(single[twins[0]], single[twins[1]]) and sequence.argmax() == twins[1]
    assert sequence[twins[1]] > sequence[twins[0]] + 0.3


def test_a_walk_at_another_speed_is_found_along_a_steeper_path(rng):
    seen = two_laps(rng, noise=0.0)
    embeddings = seen.embeddings.copy()
    embeddings[PLACES : PLACES + 7] = embeddings[0:PLACES:2]  # the second time, keyframes are twice as far apart
    fast = replace_embeddings(seen, embeddings)
    same, double = (SequenceMatching(5, speeds=(speed,)).scores(fast)[PLACES + 6, 12] for speed in (1.0, 2.0))
    assert np.isclose(double, 1.0, atol=1e-5) and same < 0.7
