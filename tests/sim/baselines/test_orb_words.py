"""ORB bag-of-words: nearest words agree with brute force, and images are found again."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from sim.baselines import orb_vocabulary as module
from sim.baselines.orb_vocabulary import flat_orb_words
from sim.baselines.orb_words import OrbWords, nearest, orb_descriptors
from sim.errors import SimError

WORDS = 600


def textured(seed):
    rng = np.random.default_rng(seed)
    soft = cv2.GaussianBlur(rng.normal(size=(180, 240, 3)).astype(np.float32), None, 3.0)
    return np.clip(128 + 900 * soft, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def vocabulary():
    return OrbWords.learned([textured(seed) for seed in range(10)], np.random.default_rng(0), WORDS)


def test_the_nearest_word_has_the_fewest_different_bits():
    rng = np.random.default_rng(0)
    descriptors, words = (rng.integers(0, 256, (n, 32), np.uint8) for n in (50, 20))
    distance = np.bitwise_count(descriptors[:, None] ^ words[None]).sum(axis=2)
    found = nearest(descriptors, words)
    assert (distance[np.arange(50), found] == distance.min(axis=1)).all()


def test_images_are_unit_histograms_and_find_themselves_through_noise(vocabulary):
    rng = np.random.default_rng(1)
    images = [textured(seed) for seed in range(20, 28)]
    noisy = [np.clip(image + rng.normal(0, 6, image.shape), 0, 255).astype(np.uint8) for image in images]
    known, seen = (np.array([vocabulary.described(image) for image in some]) for some in (images, noisy))
    np.testing.assert_allclose(np.linalg.norm(known, axis=1), 1.0, rtol=1e-5)
    assert ((seen @ known.T).argmax(axis=1) == np.arange(8)).all()


def test_a_blank_image_has_no_words(vocabulary):
    blank = np.full((180, 240, 3), 127, np.uint8)
    assert len(orb_descriptors(blank)) == 0 and not vocabulary.described(blank).any()


def test_words_that_every_image_has_weigh_nothing():
    image = textured(3)
    vocabulary = OrbWords.learned([image, image], np.random.default_rng(0), 8)
    assert not vocabulary.weights[nearest(orb_descriptors(image), vocabulary.words)].any()


def test_too_few_descriptors_are_an_error():
    with pytest.raises(SimError, match="0 different ORB descriptors for 600 words"):
        OrbWords.learned([np.zeros((180, 240, 3), np.uint8)], np.random.default_rng(0), WORDS)


def test_the_vocabulary_is_cached_and_a_damaged_one_is_reported(tmp_path, monkeypatch):
    images = np.array([textured(seed) for seed in range(12)])
    monkeypatch.setattr(module, "frames_of_house", lambda draw, views: SimpleNamespace(images=images))
    learned = flat_orb_words(tmp_path)
    monkeypatch.delattr(module, "frames_of_house")
    np.testing.assert_array_equal(flat_orb_words(tmp_path).words, learned.words)
    (path,) = tmp_path.iterdir()
    with monkeypatch.context() as other:
        other.setattr(module, "_SEED", 9)
        with pytest.raises(SimError, match="delete its folder"):
            flat_orb_words(tmp_path)
    path.write_bytes(b"PK")
    with pytest.raises(SimError, match="delete it"):
        flat_orb_words(tmp_path)
