"""Metrics: exact small cases, agreement with independent implementations, and None where nothing can be measured."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation
from sklearn.metrics import adjusted_rand_score, v_measure_score

from lexis.config import PlaceRecognitionConfig
from lexis.evaluation.coverage import path_covered
from lexis.evaluation.floors import floor_accuracy, floor_count_error
from lexis.evaluation.labels import accuracy, accuracy_per_room, graded_accuracy
from lexis.evaluation.loops import opposite_edges, opposite_revisits, score_loops, true_revisits
from lexis.evaluation.place_recognition import MatchCounts, at_one_place, count_matches, right_matches
from lexis.evaluation.planning import spl, success_rate
from lexis.evaluation.relative import separation
from lexis.evaluation.rooms import score_rooms
from lexis.maths.se3 import between
from lexis.place_recognition import old_enough

NOBODY = np.zeros(0, int)
partition_pairs = st.integers(2, 40).flatmap(
    lambda n: st.tuples(*[arrays(np.int64, n, elements=st.integers(0, 5)) for _ in range(2)])
)


def test_label_accuracy_counts_keyframes():
    predicted, truth = np.array([0, 0, 1, 2]), np.array([0, 1, 1, 1])
    assert accuracy(predicted, truth) == 0.5
    assert accuracy_per_room(predicted, truth, ["a", "b", "c"]) == {"a": 1.0, "b": pytest.approx(1 / 3)}


def test_graded_accuracy_takes_either_side_of_an_open_boundary():
    predicted, truth = np.array([0, 1, 2]), np.array([0, 0, 0])
    strict = np.eye(3, dtype=bool)[truth]
    open_boundary = strict | [[False, False, False], [False, True, False], [False, False, False]]
    assert graded_accuracy(predicted, strict) == accuracy(predicted, truth) == pytest.approx(1 / 3)
    assert graded_accuracy(predicted, open_boundary) == pytest.approx(2 / 3)


def test_a_keyframe_without_a_label_is_wrong():
    predicted, everything_allowed = np.array([-1, 2, -1, 0]), np.ones((4, 3), bool)
    assert graded_accuracy(predicted, everything_allowed) == 0.5
    assert accuracy(predicted, np.array([2, 2, 0, 0])) == 0.5


@given(partition_pairs)
def test_pair_and_entropy_indices_are_scikit_learns(pair):
    predicted, truth = pair
    scores = score_rooms(predicted, truth)
    assert scores.ari == pytest.approx(adjusted_rand_score(truth, predicted), abs=1e-9)
    assert scores.v_measure == pytest.approx(v_measure_score(truth, predicted), abs=1e-9)


@given(partition_pairs, st.permutations(range(6)))
def test_room_figures_do_not_depend_on_ids_and_swapping_sides_swaps_the_figures(pair, names):
    predicted, truth = pair
    scores = score_rooms(predicted, truth)
    assert score_rooms(np.array(names)[predicted], truth) == scores
    back = score_rooms(truth, predicted)
    assert (back.precision, back.recall, back.splits, back.merges) == (
        scores.recall,
        scores.precision,
        scores.merges,
        scores.splits,
    )
    assert back.pq == pytest.approx(scores.pq) and back.count_error == -scores.count_error
    assert back.hydra_recall == pytest.approx(scores.hydra_precision)


@given(arrays(np.int64, st.integers(2, 30), elements=st.integers(0, 5)))
def test_the_truth_as_an_estimate_has_perfect_figures(truth):
    scores = score_rooms(truth, truth)
    perfect = (
        scores.pq,
        scores.precision,
        scores.recall,
        scores.hydra_precision,
        scores.hydra_recall,
        scores.ari,
        scores.v_measure,
    )
    assert perfect == pytest.approx((1.0,) * 7)
    assert (scores.splits, scores.merges, scores.count_error) == (0, 0, 0)


def test_a_room_cut_in_two_is_one_split():
    """Hydra's precision of over-segmented rooms is perfect; the precision by one-to-one matching is lower."""
    scores = score_rooms(np.repeat([0, 1, 2], [6, 4, 10]), np.repeat([0, 1], 10))
    assert (scores.splits, scores.merges, scores.count_error) == (1, 0, 1)
    assert scores.hydra_precision == 1.0 and scores.precision == pytest.approx(2 / 3)
    assert scores.pq == pytest.approx((0.6 + 1.0) / 2.5)


