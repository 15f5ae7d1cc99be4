"""ORB bag-of-words, the classical baseline of place recognition (Gálvez-López and Tardós 2012).

1. Every binary ORB descriptor of an image is replaced by its nearest visual word.
2. The image is described by the tf-idf histogram of its words.
3. Images are compared by the cosine of their histograms.

The words are cluster centres of training descriptors. Lloyd's iteration finds them; a centre is the bitwise median of its
descriptors, since binary descriptors have no mean.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float32, Int, UInt8

from lexis.types import Image
from sim.errors import SimError

WORDS, FEATURES = 2048, 500
"""Number of words in the vocabulary, and number of key points per image (the default of OpenCV's ORB)."""
_PASSES = 8
_MOST_DESCRIPTORS = 60_000
_BYTES = 32

Descriptors = UInt8[np.ndarray, "n 32"]


@dataclass(frozen=True, eq=False)
class OrbWords:
    """A vocabulary of visual words, which converts images to tf-idf histograms."""

    words: UInt8[np.ndarray, "words 32"]
    """Binary descriptor of every word, eight bits to a byte."""
    weights: Float32[np.ndarray, "words"]
    """Inverse document frequency of every word: log(number of images / number of images with the word)."""

    @staticmethod
    def learned(images: Iterable[Image], rng: np.random.Generator, words: int = WORDS) -> "OrbWords":
        """Learn `words` visual words from images. Raises `SimError` if the images have fewer different descriptors."""
        found = [orb_descriptors(image) for image in images]
        every = np.concatenate(found) if found else np.zeros((0, _BYTES), np.uint8)
        sample = np.unique(every[rng.permutation(len(every))[:_MOST_DESCRIPTORS]], axis=0)
        if len(sample) < words:
            raise SimError(f"{len(sample)} different ORB descriptors for {words} words; valid: more images, or fewer words")
        centres = _medians(sample, rng, words)
        having = sum((np.bincount(nearest(d, centres), minlength=words) > 0).astype(int) for d in found)
        return OrbWords(centres, np.log(len(found) / np.maximum(having, 1)).astype(np.float32))

    def described(self, image: Image) -> Float32[np.ndarray, "words"]:
        """The tf-idf histogram of an image's words, with unit norm; all zeros if no key point is found in the image."""
        counts = np.bincount(nearest(orb_descriptors(image), self.words), minlength=len(self.words))
        histogram = (counts * self.weights).astype(np.float32)
        norm = np.linalg.norm(histogram)
        return np.asarray(histogram / norm if norm else histogram)


def orb_descriptors(image: Image) -> Descriptors:
    """ORB descriptors of an RGB image, eight bits to a byte; none for a blank image."""
    orb = cv2.ORB.create(nfeatures=FEATURES)  # a new one per call keeps no state, and costs little compared with detection
    _, descriptors = orb.detectAndCompute(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), None)
    return np.zeros((0, _BYTES), np.uint8) if descriptors is None else np.asarray(descriptors)


def nearest(descriptors: Descriptors, words: UInt8[np.ndarray, "words 32"]) -> Int[np.ndarray, "n"]:
    """For each descriptor, the index of the word with the smallest Hamming distance."""
    matches = cv2.BFMatcher(cv2.NORM_HAMMING).match(descriptors, words) if len(descriptors) else ()
    return np.array([match.trainIdx for match in matches], np.intp)


def _medians(descriptors: Descriptors, rng: np.random.Generator, words: int) -> UInt8[np.ndarray, "words 32"]:
    """Cluster centres of binary descriptors, by Lloyd's iteration in Hamming distance."""
    centres = descriptors[rng.choice(len(descriptors), words, replace=False)]
    bits = np.unpackbits(descriptors, axis=1).astype(np.float32)
    for _ in range(_PASSES):
        own = nearest(descriptors, centres)
        order = np.argsort(own, kind="stable")
        present, first, count = np.unique(own[order], return_index=True, return_counts=True)
        share = np.add.reduceat(bits[order], first, axis=0) / count[:, None]
        centres = centres.copy()
        centres[present] = np.packbits(share > 0.5, axis=1)  # a word without descriptors stays unchanged
    return centres
