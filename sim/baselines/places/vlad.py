"""Place recognition by VLAD, the vector of locally aggregated descriptors (Jégou et al., CVPR 2010).

The descriptors are those of AKAZE, whose bits are taken as numbers, or patch features of the encoder. AnyLoc aggregates such
features (Keetha et al., RA-L 2024).

An image is described by the sums of the differences between its descriptors and their visual words. The sum of each word is
scaled to unit norm (Arandjelović and Zisserman, CVPR 2013). Then every component is replaced by its signed square root, and
the vector is whitened (Jégou and Chum, ECCV 2012). NetVLAD replaces the descriptors and the words by learned ones, which
need training images and a network of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float16, Float32, UInt8
from scipy.cluster.vq import kmeans2

from sim.baselines.places.place_method import Scores, SeenKeyframes
from sim.errors import SimError

Descriptors = UInt8[np.ndarray, "_ bytes"] | Float16[np.ndarray, "_ channels"]
"""Local descriptors of an image: binary ones, or real ones of unit norm."""
Kind = Literal["akaze", "patches"]
"""A kind of local descriptors, named like the fields of `SeenKeyframes` and `TrainingDescriptors`."""
_MOST_DESCRIPTORS = 30_000
_PASSES = 12


@dataclass(frozen=True, eq=False)
class Vlad:
    """Scores keyframes by the cosine similarity of their VLAD vectors."""

    words: Float32[np.ndarray, "words components"]
    """Visual words: means of descriptors."""
    mean: Float32[np.ndarray, "features"]
    """Mean VLAD vector of the training images."""
    whitening: Float32[np.ndarray, "features dims"]
    """Maps VLAD vectors without their mean to components of equal variance over the training images."""
    kind: Kind = "akaze"
    """Kind of the descriptors in `SeenKeyframes` that are aggregated."""

    @staticmethod
    def learned(
        images: Sequence[Descriptors], rng: np.random.Generator, words: int = 64, dims: int = 128, kind: Kind = "akaze"
    ) -> "Vlad":
        """Learn words and whitening from the descriptors of training images.

        With `dims` of 0, vectors are not whitened. Raises `SimError` if the images have fewer descriptors than `words`.
        """
        every = np.concatenate(list(images))
        if len(every) < words:
            raise SimError(f"{len(every)} descriptors for {words} words; valid: more images, or fewer words")
        sample = _components(every[rng.permutation(len(every))[:_MOST_DESCRIPTORS]])
        centres = np.asarray(kmeans2(sample, words, iter=_PASSES, minit="points", seed=rng)[0], np.float32)
        size = centres.size
        plain = Vlad(centres, np.zeros(size, np.float32), np.zeros((size, 0), np.float32), kind)
        if not dims:
            return plain
        vectors = plain.vectors(images)
        mean = vectors.mean(axis=0)
        _, spreads, axes = np.linalg.svd(vectors - mean, full_matrices=False)
        dims = min(dims, int((spreads > 1e-4 * spreads[0]).sum()))
        return Vlad(centres, mean, np.ascontiguousarray(axes[:dims].T / spreads[:dims]), kind)

    def vectors(self, images: Sequence[Descriptors]) -> Float32[np.ndarray, "images dims"]:
        """Return VLAD vectors of images, with unit norm; zeros for an image without descriptors."""
        found = np.array([self._aggregated(_components(descriptors)) for descriptors in images], np.float32)
        if not self.whitening.size:
            return found
        return _unit((found - self.mean) @ self.whitening) * found.any(axis=1, keepdims=True)

    def scores(self, seen: SeenKeyframes) -> Scores:
        """See `PlaceMethod.scores`; a score is a cosine similarity."""
        vectors = self.vectors(getattr(seen, self.kind))
        return seen.only_eligible(vectors @ vectors.T)

    def _aggregated(self, local: Float32[np.ndarray, "n components"]) -> Float32[np.ndarray, "features"]:
        squared = (self.words**2).sum(axis=1) - 2.0 * local @ self.words.T
        member = np.eye(len(self.words), dtype=np.float32)[squared.argmin(axis=1)]
        sums = _unit(member.T @ local - member.sum(axis=0)[:, None] * self.words)
        return _unit((np.sign(sums) * np.sqrt(np.abs(sums))).reshape(-1))


def _components(descriptors: Descriptors) -> Float32[np.ndarray, "n components"]:
    """Return the components of descriptors as numbers: the bits of binary ones."""
    return (np.unpackbits(descriptors, axis=1) if descriptors.dtype == np.uint8 else descriptors).astype(np.float32)


def _unit(vectors: Float32[np.ndarray, "*n d"]) -> Float32[np.ndarray, "*n d"]:
    """Scale vectors along the last axis to unit norm; zeros stay zeros."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), np.float32(1e-12)))