def test_two_rooms_in_one_cluster_are_one_merge():
    scores = score_rooms(np.zeros(20, int), np.repeat([0, 1], 10))
    assert (scores.splits, scores.merges, scores.count_error, scores.pq) == (0, 1, -1, 0.0)


@given(partition_pairs)
def test_keyframes_in_no_room_are_wrong_and_make_no_room(pair):
    """With truth given for some keyframes only, every found room is right, and what is missing costs recall."""
    chosen, truth = pair
    scores = score_rooms(np.where(chosen > 2, truth, -1), truth)
    found, rooms = len(np.unique(truth[chosen > 2])), len(np.unique(truth))
    assert scores.count_error == found - rooms and scores.splits == scores.merges == 0
    assert scores.precision is None if found == 0 else scores.hydra_precision == 1.0
    assert scores.recall <= found / rooms and scores.pq <= 2 * found / (found + rooms)
    one_each = np.where(chosen > 2, truth, 100 + np.arange(len(truth)))
    alone = score_rooms(one_each, truth)
    assert (scores.ari, scores.v_measure) == (pytest.approx(alone.ari), pytest.approx(alone.v_measure))


def test_a_walk_in_no_room_finds_no_room():
    scores = score_rooms(np.full(9, -1), np.zeros(9, int))
    assert (scores.pq, scores.recall, scores.precision, scores.hydra_recall, scores.count_error) == (0.0, 0.0, None, 0.0, -1)


def test_floors_are_judged_off_the_stairs():
    predicted, truth = np.array([0, 0, -1, -1, 1, 1]), np.array([0, 0, 0, 1, 1, 0])
    stairs = np.array([False, False, False, True, False, False])
    assert floor_accuracy(predicted, truth, stairs) == pytest.approx(3 / 5)
    assert floor_count_error(predicted, truth, stairs) == 0


def pose(x=0.0, yaw=0.0):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("z", yaw).as_matrix()
    T[0, 3] = x
    return T


def test_loops_are_true_within_half_a_metre_and_a_fifth_of_a_radian():
    truth = np.stack([pose(), pose(5.0), pose(0.4), pose(0.4, 0.6)])
    stamps = np.array([0.0, 5.0, 20.0, 30.0])
    edges = [(2, 0, pose(0.4 + 0.49)), (2, 0, pose(0.4 + 0.51)), (2, 0, pose(0.4, 0.19)), (2, 0, pose(0.4, 0.21))]
    query, match, relative = (np.array(column) for column in zip(*edges, strict=True))
    scores = score_loops(7, query, match, relative, truth, stamps)
    assert (scores.proposed, scores.verified, scores.true, scores.false) == (7, 4, 2, 2)
    assert scores.precision == 0.5 and scores.recall == 1.0
    assert true_revisits(truth, stamps).tolist() == [2]
    assert scores.error_m == pytest.approx(0.49 / np.sqrt(2.0)), "the edges at 0.49 m and 0.19 rad are true"
    assert scores.error_rad == pytest.approx(0.19 / np.sqrt(2.0))
    scores = score_loops(7, query[1:2], match[1:2], relative[1:2], truth, stamps)
    assert (scores.recall, scores.error_m, scores.error_rad) == (0.0, None, None)


def test_a_revisit_in_the_opposite_direction_was_never_seen_from_its_own():
    """Out along x, back, and out again; 20 s between keyframes."""
    truth = np.tile(np.eye(4), (9, 1, 1))
    truth[:, 0, 3] = [0.0, 2.0, 4.0, 4.0, 2.0, 0.0, 0.0, 2.0, 4.0]
    truth[3:6, :2, :2] *= -1.0
    stamps = 20.0 * np.arange(9)
    assert opposite_revisits(truth, stamps).tolist() == [3, 4, 5]
    assert true_revisits(truth, stamps).tolist() == [6, 7, 8]
    assert opposite_edges(np.array([5, 7, 7]), np.array([0, 1, 4]), truth).tolist() == [True, False, True]


