"""Rooms are groups of keyframes of one label and floor that see each other's places."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from lexis.config import SightConfig
from lexis.floors import NO_FLOOR
from lexis.room_labels import certain
from lexis.sight.passages import LinesOfSight
from lexis.sight.room_clusters import cluster_by_sight

CONFIG = SightConfig()
NO_LINES = LinesOfSight(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, 2)))


def cluster(labels, pairs, floors=None, positions=None, config=CONFIG, sessions=None):
    """Rooms and labels of keyframes, where the first of each pair sees the place of the second."""
    n = len(labels)
    sees = np.eye(n) * 0.2
    for viewer, seen in pairs:
        sees[seen, viewer] = 0.1
    floors = np.zeros(n, int) if floors is None else np.array(floors)
    positions = np.arange(n)[:, None] * [1.0, 0.0, 0.0] if positions is None else np.array(positions, float)
    labels = np.array(labels)
    sessions = np.zeros(n, int) if sessions is None else np.array(sessions)
    return cluster_by_sight(labels, floors, positions, sessions, certain(labels, 3), csr_array(sees), NO_LINES, config)


def partition(rooms):
    return [np.flatnonzero(rooms == room).tolist() for room in dict.fromkeys(rooms.tolist())]


def test_twin_offices_with_a_wall_between_them_stay_two():
    labels = [0] * 4 + [1] * 3 + [0] * 4  # office, corridor, office
    rooms, same = cluster(labels, [])
    assert partition(rooms) == [[0, 1, 2, 3], [4, 5, 6], [7, 8, 9, 10]] and same.tolist() == labels


def test_consecutive_keyframes_of_two_sessions_are_in_one_room_only_if_one_sees_the_other():
    sessions = [0] * 4 + [1] * 4
    assert partition(cluster([0] * 8, [], sessions=sessions)[0]) == [[0, 1, 2, 3], [4, 5, 6, 7]]
    assert len(partition(cluster([0] * 8, [(4, 3), (3, 4)], sessions=sessions)[0])) == 1


def test_consecutive_keyframes_across_a_gap_are_in_one_room_only_if_one_sees_the_other():
    x = np.array([0.0, 1.0, 2.0, 3.0, 6.5, 7.5, 8.5, 9.5])
    across = [(4, 3), (3, 4)]
    assert partition(cluster([0] * 8, [], positions=x[:, None] * [1.0, 0.0, 0.0])[0]) == [[0, 1, 2, 3], [4, 5, 6, 7]]
    assert len(partition(cluster([0] * 8, across, positions=x[:, None] * [1.0, 0.0, 0.0])[0])) == 1


def test_a_room_that_is_entered_again_is_one_room_if_its_old_keyframes_are_in_sight():
    labels = [0] * 4 + [1] * 3 + [0] * 4
    rooms, _ = cluster(labels, [(9, 1)])
    assert partition(rooms) == [[0, 1, 2, 3, 7, 8, 9, 10], [4, 5, 6]]


def test_sight_does_not_join_labels_or_floors():
    assert len(partition(cluster([0] * 3 + [1] * 3, [(0, 5), (5, 0)])[0])) == 2
    assert len(partition(cluster([0] * 3 + [1] * 3 + [0] * 3, [(0, 8)], floors=[0] * 5 + [1] * 4)[0])) == 4


def test_a_small_room_is_absorbed_by_the_room_that_it_shares_most_sight_with():
    labels = [0] * 4 + [2] + [1] * 4
    rooms, corrected = cluster(labels, [(4, 6), (7, 4), (4, 1)])
    assert partition(rooms) == [[0, 1, 2, 3], [4, 5, 6, 7, 8]] and corrected.tolist() == [0] * 4 + [1] * 5


def test_a_small_room_that_nobody_sees_stays():
    labels = [0] * 4 + [2] + [1] * 4
    assert partition(cluster(labels, [])[0]) == [[0, 1, 2, 3], [4], [5, 6, 7, 8]]
    alone = cluster([0, 0], [(0, 1)])
    assert partition(alone[0]) == [[0, 1]]


def test_the_flights_of_a_staircase_are_one_room():
    floors = [0, 0, 0, NO_FLOOR, NO_FLOOR, 1, 1, 1, NO_FLOOR, NO_FLOOR, 0, 0, 0]
    labels = [2 if floor == NO_FLOOR else 0 for floor in floors]
    positions = [(0.5 * i if i < 8 else 0.5 * (12 - i), 0.0, 1.0 * floor) for i, floor in enumerate(floors)]
    rooms, _ = cluster(labels, [], floors, positions)
    assert [3, 4, 8, 9] in partition(rooms)


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 40))
def test_all_keyframes_of_a_room_have_one_label_and_floor(seed, n):
    labels, floors, arguments = scattered(seed, n)
    rooms, corrected = cluster_by_sight(labels, floors, *arguments, CONFIG)
    for members in partition(rooms):
        assert len({(corrected[i], floors[i]) for i in members}) == 1


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 40))
def test_a_small_room_keeps_its_label_unless_rooms_merge(seed, n):
    labels, floors, arguments = scattered(seed, n)
    rooms, corrected = cluster_by_sight(labels, floors, *arguments, SightConfig(merge_cut=3.0))
    small = np.bincount(rooms)[rooms] < CONFIG.min_keyframes
    np.testing.assert_array_equal(corrected[small], labels[small])


def scattered(seed, n):
    """Random labels and floors, and random positions, sessions, probabilities and sight."""
    rng = np.random.default_rng(seed)
    floors = np.sort(rng.integers(0, 2, n))
    labels = np.repeat(rng.integers(0, 3, n), 2)[:n]
    sees = csr_array(np.where(rng.random((n, n)) < 0.1, rng.random((n, n)), 0.0))
    probabilities = rng.dirichlet(np.ones(3), n)
    return labels, floors, (rng.normal(size=(n, 3)), np.zeros(n, int), probabilities, sees, NO_LINES)


@pytest.mark.parametrize("share", [0.08, 0.15])
def test_a_glance_is_not_sight(share):
    rooms, _ = cluster([0] * 4 + [1] * 3 + [0] * 4, [(9, 1)], config=SightConfig(share=share, merge_cut=3.0))
    assert len(partition(rooms)) == (2 if share < 0.1 else 3)
