"""VLAD vectors: unit norm, no order of descriptors, whitened components, and bits as numbers."""

import itertools

import numpy as np
import pytest
from helpers.two_laps import two_laps

from sim.baselines.places import Vlad
from sim.errors import SimError


def drawn(rng, images=40, count=50):
    return [rng.integers(0, 256, (count, 61), np.uint8) for _ in range(images)]


def of_word(method, image, word):
    apart = np.unpackbits(image, axis=1)[:, None] - method.words
    return (np.linalg.norm(apart, axis=2).argmin(axis=1) == word).astype(int)


def test_vectors_have_unit_norm_and_an_image_without_descriptors_matches_nothing(rng):
    images = drawn(rng)
    for dims in (0, 16):
        vectors = Vlad.learned(images, rng, words=4, dims=dims).vectors([*images, np.zeros((0, 61), np.uint8)])
        np.testing.assert_allclose(np.linalg.norm(vectors[:-1], axis=1), 1.0, rtol=1e-4)
        assert not vectors[-1].any() and vectors.shape[1] == (dims or 4 * 488)


def test_the_order_of_descriptors_does_not_matter(rng):
    images = drawn(rng)
    method = Vlad.learned(images, rng, words=4, dims=8)
    shuffled = [rng.permutation(image) for image in images]
    np.testing.assert_allclose(method.vectors(images), method.vectors(shuffled), atol=1e-4)


def test_whitened_components_of_training_images_are_uncorrelated_and_of_equal_size(rng):
    images = drawn(rng)
    plain, white = (Vlad.learned(images, np.random.default_rng(1), words=4, dims=dims) for dims in (0, 12))
    components = (plain.vectors(images) - white.mean) @ white.whitening
    np.testing.assert_allclose(components.T @ components, np.eye(12), atol=1e-3)


def test_bits_of_binary_descriptors_are_aggregated_like_real_components(rng):
    images = drawn(rng)
    numbers = [np.unpackbits(image, axis=1).astype(np.float16) for image in images]
    for dims in (0, 8):
        binary, real = (Vlad.learned(each, np.random.default_rng(1), words=4, dims=dims) for each in (images, numbers))
        np.testing.assert_array_equal(binary.vectors(images), real.vectors(numbers))


def test_descriptors_that_repeat_weigh_no_more(rng):
    images = drawn(rng)
    method = Vlad.learned(images, rng, words=4, dims=0)
    repeated = [image[np.repeat(np.arange(len(image)), 1 + 3 * of_word(method, image, 2))] for image in images]
    np.testing.assert_allclose(method.vectors(repeated), method.vectors(images), atol=1e-3)


def test_the_kind_says_which_descriptors_of_keyframes_are_compared(rng):
    seen = two_laps(rng)
    for kind, dims in itertools.product(("akaze", "patches"), (0, 4)):
        descriptors = getattr(seen, kind)
        method = Vlad.learned(descriptors, np.random.default_rng(1), words=4, dims=dims, kind=kind)
        vectors = method.vectors(descriptors)
        np.testing.assert_array_equal(method.scores(seen), seen.only_eligible(vectors @ vectors.T))


def test_too_few_descriptors_are_an_error(rng):
    with pytest.raises(SimError, match="50 descriptors for 64 words"):
        Vlad.learned(drawn(rng, 1), rng, words=64)