def test_a_revisit_lies_ten_seconds_back():
    truth = np.stack([pose(), pose(0.5)])
    assert true_revisits(truth, np.array([0.0, 9.9])).tolist() == []
    assert true_revisits(truth, np.array([0.0, 10.0])).tolist() == [1]
    rounded = np.array([0.1 * 82, 0.1 * 182])
    assert rounded[1] - rounded[0] < 10.0 and true_revisits(truth, rounded).tolist() == [1]


def plain_pairs(truth, stamps):
    """The later and the earlier keyframe of all pairs within 1 m and 10 s apart, by comparing all pairs."""
    later, earlier = np.nonzero(stamps[:, None] - stamps >= 10.0)
    near = np.linalg.norm(truth[later, :3, 3] - truth[earlier, :3, 3], axis=1) <= 1.0
    return later[near], earlier[near]


@given(st.integers(0, 30), st.integers(0, 2**32 - 1))
def test_revisits_and_places_are_those_of_all_pairs(n, seed):
    """Distances of exactly 1 m are frequent, and stamps need not ascend, because sessions have clocks of their own."""
    rng = np.random.default_rng(seed)
    truth = np.array([pose(0.25 * x, yaw) for x, yaw in zip(rng.integers(0, 12, n), rng.uniform(0, 7, n), strict=True)])
    truth, stamps = truth.reshape(n, 4, 4), rng.permutation(2.5 * np.arange(n))
    later, earlier = plain_pairs(truth, stamps)
    angle = separation(truth[later], truth[earlier])[1]
    same, opposite = np.unique(later[angle <= 0.5]), later[angle >= np.pi - 0.5]
    np.testing.assert_array_equal(true_revisits(truth, stamps), same)
    np.testing.assert_array_equal(opposite_revisits(truth, stamps), np.setdiff1d(opposite, same))
    near = np.linalg.norm(truth[:, None, :3, 3] - truth[:, :3, 3], axis=2) <= 1.0
    first, second = np.nonzero(near)
    near[first, second] = separation(truth[first], truth[second])[1] <= 0.5
    np.testing.assert_array_equal(at_one_place(truth), near)
    path_m = np.sort(rng.uniform(0.0, 30.0, n))
    old = [old_enough(query, stamps, path_m, PlaceRecognitionConfig()) for query in range(n)]
    right = np.nonzero(near & np.array(old, bool).reshape(n, n))
    np.testing.assert_array_equal(right_matches(truth, stamps, path_m, PlaceRecognitionConfig()), right)


def plain_right_matches(truth):
    """Right matches at 1 frame per second and 2 m per frame."""
    return right_matches(truth, 1.0 * np.arange(len(truth)), 2.0 * np.arange(len(truth)), PlaceRecognitionConfig())


def test_a_true_edge_within_one_visit_finds_no_revisit():
    """Odometry alone could give such edges to all frames."""
    truth, stamps = np.stack([pose(), pose(0.1), pose(0.2), pose(0.1)]), np.array([0.0, 1.0, 20.0, 21.0])
    step, again = between(truth[2], truth[3]), between(truth[1], truth[3])
    within = score_loops(1, np.array([3]), np.array([2]), step[None], truth, stamps)
    across = score_loops(1, np.array([3]), np.array([1]), again[None], truth, stamps)
    assert (within.precision, within.recall, across.recall) == (1.0, 0.0, 0.5)


@pytest.mark.parametrize("found", [lambda truth: true_revisits(truth, 1.0 * np.arange(len(truth))), plain_right_matches])
def test_revisits_and_places_take_no_memory_for_keyframes_far_apart(found):
    truth = np.tile(np.eye(4), (3000, 1, 1))
    truth[:, 0, 3] = 2.0 * np.arange(3000)
    found(truth[:10])
    tracemalloc.start()
    found(truth)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5_000_000  # bytes: a matrix of all pairs would have 9 MB


def test_place_recognition_asks_for_n_right_matches():
    truth = np.stack([pose(), pose(0.5), pose(0.9), pose(3.0), pose(0.0, 1.0), pose(0.1)])
    candidates = [(5, (0, 1, 2, 3, 4)), (3, (0, 1)), (4, ())]
    earlier = np.tri(6, k=-1, dtype=bool)
    counts = [count_matches(candidates, csr_array(earlier & at_one_place(truth)), n) for n in (1, 3, 5)]
    assert counts == [MatchCounts(1, 1, possible=3), MatchCounts(1, 1, possible=1), MatchCounts(0, 2, possible=0)]
    assert [count.precision for count in counts] == [0.5, 0.5, 0.0]
    assert MatchCounts(0, 0, possible=1).precision is None


