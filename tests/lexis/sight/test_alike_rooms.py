"""Rooms merge if they share their space and the images of neither are clearly of its own name."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from lexis.config import SightConfig
from lexis.floors import NO_FLOOR
from lexis.room_labels import certain
from lexis.sight.alike_rooms import merge_alike

CONFIG = SightConfig()
OFFICE, OPEN, KITCHEN = 0, 1, 2
DOUBTFUL = {OFFICE: [0.55, 0.44, 0.01], OPEN: [0.35, 0.64, 0.01]}
"""Probabilities of the three names in images that hardly tell an office from an open-plan office."""
ROOMS = np.array([7] * 3 + [4] * 5)
LABELS = np.array([OFFICE] * 3 + [OPEN] * 5)


def merge(probabilities, across, floors=(0,) * 8, rooms=ROOMS, labels=LABELS, config=CONFIG):
    """Merge rooms inside which all keyframes see each other; keyframes of different rooms see each other by `across`."""
    tied = np.where(rooms[:, None] == rooms, 0.2, across)
    return merge_alike(rooms, labels, np.array(floors), np.array(probabilities), csr_array(tied), config)


def partition(rooms):
    return [np.flatnonzero(rooms == room).tolist() for room in dict.fromkeys(rooms.tolist())]


def test_two_halves_of_one_office_merge_under_the_more_probable_name():
    rooms, labels = merge([DOUBTFUL[label] for label in LABELS], across=0.1)
    assert partition(rooms) == [[0, 1, 2, 3, 4, 5, 6, 7]] and set(labels) == {OPEN}


@pytest.mark.parametrize("clear", [OFFICE, OPEN])
def test_rooms_stay_apart_if_the_images_of_one_of_them_are_clear(clear):
    sure = {**DOUBTFUL, clear: np.eye(3)[clear] * 0.9 + 0.033}
    rooms, labels = merge([sure[label] for label in LABELS], across=0.1)
    assert partition(rooms) == [[0, 1, 2], [3, 4, 5, 6, 7]] and (labels == LABELS).all()


def test_rooms_with_a_wall_between_them_or_on_two_floors_or_on_stairs_stay_apart():
    doubtful = [DOUBTFUL[label] for label in LABELS]
    assert len(partition(merge(doubtful, across=0.002)[0])) == 2
    assert len(partition(merge(doubtful, 0.1, floors=[0] * 3 + [1] * 5)[0])) == 2
    assert len(partition(merge(doubtful, 0.1, floors=[NO_FLOOR] * 8)[0])) == 2


def test_three_parts_of_one_room_become_one():
    rooms = np.repeat([0, 1, 2], 4)
    labels = np.repeat([OFFICE, OPEN, OFFICE], 4)
    found = merge([DOUBTFUL[label] for label in labels], 0.1, (0,) * 12, rooms, labels)
    assert len(partition(found[0])) == 1 and set(found[1]) == {OPEN}  # with the larger sum of log probabilities


def test_given_labels_are_certain_and_merge_nothing():
    rooms, labels = merge(certain(LABELS, 3), across=0.2)
    assert len(partition(rooms)) == 2 and (labels == LABELS).all()


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 6))
def test_the_result_depends_neither_on_the_numbers_of_rooms_nor_on_the_order_of_names(seed, count):
    rng = np.random.default_rng(seed)
    rooms = np.concatenate([np.arange(count), rng.integers(0, count, 10)])
    labels = rng.integers(0, 3, count)[rooms]
    probabilities, floors = rng.dirichlet(np.full(3, 5.0), len(rooms)), np.zeros(len(rooms), int)
    names, tied = rng.permutation(3), rng.random((len(rooms), len(rooms)))
    tied = csr_array(tied + tied.T)
    found, named = merge_alike(rooms, labels, floors, probabilities, tied, CONFIG)
    other, renamed = merge_alike(
        rng.permutation(count)[rooms], np.argsort(names)[labels], floors, probabilities[:, names], tied, CONFIG
    )
    assert sorted(partition(found)) == sorted(partition(other))
    assert (names[renamed] == named).all()
