"""A room is split where hardly any sight joins its parts, and a corridor of any length stays whole."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from lexis.config import SightConfig
from lexis.maths.se3 import exp, transform
from lexis.sight.divided_rooms import _smallest_cut, sight_between, split_divided

CONFIG = SightConfig()


def twins(rng, per_room, across):
    """Keyframes of two rooms of 4 m, each of which sees its whole room; `across` is the sight through the wall."""
    rooms = np.repeat([0, 1], per_room)
    positions = rng.uniform(0.0, 4.0, (2 * per_room, 3)) * [1.0, 1.0, 0.0] + np.outer(rooms, [4.1, 0.0, 0.0])
    sees = np.where(rooms[:, None] == rooms, rng.uniform(0.05, 0.3, (2 * per_room, 2 * per_room)), 0.0)
    np.fill_diagonal(sees, 0.0)
    near_wall = int(np.argmax(positions[:per_room, 0]))
    sees[near_wall, per_room] = across
    return rooms, positions, csr_array(sees + sees.T)


def split(positions, tied, past_passages=None, config=CONFIG):
    n = len(positions)
    weaker = tied if past_passages is None else past_passages
    return split_divided(np.zeros(n, int), np.ones(n, bool), positions, tied, weaker, config)


def same(first, second):
    return np.array_equal(first[:, None] == first, second[:, None] == second)


@given(seed=st.integers(0, 2**32 - 1), per_room=st.integers(12, 30))
def test_twin_rooms_that_see_each_other_through_a_wall_are_split_and_their_parts_are_not(seed, per_room):
    rooms, positions, tied = twins(np.random.default_rng(seed), per_room, across=0.1)
    assert same(split(positions, tied), rooms)
    assert len(np.unique(split(positions, tied, config=SightConfig(split_m=0.0)))) == 1


@given(seed=st.integers(0, 2**32 - 1), per_room=st.integers(12, 30))
def test_rooms_that_see_each_other_only_through_a_passage_are_split(seed, per_room):
    rng = np.random.default_rng(seed)
    rooms, positions, tied = twins(rng, per_room, across=0.0)
    doorway = np.where(rooms[:, None] == rooms, 0.0, np.where(rng.random((2 * per_room,) * 2) < 0.05, 0.2, 0.0))
    tied = csr_array(tied + doorway + doorway.T)
    assert same(split(positions, tied, csr_array(tied - doorway - doorway.T), SightConfig(merge_cut=0.5)), rooms)


@given(seed=st.integers(0, 2**32 - 1), per_room=st.integers(12, 30))
def test_parts_that_share_their_space_are_one_room_however_narrow_the_passage_between_them(seed, per_room):
    rooms, positions, tied = twins(np.random.default_rng(seed), per_room, across=0.0)
    shared = csr_array(tied + np.where(rooms[:, None] == rooms, 0.0, 0.1))
    assert same(split(positions, shared, tied), np.zeros(len(rooms)))


def test_three_rooms_in_a_row_become_three(rng):
    one, here, tied = twins(rng, 10, across=0.1)
    sees = np.zeros((40, 40))
    sees[:20, :20] = sees[20:, 20:] = tied.toarray()
    sees[12, 25] = sees[25, 12] = 0.1
    rooms = split(np.concatenate([here, here + [8.2, 0.0, 0.0]]), csr_array(sees))
    assert same(rooms, np.concatenate([one, one + 2]))


@pytest.mark.parametrize("length_m", [3.0, 8.0, 20.0, 60.0])
@pytest.mark.parametrize("spacing_m", [0.25, 0.5, 1.0])
def test_a_corridor_of_any_length_stays_whole(length_m, spacing_m):
    positions = np.arange(0.0, length_m, spacing_m)[:, None] * [1.0, 0.0, 0.0]
    ahead = positions[:, 0] - positions[:, :1]
    sees = np.where((ahead >= 0.0) & (ahead <= 3.0), 0.1, 0.0)  # every image shows the next three metres
    assert len(np.unique(split(positions, sight_between(csr_array(sees), positions, np.zeros(len(sees), int))))) == 1


@given(seed=st.integers(0, 2**32 - 1))
def test_the_cut_is_the_smallest_of_all_divisions(seed):
    _, _, tied = twins(np.random.default_rng(seed), 4, across=0.1)
    found, part = _smallest_cut(tied)
    weights = tied.toarray()

    def cut(side):
        between = weights[side][:, ~side].sum()
        return between / weights[side].sum() + between / weights[~side].sum()

    sides = [np.isin(np.arange(8), some) for size in range(1, 5) for some in combinations(range(8), size)]
    assert found == pytest.approx(cut(part)) == pytest.approx(min(map(cut, sides)))


@given(seed=st.integers(0, 2**32 - 1))
def test_the_parts_depend_neither_on_the_frame_nor_on_the_order_of_keyframes(seed):
    rng = np.random.default_rng(seed)
    _, positions, tied = twins(rng, 8, across=0.1)
    order, motion = rng.permutation(16), exp(rng.normal(size=6))
    assert same(split(positions, tied)[order], split(transform(motion, positions[order]), tied[order][:, order]))


def test_rooms_that_are_not_divisible_and_tiny_rooms_stay(rng):
    _, positions, tied = twins(rng, 8, across=0.1)
    rooms = np.zeros(16, int)
    assert not split_divided(rooms, np.zeros(16, bool), positions, tied, tied, CONFIG).any()
    assert len(np.unique(split(positions[:3], tied[:3][:, :3]))) == 1


def test_ties_are_symmetric_and_include_the_steps_of_the_walk(rng):
    sees = csr_array(rng.random((6, 6)))
    positions, sessions = np.array([0.0, 1.0, 2.0, 3.0, 7.0, 8.0])[:, None] * [1.0, 0.0, 0.0], np.array([0, 0, 0, 1, 1, 1])
    tied = sight_between(sees, positions, sessions).toarray()
    np.testing.assert_array_equal(tied, tied.T)
    assert not tied.diagonal().any()
    walked = tied.diagonal(1) > (sees + sees.T).diagonal(1)
    assert walked.tolist() == [True, True, False, False, True]  # not from one session to the other, nor across a gap of 4 m
    assert sight_between(csr_array((1, 1)), np.zeros((1, 3)), np.zeros(1, int)).toarray().tolist() == [[0.0]]
