"""A vocabulary tree of binary descriptors (Nistér and Stewénius 2006; Gálvez-López and Tardós 2012, Sec. IV).

Each node splits its descriptors into `branching` clusters by k-medians in Hamming distance, with k-means++ seeds. The leaves
are the words. A descriptor finds its word by descending to the nearest child on every level.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float64, Int, UInt8

from sim.errors import SimError

Descriptors = UInt8[np.ndarray, "_ 32"]
_PASSES = 5
_MOST_DESCRIPTORS = 20_000
"""Largest number of descriptors from which the children of a node are found; a node with more of them uses a sample."""


@dataclass(frozen=True, eq=False)
class WordTree:
    """A vocabulary tree with the weights of its words."""

    levels: tuple[UInt8[np.ndarray, "_ 32"], ...]
    """Descriptors of the nodes by level, from the children of the root. The children of node i are the nodes
    i * branching to (i + 1) * branching - 1 of the next level. Superfluous nodes are copies that no descriptor reaches."""
    weights: Float64[np.ndarray, "words"]
    """Inverse document frequency of every word: log(number of images / number of images with the word).

    The weight of a word that occurs in no training image is 0, as in DBoW2: nothing is known about how rare the word is."""

    @staticmethod
    def learned(images: Sequence[Descriptors], rng: np.random.Generator, branching: int = 10, depth: int = 4) -> "WordTree":
        """Learn the words from the descriptors of training images. Raises `SimError` if there is no descriptor."""
        descriptors = np.concatenate(list(images)) if images else np.zeros((0, 32), np.uint8)
        if len(descriptors) == 0:
            raise SimError("no ORB descriptors to learn words from; valid: images with corners")
        levels, nodes = [], np.zeros(len(descriptors), np.intp)
        for above in range(depth):
            level = np.zeros((branching**above, branching, 32), np.uint8)
            order = np.argsort(nodes, kind="stable")
            present, first = np.unique(nodes[order], return_index=True)
            for node, members in zip(present, np.split(order, first[1:]), strict=True):
                level[node] = _split(descriptors[members], branching, rng)
            nodes = nodes * branching + _nearest_child(descriptors, level[nodes])
            levels.append(level.reshape(-1, 32))
        images_of = np.repeat(np.arange(len(images)), [len(each) for each in images])
        having = np.bincount(np.unique(np.stack([nodes, images_of], axis=1), axis=0)[:, 0], minlength=len(levels[-1]))
        return WordTree(tuple(levels), np.where(having > 0, np.log(len(images) / np.maximum(having, 1)), 0.0))

    def words(self, descriptors: Descriptors) -> Int[np.ndarray, "n"]:
        """Return the word of every descriptor."""
        branching, nodes = len(self.levels[0]), np.zeros(len(descriptors), np.intp)
        for level in self.levels:
            nodes = nodes * branching + _nearest_child(descriptors, level.reshape(-1, branching, 32)[nodes])
        return nodes

    def histograms(self, images: Sequence[Descriptors]) -> Float64[np.ndarray, "images words"]:
        """Return the tf-idf histogram of every image over the words that occur, with unit sum.

        The histogram of an image without words is zero.
        """
        found = [self.words(descriptors) for descriptors in images]
        occurring, columns = np.unique(np.concatenate(found), return_inverse=True)
        rows = np.repeat(np.arange(len(images)), [len(each) for each in found])
        counts = np.zeros((len(images), len(occurring)))
        np.add.at(counts, (rows, columns), self.weights[occurring][columns])
        return np.asarray(counts / np.maximum(counts.sum(axis=1, keepdims=True), np.finfo(float).tiny))


def nearest(
    descriptors: Descriptors, others: UInt8[np.ndarray, "k 32"]
) -> tuple[Int[np.ndarray, "n"], Int[np.ndarray, "n"]]:
    """Return, for every descriptor, how many bits differ from the nearest of the others, and the row of that one."""
    bits, rows = cv2.batchDistance(descriptors, others, cv2.CV_32S, normType=cv2.NORM_HAMMING, K=1)
    return bits[:, 0].astype(np.int64), rows[:, 0].astype(np.intp)


def _nearest_child(descriptors: Descriptors, children: UInt8[np.ndarray, "n k 32"]) -> Int[np.ndarray, "n"]:
    own, others = (np.ascontiguousarray(each).view(np.uint64) for each in (descriptors[:, None], children))
    return np.asarray(np.bitwise_count(own ^ others).sum(axis=-1, dtype=np.int64).argmin(axis=1))


def _split(descriptors: Descriptors, count: int, rng: np.random.Generator) -> UInt8[np.ndarray, "k 32"]:
    """Return cluster centres of binary descriptors. All descriptors are centres if there are no more than `count`."""
    if len(descriptors) > _MOST_DESCRIPTORS:
        descriptors = descriptors[rng.permutation(len(descriptors))[:_MOST_DESCRIPTORS]]
    different = np.unique(descriptors, axis=0)
    if len(different) <= count:
        return np.concatenate([different, np.repeat(different[:1], count - len(different), axis=0)])
    centres = _seeds(descriptors, count, rng)
    bits = np.unpackbits(descriptors, axis=1)
    for _ in range(_PASSES):
        _, own = nearest(descriptors, centres)
        order = np.argsort(own, kind="stable")
        present, first, sizes = np.unique(own[order], return_index=True, return_counts=True)
        ones = np.add.reduceat(bits[order], first, axis=0, dtype=np.int64)
        centres[present] = np.packbits(2 * ones > sizes[:, None], axis=1)
    return centres


def _seeds(descriptors: Descriptors, count: int, rng: np.random.Generator) -> UInt8[np.ndarray, "k 32"]:
    """Draw different descriptors that lie far apart, as k-means++ does."""
    chosen = [int(rng.integers(len(descriptors)))]
    squared = _squared(descriptors, chosen[0])
    while len(chosen) < count:
        chosen.append(int(rng.choice(len(descriptors), p=squared / squared.sum())))
        squared = np.minimum(squared, _squared(descriptors, chosen[-1]))
    return descriptors[chosen]


def _squared(descriptors: Descriptors, chosen: int) -> Int[np.ndarray, "n"]:
    """Return the squared Hamming distances from one of the descriptors."""
    return nearest(descriptors, descriptors[chosen : chosen + 1])[0] ** 2
