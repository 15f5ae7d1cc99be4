"""Scores of room names for categories of objects, by which `object_votes` names rooms.

Chen et al. ("Leveraging Large (Visual) Language Models for Robot 3D Scene Understanding", arXiv:2209.05629) name the rooms
of scene graphs, such as Hydra's, by the objects in them and a language model. Here, `Similarity` and `RelativeSimilarity`
use text embeddings, and `Counted` counts the rooms of training houses that have objects of a category.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from lexis.perception import TextEncoder
from lexis.room_labels import similarities
from worlds.house import build_house
from worlds.presets import sample_house


@runtime_checkable
class ObjectScores(Protocol):
    """Interface of a method that scores room names for categories of objects."""

    def scores(self, pieces: Mapping[str, int], names: Sequence[str]) -> Float64[np.ndarray, "categories names"]:
        """Return the score of each room name for each category.

        `pieces` are the numbers of objects in the whole house by category.
        """


@dataclass(frozen=True)
class Similarity:
    """Scores by the cosine similarity of the text embeddings of a category and of a room name."""

    encoder: TextEncoder

    def scores(self, pieces: Mapping[str, int], names: Sequence[str]) -> Float64[np.ndarray, "categories names"]:
        """Return the score of each room name for each category."""
        return similarities(self.encoder.encode_texts(tuple(pieces)), self.encoder.encode_rooms(names))


@dataclass(frozen=True)
class RelativeSimilarity:
    """Scores by how much more similar a room name is to a category than to the other objects of the house.

    From every similarity, the mean of its room name over all objects of the house is taken. Then every category is weighted
    by its information: one minus the entropy of the room names given the category, relative to the largest entropy; Chen et
    al. select informative objects by this entropy. Both steps and the setting were tuned on walks in houses 120 to 131
    of each preset of the paper.
    """

    encoder: TextEncoder
    temperature: float = 0.15
    """Temperature of the softmax that turns relative similarities into probabilities: the best of 0.02 to 0.4."""

    def scores(self, pieces: Mapping[str, int], names: Sequence[str]) -> Float64[np.ndarray, "categories names"]:
        """Return the score of each room name for each category."""
        found = Similarity(self.encoder).scores(pieces, names)
        relative = found - np.average(found, axis=0, weights=list(pieces.values()))
        return np.asarray(relative * _information(relative / self.temperature)[:, None])


def _information(logits: Float64[np.ndarray, "categories names"]) -> Float64[np.ndarray, "categories"]:
    """Return one minus the entropy of the softmax of each row, relative to the largest entropy.

    The result is 1 if there is only one name.
    """
    if logits.shape[1] == 1:
        return np.ones(len(logits))
    powers = np.exp(logits - logits.max(axis=1, keepdims=True))
    shares = powers / powers.sum(axis=1, keepdims=True)
    return np.asarray(1.0 + (shares * np.log(np.maximum(shares, 1e-300))).sum(axis=1) / np.log(logits.shape[1]))


@dataclass(frozen=True)
class Counted:
    """Scores by naive Bayes: the log probability of a category in rooms of a label, counted in training houses.

    A room counts once for every category in it, however many objects of the category it has, since categories vote once.
    """

    counts: Mapping[tuple[str, str], int]
    """Number of rooms in training houses that have objects of a category, by category and room label; pairs that do not
    occur are left out."""
    smoothing: float = 1.0
    """Number that is added to every count: tuned on walks in houses 120 to 131 of each preset of the paper, where 0.03
    to 3 are equally good."""

    def scores(self, pieces: Mapping[str, int], names: Sequence[str]) -> Float64[np.ndarray, "categories names"]:
        """Return the score of each room name for each category.

        A label that the training houses lack has the lowest of all scores, so that it is never preferred to a known label.
        """
        categories = sorted({category for category, _ in self.counts} | set(pieces))
        table = np.array([[self.counts.get((category, name), 0) for name in names] for category in categories], np.float64)
        shares = (table + self.smoothing) / (table + self.smoothing).sum(axis=0)
        shares[:, ~table.any(axis=0)] = shares.min()
        return np.asarray(np.log(shares[[categories.index(category) for category in pieces]]))


@lru_cache(maxsize=8)
def count_rooms(preset: str, seeds: range) -> Mapping[tuple[str, str], int]:
    """Count the rooms in the houses of a preset that have furniture of a category, by category and label of the room."""
    counts: Counter[tuple[str, str]] = Counter()
    for seed in seeds:
        house = build_house(sample_house(preset, seed))
        in_rooms = {(piece.kind, piece.room) for piece in house.furniture}
        counts.update((kind, house.room_by_id[room].label) for kind, room in in_rooms)
    return MappingProxyType(counts)
