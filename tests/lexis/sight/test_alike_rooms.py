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


def merge(probabilities, across, floors=(0,) * 8, rooms=ROOMS, labels=LABELS, open_steps=(), config=CONFIG):
    """Merge rooms inside which all keyframes see each other; keyframes of different rooms see each other by `across`."""
    tied = csr_array(np.where(rooms[:, None] == rooms, 0.2, across))
    steps = np.array(open_steps, int).reshape(-1, 2)
    return merge_alike(rooms, labels, np.array(floors), np.array(probabilities), tied, steps, config)


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


ALCOVE = [DOUBTFUL[OFFICE]] * 3 + [[0.02, 0.97, 0.01]] * 5 + [[0.01, 0.01, 0.98]] * 3
"""The images of an alcove that looks like an office, of the open-plan office beside it, and of a kitchen."""
BESIDE = {
    "rooms": np.repeat([0, 1, 2], [3, 5, 3]),
    "labels": np.repeat([OFFICE, OPEN, KITCHEN], [3, 5, 3]),
    "floors": (0,) * 11,
}


@pytest.mark.parametrize(
    ("open_steps", "merged"),
    [
        ([(2, 3)], True),
        ([(2, 3), (7, 8)], True),
        ([], False),
        ([(2, 3), (2, 8)], False),
        ([(2, 3), (3, 2), (4, 1), (2, 8)], True),
    ],
)
def test_an_alcove_that_the_path_leaves_into_one_room_only_merges_with_it(open_steps, merged):
    rooms, labels = merge(ALCOVE, 0.1, **BESIDE, open_steps=open_steps)
    assert len(partition(rooms)) == (2 if merged else 3)
    assert labels.tolist() == ([OPEN] * 8 + [KITCHEN] * 3 if merged else BESIDE["labels"].tolist())


def test_an_alcove_stays_a_room_if_its_own_images_are_clear_or_those_of_the_other_room_very_clear():
    of_alcove, of_room = [[0.97, 0.02, 0.01]] * 3 + ALCOVE[3:], ALCOVE[:3] + [[0.001, 0.998, 0.001]] * 5 + ALCOVE[8:]
    for clear in of_alcove, of_room:
        assert len(partition(merge(clear, 0.1, **BESIDE, open_steps=[(2, 3)])[0])) == 3


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
    steps = rng.integers(0, len(rooms), (int(rng.integers(0, 12)), 2))
    labels = rng.integers(0, 3, count)[rooms]
    probabilities, floors = rng.dirichlet(np.full(3, 5.0), len(rooms)), np.zeros(len(rooms), int)
    names, tied = rng.permutation(3), rng.random((len(rooms), len(rooms)))
    tied = csr_array(tied + tied.T)
    found, named = merge_alike(rooms, labels, floors, probabilities, tied, steps, CONFIG)
    other, renamed = merge_alike(
        rng.permutation(count)[rooms], np.argsort(names)[labels], floors, probabilities[:, names], tied, steps, CONFIG
    )
    assert sorted(partition(found)) == sorted(partition(other))
    assert (names[renamed] == named).all()
