"""Comparisons of two SLAMs: no false alarms, enough power, exact counts."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT
from helpers.results import RESULT
from scipy.stats import binom

from sim.errors import SimError
from sim.harness.adapters import OdometryOnly
from sim.verdicts.comparison import compare, compare_results


def results(accuracies, pqs=None):
    """Results of as many scenarios as there are label accuracies."""
    pqs = [0.7] * len(accuracies) if pqs is None else pqs
    return [
        replace(
            RESULT, scenario=f"{i:016x}", labels=replace(RESULT.labels, accuracy=each), rooms=replace(RESULT.rooms, pq=pq)
        )
        for i, (each, pq) in enumerate(zip(accuracies, pqs, strict=True))
    ]


def noisy(rng, houses, drop=0.0, noise=0.05):
    """Results of two SLAMs, the second of which loses `drop` of its label accuracy; both differ by chance as well."""
    level = rng.normal(0.85, 0.08, houses)
    a, b = (np.clip(level + rng.normal(0, noise, houses), 0, 1) for _ in range(2))
    return results(a, rng.normal(0.6, 0.1, houses)), results(np.clip(b - drop, 0, 1), rng.normal(0.6, 0.1, houses))


def test_a_slam_compared_with_itself_is_hardly_ever_called_worse():
    rng = np.random.default_rng(0)
    compared = [compare_results(*noisy(rng, 40)) for _ in range(200)]
    assert np.mean([bool(each.worse) for each in compared]) <= 0.05
    assert np.mean([set(each.verdicts.values()) != {"not shown to differ"} for each in compared]) <= 0.05


def test_a_drop_of_three_points_of_label_accuracy_is_found_in_120_houses():
    rng = np.random.default_rng(1)
    found = ["labels.accuracy" in compare_results(*noisy(rng, 120, drop=0.03)).worse for _ in range(100)]
    assert np.mean(found) >= 0.8


def test_equal_results_differ_nowhere():
    a = results([0.9, 0.8, 0.7])
    compared = compare_results(a, a, ["rooms.pq >= 0.6"])
    assert compared.worse == ()
    assert all(each.p_value == 1.0 for each in (*compared.figures, *compared.claims))


def test_exchanging_the_slams_exchanges_the_verdicts():
    a, b = results(np.linspace(0.8, 0.9, 30)), results(np.linspace(0.7, 0.8, 30))
    forth, back = compare_results(a, b), compare_results(b, a)
    assert (forth.verdicts["labels.accuracy"], back.verdicts["labels.accuracy"]) == ("worse", "better")
    (low, high), (back_low, back_high) = (each.figures[0].interval(0.95) for each in (forth, back))
    assert (low, high) == pytest.approx((-back_high, -back_low))


def test_the_sign_test_counts_scenarios_without_ties():
    change = compare_results(results([0.5] * 10), results([0.4] * 7 + [0.6] + [0.5] * 2)).figures[0]
    assert (change.better, change.worse) == (1, 7)
    assert change.p_value == pytest.approx(2 * binom.cdf(1, 8, 0.5))


def test_a_smaller_error_is_better():
    a = results([0.9] * 12)
    b = [replace(each, trajectory=replace(each.trajectory, ate_m=0.1)) for each in a]
    assert compare_results(a, b).verdicts["trajectory.ate_m"] == "better"


def test_a_claim_is_compared_by_the_scenarios_in_which_it_holds_for_one_slam_only():
    a, b = results([0.9] * 10), results([0.6] * 8 + [0.9] * 2)
    (change,) = compare_results(a, b, ["labels.accuracy >= 0.7"]).claims
    assert (change.only_a, change.only_b, change.both, change.neither) == (8, 0, 2, 0)
    assert change.p_value == pytest.approx(2 * 0.5**8)


def test_results_without_a_figure_say_nothing_about_it():
    a, b = results([0.9, 0.8, 0.7]), results([0.9, None, None])
    figure = compare_results(a, b).figures[0]
    assert len(figure.a) == 1


def test_only_common_scenarios_are_compared():
    a, b = results([0.9, 0.8, 0.7]), results([0.9, 0.8, 0.7])[1:]
    assert compare_results(a, b).scenarios == 2


def test_results_that_cannot_be_paired_are_refused():
    a = results([0.9])
    with pytest.raises(SimError, match="no scenario in common; valid: results of two SLAMs on the same scenarios"):
        compare_results(a, [])
    with pytest.raises(SimError, match=f"scenario {a[0].scenario} has two results on one side"):
        compare_results([*a, *a], a)
    with pytest.raises(SimError, match="confidence is 2"):
        compare_results(a, a, confidence=2.0)


def test_two_slams_run_on_the_same_scenarios():
    scenarios = [replace(OPEN_FLAT, seed=seed) for seed in (1, 2)]
    compared = compare(OdometryOnly, OdometryOnly, scenarios)
    assert compared.scenarios == 2
    assert compared.worse == ()
    assert "trajectory.ate_m" in str(compared)
