"""Table II: all methods label the same walks, and figures over rooms count each found room once."""

import numpy as np
import pytest

from sim.bench.peers import labels as module
from sim.bench.peers.labels import PAPER_ACCURACY, LabelRow, compare_labels, means, room_accuracy
from sim.errors import SimError
from sim.harness.adapters import OdometryOnly
from worlds.presets import PRESETS


def test_refinement_and_counts_help_and_no_votes_are_better_than_the_best_labels():
    (rows,) = compare_labels(("uh2-apt",), (120,), "features")
    found = {row.method: row.accuracy for row in rows}
    assert found["LEXIS, refined (paper)"] > found["LEXIS, baseline (paper)"]
    assert found["Hydra-like, counts"] > found["Hydra-like, similarity"]
    hydra = [value for name, value in found.items() if name.startswith("Hydra")]
    assert len(hydra) == 4 and max(hydra) == found["Hydra-like, best labels"]
    assert {row.method: row.rooms for row in rows}["Hydra-like, best labels"] == 1.0


def test_a_found_room_counts_once_however_many_keyframes_it_has():
    rooms, truth = np.array([4, 4, 4, 4, 7, 9]), np.array([0, 0, 0, 1, 1, 2])
    assert room_accuracy(np.array([0, 0, 0, 0, 2, -1]), rooms, truth) == pytest.approx(1 / 3)
    assert room_accuracy(np.array([2, 2, 2, 2, 1, 2]), rooms, truth) == pytest.approx(2 / 3)


def test_means_are_over_the_houses_of_one_preset_and_rooms_may_be_unknown():
    rows = [LabelRow("home", 1, "a", 0.4, None), LabelRow("home", 2, "a", 0.6, None), LabelRow("ori", 1, "a", 1.0, 0.5)]
    found = means(rows)["a"]
    assert (found["home"].accuracy, found["home"].rooms, found["ori"].rooms) == (0.5, None, 0.5)
    assert found["home"].std == pytest.approx(0.1)


def test_a_missing_accuracy_is_left_out_of_the_mean():
    rows = [LabelRow("home", 1, "a", 0.4, None), LabelRow("home", 2, "a", None, None), LabelRow("ori", 1, "a", None, None)]
    found = means(rows)["a"]
    assert (found["home"].accuracy, found["home"].std) == (0.4, None)
    assert found["ori"].accuracy is found["ori"].std is None


def test_a_method_without_labels_has_no_accuracy(monkeypatch):
    names = "LEXIS, refined (paper)", "Hydra-like, counts"
    monkeypatch.setattr(module, "methods", lambda scenario, encoder: {name: OdometryOnly() for name in names})
    (rows,) = compare_labels(("home",), (120,), "features")
    assert len(rows) == 4 and {row.accuracy for row in rows} == {None}


def test_the_papers_figures_are_shares_of_known_presets():
    for method, figures in PAPER_ACCURACY.items():
        assert set(figures) <= set(PRESETS) and all(0.0 < std < mean < 1.0 for mean, std in figures.values()), method


def test_houses_that_a_method_learns_from_are_refused():
    with pytest.raises(SimError, match="learns from some of these houses; valid: other seeds than 100 to 119"):
        next(compare_labels(("home",), range(98, 102), "features"))
