"""VLAD vectors: unit norm, no order of descriptors, and whitened components."""

import numpy as np
import pytest

from sim.baselines.places import Vlad
from sim.errors import SimError


def drawn(rng, images=40, count=50):
    return [rng.integers(0, 256, (count, 61), np.uint8) for _ in range(images)]


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


def test_too_few_descriptors_are_an_error(rng):
    with pytest.raises(SimError, match="50 AKAZE descriptors for 64 words"):
        Vlad.learned(drawn(rng, 1), rng, words=64)