def test_a_keyframe_that_is_not_old_enough_is_no_right_match():
    earlier = csr_array(np.tri(3, k=-1, dtype=bool))
    itself = [(query, (query,)) for query in range(3)]
    assert count_matches(itself, earlier, 1) == MatchCounts(0, 3, possible=2)
    repeated = [(2, (0, 0, 0))]
    assert [count_matches(repeated, earlier, n).tp for n in (1, 2, 3)] == [1, 0, 0]


def test_a_query_is_possible_where_enough_keyframes_that_may_be_proposed_are_at_its_place():
    truth = np.stack([pose(), pose(0.5), pose(0.9), pose(3.0), pose(0.0, 1.0), pose(0.1)])
    everyone, near = [(query, ()) for query in range(6)], at_one_place(truth)
    earlier = np.tri(6, k=-1, dtype=bool)
    assert [count_matches(everyone, csr_array(earlier & near), n).possible for n in (1, 2, 3, 4)] == [
        3,
        2,
        1,
        0,
    ]
    long_before = np.tri(6, k=-3, dtype=bool)  # only 0, 1 and 2 are old enough to be matched with 5
    assert [count_matches(everyone, csr_array(long_before & near), n).possible for n in (1, 3, 4)] == [
        1,
        1,
        0,
    ]


def test_a_query_that_nobody_lists_is_possible_all_the_same():
    """Otherwise, a method that lists its few right answers alone would seem to find all revisits."""
    truth, earlier = np.stack([pose(), pose(0.5), pose(0.9), pose(3.0)]), np.tri(4, k=-1, dtype=bool)
    right = csr_array(earlier & at_one_place(truth))
    assert count_matches([(1, (0,))], right, 1) == MatchCounts(1, 0, possible=2)


@given(arrays(np.float64, 12, elements=st.floats(0.0, 4.0)), st.integers(1, 5))
def test_no_more_queries_are_right_than_possible(x, n):
    truth, earlier = np.stack([pose(at) for at in x]), np.tri(12, k=-2, dtype=bool)
    candidates = [(query, tuple(range(max(query - 1, 0)))) for query in range(12)]
    counts = count_matches(candidates, csr_array(earlier & at_one_place(truth)), n)
    assert counts.tp == counts.possible and counts.tp + counts.fp == 10


def test_a_walk_is_covered_between_keyframes_that_are_no_more_than_three_metres_apart():
    assert path_covered(np.array([0.0, 3.0, 6.0]), 6.0) == 1.0
    assert path_covered(np.array([6.0, 0.0, 3.0]), 6.0) == 1.0
    assert path_covered(np.array([1.0, 2.0, 5.5, 6.0]), 10.0) == pytest.approx(0.15)
    assert path_covered(np.array([4.0]), 10.0) == 0.0
    assert path_covered(np.array([0.0]), 0.0) is None


def test_spl_weighs_success_by_the_shortest_path():
    success = np.array([True, True, False, True])
    assert spl(success, np.array([2.0, 3.0, 1.0, 0.0]), np.array([4.0, 2.9, 1.0, 0.0])) == pytest.approx(
        (0.5 + 1 + 0 + 1) / 4
    )
    assert success_rate(success) == 0.75


def test_what_cannot_be_measured_is_none():
    nothing, nowhere = np.zeros(0, bool), np.zeros(0)
    assert accuracy(NOBODY, NOBODY) is None and graded_accuracy(NOBODY, np.zeros((0, 3), bool)) is None
    assert set(vars(score_rooms(NOBODY, NOBODY)).values()) == {None}
    assert set(vars(score_rooms(np.array([3]), np.array([0]))).values()) == {None}, "one keyframe cannot be grouped wrongly"
    assert floor_accuracy(NOBODY, NOBODY, nothing) is None and floor_count_error(NOBODY, NOBODY, nothing) is None
    assert spl(nothing, nowhere, nowhere) is None and success_rate(nothing) is None
    scores = score_loops(0, NOBODY, NOBODY, np.zeros((0, 4, 4)), np.zeros((0, 4, 4)), nowhere)
    assert scores.precision is None and scores.recall is None
