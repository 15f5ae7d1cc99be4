"""Figures of place recognition: counts agree with a second count, and false matches are assigned to places."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.two_laps import two_laps, walk_of

from sim.baselines.places import EmbeddingSimilarity
from sim.bench.peers.place_figures import (
    FALSE_FIELDS,
    PLACES,
    PrecisionRecall,
    answers,
    figures,
    precision_recall,
    ranked,
    whereabouts,
)


@pytest.fixture
def walk(rng):
    return walk_of(two_laps(rng, noise=2.0))


def test_a_ranking_is_in_the_order_of_the_scores_and_equal_scores_in_the_order_of_the_walk():
    scores = np.array([[-np.inf, -np.inf, -np.inf], [0.5, -np.inf, -np.inf], [0.5, 0.5, 0.9]])
    ranking = ranked(scores, 2)
    assert ranking.keyframes[2].tolist() == [2, 0] and ranking.scores[1].tolist() == [0.5, -np.inf]
    assert answers(ranking, 0.5) == [(0, ()), (1, (0,)), (2, (2, 0))] and answers(ranking, 0.6)[1] == (1, ())


def test_counts_and_recall_of_a_perfect_method(walk):
    perfect = walk.seen.only_eligible(walk.right.astype(float))
    found = figures(walk, "perfect", perfect, 0.5)
    assert (found.row.tp_1, found.row.fp_1) == (found.row.possible_1, 0) and found.row.recall_at_1 == 1.0
    assert found.row.possible_3 == 0 and found.row.fp_3 == found.row.tp_1
    assert precision_recall([found]).at_full_precision == 1.0 == precision_recall([found]).average_precision


def test_stricter_answers_are_fewer_and_false_ones_are_split_without_rest(walk):
    scores = EmbeddingSimilarity().scores(walk.seen)
    before = None
    for least in (-1.0, 0.2, 0.4, 0.6):
        row = figures(walk, "embedding", scores, least).row
        assert sum(getattr(row, name) for name in FALSE_FIELDS) == row.fp_1
        assert before is None or (row.tp_1 <= before.tp_1 and row.fp_1 <= before.fp_1)
        before = row


def test_false_matches_are_assigned_to_the_first_place_that_fits(walk):
    poses = walk.T_W_B.copy()
    poses[:, :3, 3] = np.arange(len(poses))[:, None] * (5.0, 0.0, 0.0)
    poses[1] = poses[0] @ np.diag((-1.0, -1.0, 1.0, 1.0))
    rooms, labels, storeys = (np.zeros(len(poses), int) for _ in range(3))
    rooms[3:], labels[4:], storeys[[3, 5]] = np.arange(3, len(poses)), 1, 1
    other = replace(walk, T_W_B=poses, rooms=rooms, labels=labels, storeys=storeys)
    where = whereabouts(other, np.zeros(5, int), np.array([1, 2, 3, 5, 4]))
    assert [PLACES[each] for each in where] == list(PLACES)


def test_a_curve_counts_all_queries_with_at_least_the_score(walk):
    scores = EmbeddingSimilarity().scores(walk.seen)
    found = figures(walk, "embedding", scores, -1.0)
    line = precision_recall([found, found])
    least = np.sort(found.best)[::-1][3]
    answered = found.best >= least
    position = int(np.flatnonzero(np.sort(np.unique(found.best))[::-1] == least)[0])
    assert line.precision[position] == pytest.approx(found.right[answered].mean())
    assert line.recall[position] == pytest.approx(found.right[answered].sum() / found.row.possible_1)
    assert (np.diff(line.recall) >= 0).all()


def test_recall_at_full_precision_ends_at_the_first_false_match():
    line = PrecisionRecall(np.array([1.0, 1.0, 0.75, 0.8]), np.array([0.25, 0.5, 0.75, 1.0]))
    assert line.at_full_precision == 0.5 and line.average_precision == pytest.approx((1 + 1 + 0.75 + 0.8) / 4)
