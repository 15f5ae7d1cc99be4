"""Methods of place recognition answer the same queries, and a fit finds the settings that made the data."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from lexis.config import PlaceRecognitionConfig
from lexis.place_recognition import revisit_log_odds
from sim.bench.places import FITTED, METHODS, Answers, Pairs, ask_everywhere, compare_places, fit_revisits, walks


@pytest.fixture(scope="module")
def scenarios():
    found = walks(["uh2-apt"], [302], "features")
    assert len(found) == 3 and len({scenario.content_hash for each in found.values() for scenario in each}) == 3
    return {condition: each[0] for condition, each in found.items()}


@pytest.fixture(scope="module")
def usual_walks(scenarios):
    return [ask_everywhere(scenarios["usual odometry"])]


def test_the_map_of_a_kidnapped_robot_is_as_right_as_that_of_another_robot(scenarios, usual_walks):
    kidnapped = ask_everywhere(scenarios["kidnapped"])
    assert kidnapped.ate_odometry_m > 4 * usual_walks[0].ate_odometry_m
    assert kidnapped.ate_m < 1.5 * usual_walks[0].ate_m < 0.3


def test_the_probability_of_a_revisit_finds_more_and_answers_falsely_less_often(usual_walks):
    paper, similarity, probability = compare_places(usual_walks)
    for room, everywhere, likely in zip(paper.counts, similarity.counts, probability.counts, strict=True):
        assert likely.tp >= room.tp and likely.fp < room.fp <= everywhere.fp
        assert likely.possible == room.possible == everywhere.possible
    assert 2 * probability.counts[0].fp < paper.counts[0].fp


def test_pairs_are_the_eligible_ones(usual_walks):
    (answers,) = usual_walks
    assert len(answers.pairs.revisit) == answers.eligible.sum() == len(answers.pairs.distances_m)
    assert answers.pairs.revisit.sum() == (answers.right & answers.eligible).sum()
    for proposed in answers.proposed.values():
        for query, candidates in proposed:
            assert answers.eligible[query, list(candidates)].all()
    assert set(answers.proposed) == set(METHODS)


def test_a_fit_recovers_the_model_that_made_the_data(rng):
    n = 200_000
    near = rng.random(n) < 0.5
    similarities = rng.uniform(0.0, 1.0, n)
    distances, angles = rng.uniform(0, np.where(near, 1.5, 10.0)), rng.uniform(0, np.where(near, 0.8, np.pi))
    true = replace(
        PlaceRecognitionConfig(), log_odds=-3.0, similarity_weight=10.0, place_m=0.5, place_rad=0.3, lost_log_odds=6.0
    )
    revisit = rng.random(n) < expit(revisit_log_odds(similarities, distances, angles, true))
    pairs = Pairs(similarities, distances, angles, revisit)
    fitted = fit_revisits([Answers({}, np.zeros((0, 0), bool), np.zeros((0, 0), bool), pairs, None, None)])
    for name in FITTED:
        assert getattr(fitted, name) == pytest.approx(getattr(true, name), rel=0.1)
