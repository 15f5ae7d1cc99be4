"""The vocabulary tree: similar descriptors share a word, common and unseen words weigh nothing, histograms have unit sum."""

import numpy as np
import pytest

from sim.baselines.places.word_tree import WordTree, nearest
from sim.errors import SimError


def drawn(rng, count):
    return rng.integers(0, 256, (count, 32), np.uint8)


def test_the_nearest_descriptor_has_the_fewest_different_bits(rng):
    first, second = drawn(rng, 40), drawn(rng, 9)
    different = np.bitwise_count(first[:, None] ^ second[None]).sum(axis=2)
    bits, rows = nearest(first, second)
    np.testing.assert_array_equal(bits, different.min(axis=1))
    np.testing.assert_array_equal(rows, different.argmin(axis=1))


def test_few_descriptors_are_words_of_their_own_and_many_share_words(rng):
    few = drawn(rng, 6)
    tree = WordTree.learned([few], rng, branching=3, depth=3)
    assert len(set(tree.words(few).tolist())) == 6
    many = drawn(rng, 500)
    words = WordTree.learned([many], rng, branching=3, depth=3).words(many)
    assert words.max() < 27 and 20 <= len(set(words.tolist())) <= 27


def test_descriptors_of_one_cluster_share_a_word_and_find_it_through_noise(rng):
    centres = drawn(rng, 16)
    noise = np.packbits(rng.random((16, 20, 256)) < 0.02, axis=-1)
    members = centres[:, None] ^ noise
    tree = WordTree.learned([members.reshape(-1, 32)], rng, branching=4, depth=2)
    words = tree.words(members.reshape(-1, 32)).reshape(16, 20)
    assert (words == tree.words(centres)[:, None]).mean() > 0.98  # a few descriptors lie on the border of two branches


def test_a_sample_of_descriptors_that_are_nearly_all_equal_has_words(rng):
    common, rare = drawn(rng, 1), drawn(rng, 10)
    descriptors = np.concatenate([np.repeat(common, 60_000, axis=0), rare])  # the sample leaves out most of the rare ones
    assert (WordTree.learned([descriptors], rng, branching=10, depth=1).levels[0] == common).all(axis=1).any()


def test_weights_are_inverse_document_frequencies_of_all_images(rng):
    images = [drawn(rng, 200) for _ in range(5)]
    tree = WordTree.learned(images, rng, branching=4, depth=2)
    having = np.array([[word in tree.words(image) for word in range(16)] for image in images]).sum(axis=0)
    assert having.all()
    np.testing.assert_allclose(tree.weights, np.log(5 / having))
    common = drawn(rng, 4)
    both = WordTree.learned([common, common], rng, branching=4, depth=1)
    assert not both.weights.any() and not both.histograms([common]).any()


def test_a_word_in_no_training_image_weighs_nothing_as_in_dbow2(rng):
    few = drawn(rng, 3)
    tree = WordTree.learned([few[:2], few[2:]], rng, branching=3, depth=2)
    unseen = np.setdiff1d(np.arange(9), tree.words(few))
    assert len(unseen) == 6 and not tree.weights[unseen].any()
    np.testing.assert_allclose(tree.weights[tree.words(few)], np.log(2))


def test_histograms_have_unit_sum_or_are_empty(rng):
    images = [drawn(rng, 30), np.zeros((0, 32), np.uint8), drawn(rng, 60)]
    histograms = WordTree.learned([drawn(rng, 20) for _ in range(6)], rng, branching=6, depth=2).histograms(images)
    np.testing.assert_allclose(histograms.sum(axis=1), (1.0, 0.0, 1.0))
    assert (histograms >= 0).all()


def test_images_without_descriptors_are_an_error(rng):
    with pytest.raises(SimError, match="no ORB descriptors"):
        WordTree.learned([np.zeros((0, 32), np.uint8)], rng)
