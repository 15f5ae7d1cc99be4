"""The sequential test of a rate keeps its error bounds, although it is evaluated after every house."""

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.results import RESULT
from helpers.unchecked import untyped

from sim.errors import SimError
from sim.harness import Scenario
from sim.verdicts.mean import assert_mean
from sim.verdicts.rate import RateVerdict, _log_evidence, assert_rate

P = (0.5, 0.9, 0.95, 0.99)


def results(*accuracies):
    labels = [replace(RESULT.labels, accuracy=accuracy) for accuracy in accuracies]
    return [replace(RESULT, scenario=str(i), labels=each) for i, each in enumerate(labels)]


def first_outcomes(p, true_rate, streams=10_000, houses=400, seed=0):
    """The first definite outcome of each simulated stream of houses, or "undecided"."""
    held = np.cumsum(np.random.default_rng(seed).random((streams, houses)) < true_rate, axis=1)
    outcomes = np.full(streams, "undecided")
    known = {}
    for n in range(1, houses + 1):
        open_streams = np.flatnonzero(outcomes == "undecided")
        now = held[open_streams, n - 1]
        for count in np.unique(now).tolist():
            known[count, n] = RateVerdict(p, 0.95, count, n).outcome
        outcomes[open_streams] = [known[count, n] for count in now.tolist()]
    return outcomes


def test_shares_are_told_with_all_their_digits():
    told = str(RateVerdict(0.995, 0.9999, 5, 5))
    assert "wanted: in 99.5%" in told and "with 99.99% confidence" in told


@pytest.mark.parametrize(("held", "outcome"), [(0, "fails"), (8, "holds")])
def test_the_bounds_as_they_are_shown_agree_with_the_outcome(held, outcome):
    """The upper bound of 0 of 8 houses is 0.49968: rounded to 0.500, it would not show why a rate of 50 % fails."""
    verdict = RateVerdict(0.5, 0.99, held, 8)
    low, high = map(float, re.search(r"at least ([\d.]+), at most ([\d.]+) with", str(verdict)).groups())
    assert verdict.outcome == outcome and (high < 0.5 if outcome == "fails" else low > 0.5)


@pytest.mark.parametrize("p", P)
def test_a_rate_that_is_reached_is_hardly_ever_denied_at_any_time(p):
    assert (first_outcomes(p, p) == "fails").mean() <= 0.05


@pytest.mark.parametrize("p", P)
def test_a_rate_that_is_missed_is_hardly_ever_confirmed_at_any_time(p):
    assert (first_outcomes(p, p - 1e-6) == "holds").mean() <= 0.05


def test_houses_that_count_by_shares_keep_the_error_bound():
    rng = np.random.default_rng(3)
    p, of_houses = 0.8, rng.choice([0.6, 1.0], size=(1000, 40))  # a claim holds in three or in all five scenarios of a house
    denied = 0
    for held in np.cumsum(of_houses, axis=1).tolist():
        denied += any(RateVerdict(p, 0.95, count, n).outcome == "fails" for n, count in enumerate(held, 1))
    assert denied <= 50


@pytest.mark.parametrize(("p", "true_rate", "outcome"), [(0.5, 0.8, "holds"), (0.9, 0.6, "fails"), (0.95, 0.7, "fails")])
def test_a_clear_answer_is_found(p, true_rate, outcome):
    assert (first_outcomes(p, true_rate, streams=1000) == outcome).mean() >= 0.95


def test_the_interval_covers_the_true_rate_after_all_houses_at_once():
    intervals = {(count, n): RateVerdict(0.5, 0.9, count, n).interval for n in range(1, 61) for count in range(n + 1)}
    for true_rate in (0.45, 0.9, 0.985):
        held = np.cumsum(np.random.default_rng(1).random((300, 60)) < true_rate, axis=1).tolist()
        now = np.array([[intervals[count, n] for n, count in enumerate(row, 1)] for row in held])
        covered = ((now[..., 0] <= true_rate) & (true_rate <= now[..., 1])).all(axis=1)
        assert covered.mean() >= 0.8  # two bounds, each with 90 %


def test_the_interval_does_not_depend_on_the_wanted_rate():
    assert len({RateVerdict(p, 0.9, 5, 7).interval for p in P}) == 1


@pytest.mark.parametrize(("held", "houses"), [(k, n) for n in (1, 7, 30) for k in range(n + 1)])
def test_the_evidence_is_an_expected_value_of_one_under_the_wanted_rate(held, houses):
    failed = houses - held
    now, more, less = (_log_evidence(0.8, *counts) for counts in ((held, failed), (held + 1, failed), (held, failed + 1)))
    for side in (0, 1):
        after = 0.8 * np.exp(more[side]) + 0.2 * np.exp(less[side])
        assert after == pytest.approx(np.exp(now[side]), rel=1e-9)


