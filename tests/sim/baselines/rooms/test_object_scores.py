"""Scores of room names for categories of objects, by text embeddings and by counts."""

import numpy as np
import pytest

from sim.baselines.rooms.object_scores import Counted, RelativeSimilarity, Similarity, count_rooms
from worlds.house import build_house
from worlds.presets import sample_house

ROOMS = {"kitchen": (1.0, 0.0, 0.0), "bedroom": (0.0, 1.0, 0.0)}
OBJECTS = {"stove": (0.8, 0.0, 0.6), "bed": (0.28, 0.96, 0.0), "picture": (0.6, 0.48, 0.64), "cot": (0.28, 0.96, 0.0)}


class Words:
    """An encoder of the words above."""

    name = fingerprint = "words"

    def encode_image(self, image):
        raise NotImplementedError

    def encode_rooms(self, names):
        return np.array([ROOMS[name] for name in names], np.float32)

    def encode_texts(self, texts):
        return np.array([OBJECTS[text] for text in texts], np.float32)


PIECES = {"stove": 1, "bed": 2, "picture": 4}


def test_similarity_is_the_cosine_in_the_order_of_pieces_and_names():
    expected = [[0.8, 0.0], [0.28, 0.96], [0.6, 0.48]]
    assert Similarity(Words()).scores(PIECES, ("kitchen", "bedroom")) == pytest.approx(np.array(expected), abs=1e-6)
    assert Similarity(Words()).scores(PIECES, ("bedroom", "kitchen"))[:, ::-1] == pytest.approx(np.array(expected), abs=1e-6)


def test_relative_similarity_does_not_change_if_a_room_name_is_more_similar_to_everything():
    class Biased(Words):
        def encode_texts(self, texts):
            raised = super().encode_texts(texts) @ np.diag([0.5, 0.5, 0.0]) + (0.3, 0.0, 0.0)
            rest = np.sqrt(1.0 - (raised**2).sum(axis=1))
            return (raised + rest[:, None] * (0.0, 0.0, 1.0)).astype(np.float32)

    class Fair(Biased):
        def encode_texts(self, texts):
            without = super().encode_texts(texts)[:, :2] - (0.3, 0.0)
            rest = np.sqrt(1.0 - (without**2).sum(axis=1))
            return np.column_stack([without, rest]).astype(np.float32)

    names = ("kitchen", "bedroom")
    fair, biased = (RelativeSimilarity(each()).scores(PIECES, names) for each in (Fair, Biased))
    assert fair == pytest.approx(biased, abs=1e-6) and fair[0].argmax() == 0 and fair[1].argmax() == 1


def test_two_categories_of_one_meaning_count_like_one():
    names = ("kitchen", "bedroom")
    one = RelativeSimilarity(Words()).scores(PIECES, names)
    two = RelativeSimilarity(Words()).scores({"stove": 1, "bed": 1, "cot": 1, "picture": 4}, names)
    assert two[[0, 1, 3]] == pytest.approx(one) and two[2] == pytest.approx(one[1])


def test_an_object_that_tells_nothing_about_the_room_has_little_weight():
    scores = RelativeSimilarity(Words()).scores(PIECES, ("kitchen", "bedroom"))
    assert np.ptp(scores[2]) < 0.1 * min(np.ptp(scores[0]), np.ptp(scores[1]))
    assert (RelativeSimilarity(Words()).scores(PIECES, ("kitchen",)) != 0).any()  # with one name, nothing can be told


def test_counts_are_log_shares_of_each_label_with_smoothing():
    counted = Counted({("stove", "kitchen"): 8, ("picture", "kitchen"): 1, ("bed", "bedroom"): 4}, smoothing=1.0)
    scores = np.exp(counted.scores({"stove": 2, "picture": 1}, ("kitchen", "bedroom", "garage")))
    assert scores == pytest.approx(np.array([[9 / 12, 1 / 7, 1 / 12], [2 / 12, 1 / 7, 1 / 12]]))


def test_a_room_counts_once_for_every_category_in_it():
    house = build_house(sample_house("uh2-apt", 100))
    counts = count_rooms("uh2-apt", range(100, 101))
    for category, label in counts:
        rooms = {piece.room for piece in house.furniture if piece.kind == category}
        assert counts[category, label] == sum(house.room_by_id[room].label == label for room in rooms)
    assert sum(counts.values()) < len(house.furniture)  # some categories stand in one room several times
    assert counts["double bed", "bedroom"] >= 1 and ("double bed", "bathroom") not in counts
    twice = count_rooms("uh2-apt", range(100, 102))
    assert all(twice[pair] >= number for pair, number in counts.items()) and sum(twice.values()) > sum(counts.values())
