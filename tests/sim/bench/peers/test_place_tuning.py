"""Tuning finds the least score and the settings with the largest F1 score, as an exhaustive search does."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.two_laps import two_laps, walk_of

from sim.baselines.places import EmbeddingSimilarity, SequenceMatching
from sim.bench.peers import place_tuning as module
from sim.bench.peers.place_figures import REQUIRED, figures
from sim.bench.peers.place_methods import METHODS
from sim.bench.peers.place_tuning import SEARCHES, SettingsSearch, best_least, tune


@pytest.fixture
def walks(rng):
    return [walk_of(two_laps(rng, noise=1.0), spacing_m=0.3) for _ in range(2)]


def mean_f1(walks, method, least):
    rows = [figures(walk, "any", method.scores(walk.seen), least).row for walk in walks]
    sums = {n: [sum(getattr(row, f"{name}_{n}") for row in rows) for name in ("tp", "fp", "possible")] for n in REQUIRED}
    return np.mean([2.0 / ((tp + fp) / tp + possible / tp) if tp else 0.0 for tp, fp, possible in sums.values()])


def test_no_other_least_score_has_a_larger_f1_score(walks):
    method = EmbeddingSimilarity()
    least, largest = best_least(method, walks)
    scores = np.concatenate([method.scores(walk.seen).max(axis=1) for walk in walks])
    assert mean_f1(walks, method, least) == pytest.approx(largest)
    assert largest == pytest.approx(max(mean_f1(walks, method, each) for each in scores[np.isfinite(scores)]))


def test_queries_with_equal_scores_are_answered_together(walks):
    class Rounded:
        def scores(self, seen):
            return EmbeddingSimilarity().scores(seen).round()

    walks.append(replace(walks[0], right=np.zeros_like(walks[0].right)))  # its queries follow those with right matches
    least, f1 = best_least(Rounded(), walks)
    assert f1 == pytest.approx(mean_f1(walks, Rounded(), least))


def test_settings_are_the_best_of_each_axis_and_every_tuned_method_takes_part(walks, monkeypatch):
    axes = ([{"length": each} for each in (1, 4, 8)],)
    monkeypatch.setattr(module, "SEARCHES", {"sequences": SettingsSearch(SequenceMatching, axes)})
    (tuned,) = tune(walks)
    every = {each: best_least(SequenceMatching(each), walks) for each in (1, 4, 8)}
    best = max(every, key=lambda each: every[each][1])
    assert tuned.settings == {"length": best} and (tuned.least, tuned.f1) == every[best]
    assert set(SEARCHES) == set(METHODS) - {"LEXIS"}


def test_a_method_without_answers_has_no_f1_score(walks):
    class Silent:
        def scores(self, seen):
            return np.full(seen.eligible.shape, -np.inf)

    assert best_least(Silent(), walks) == (np.inf, 0.0)