@pytest.mark.parametrize("houses", [1, 6, 36, 80])
@pytest.mark.parametrize("p", P)
def test_the_bounds_agree_with_the_outcome(p, houses):
    for held in range(houses + 1):
        verdict = RateVerdict(p, 0.95, held, houses)
        low, high = verdict.interval
        assert verdict.outcome == ("holds" if p <= low else "fails" if p >= high else "undecided")


def test_reading_stops_when_the_answer_is_known():
    stream = iter(results(*[0.9] * 100))
    verdict = assert_rate(stream, "labels.accuracy >= 0.7", p=0.9)
    assert verdict.outcome == "holds"
    assert len(list(stream)) == 100 - verdict.houses > 50


def test_a_missed_rate_says_how_often_the_claim_held():
    with pytest.raises(AssertionError, match=r"^labels.accuracy >= 0.7: holds in 0 of 2 houses \(wanted: in 90%; .* fails"):
        assert_rate(results(0.6, None, 0.9), "labels.accuracy >= 0.7", p=0.9)


def test_a_figure_that_is_not_estimated_is_told():
    with pytest.raises(AssertionError, match=r": fails; not estimated in 1 of 2 results, which count as failures$"):
        assert_rate(results(0.6, None, 0.9), "labels.accuracy >= 0.7", p=0.9)
    with pytest.raises(AssertionError, match=r": undecided; not estimated in 2 of 3 results, which count as failures$"):
        assert_rate(results(None, 0.9, None), "labels.accuracy >= 0.7", p=0.4)
    with pytest.raises(AssertionError, match=r": fails$"):
        assert_rate(results(0.6, 0.6), "labels.accuracy >= 0.7", p=0.9)


def test_an_undecided_rate_does_what_the_option_says():
    few = results(0.9, 0.9, 0.6)
    with pytest.raises(AssertionError, match=r"holds in 2 of 3 houses .*undecided$"):
        assert_rate(few, "labels.accuracy >= 0.7", p=0.8)
    with pytest.raises(pytest.skip.Exception, match=r"undecided$"):
        assert_rate(few, "labels.accuracy >= 0.7", p=0.8, undecided="skip")
    assert assert_rate(few, "labels.accuracy >= 0.7", p=0.8, undecided="pass").outcome == "undecided"


def test_no_house_at_all_decides_nothing():
    verdict = assert_rate([], "labels.accuracy >= 0.7", p=0.5, undecided="pass")
    assert (verdict.outcome, verdict.interval) == ("undecided", (0.0, 1.0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"p": 1.0}, "p is 1.0; valid: a number above 0 and below 1, such as 0.9"),
        ({"p": 0.5, "confidence": 0.2}, "confidence is 0.2; valid: a number above 0.5"),
        ({"p": "0.9"}, "p is '0.9'; valid: a number"),
        ({"p": 0.5, "undecided": "ignore"}, "undecided is 'ignore'; valid: 'fail', 'pass' or 'skip'"),
        ({"p": 0.5, "claim": "labels.accuracies > 1"}, "no figure 'accuracies'"),
    ],
)
def test_arguments_are_checked(arguments, message, monkeypatch):
    monkeypatch.setattr(RateVerdict, "__init__", untyped(RateVerdict.__init__))
    with pytest.raises(SimError, match=message):
        untyped(assert_rate)(**{"results": [], "claim": "labels.accuracy >= 0.7"} | arguments)


@pytest.mark.parametrize(("function", "options"), [(assert_rate, {"p": 0.5}), (assert_mean, {})])
def test_runs_in_one_scenario_are_no_independent_results(function, options):
    """One result, given often enough, would confirm every claim that holds in it."""
    first, second = results(0.9, 0.9)
    again = replace(second, seed=8)
    with pytest.raises(
        SimError, match=rf"^{function.__name__}: results\[2\] is a run in the scenario of results\[1\]; valid"
    ):
        function([first, second, *[again] * 8], "labels.accuracy >= 0.7", **options)


@pytest.mark.parametrize("function", [assert_rate, assert_mean])
@pytest.mark.parametrize(
    ("results", "claim", "message"),
    [
        ("rooms.pq >= 0.5", [RESULT], 'claim is an instance of list; valid: a claim, such as "rooms.pq >= 0.6"'),
        (RESULT, "rooms.pq >= 0.5", "results is an instance of RunResult; valid: several values of the class RunResult"),
        ([Scenario()], "rooms.pq >= 0.5", r"results\[0\] is an instance of Scenario; valid: an instance of RunResult"),
    ],
)
def test_arguments_of_the_wrong_kind_are_named(function, results, claim, message):
    options = {"p": 0.5} if function is assert_rate else {}
    with pytest.raises(SimError, match=f"^{function.__name__}: {message}"):
        untyped(function)(results, claim, **options)
