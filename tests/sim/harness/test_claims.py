"""Claims are read from text, compared with figures, and say clearly what is wrong with them."""

import math

import pytest
from helpers.unchecked import unchecked
from hypothesis import given
from hypothesis import strategies as st

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.results import LabelFigures, RunResult

OPERATORS = st.sampled_from(("<", "<=", ">", ">=", "==", "!="))


def result(accuracy, baseline=None):
    """A result of which only the labels are looked at."""
    made = object.__new__(RunResult)
    object.__setattr__(made, "labels", LabelFigures(accuracy, baseline, per_room={"kitchen": 0.25}))
    return made


@given(OPERATORS, st.floats(-1e6, 1e6))
def test_text_and_back(comparison, limit):
    claim = Claim("labels.accuracy", comparison, float(f"{limit:g}"))
    assert Claim.parse(str(claim)) == claim


@given(OPERATORS, st.sampled_from((0.0, 0.5, 1.0)), st.sampled_from((0.0, 0.5, 1.0)))
def test_a_claim_holds_where_its_opposite_fails(comparison, value, limit):
    claim = Claim("labels.accuracy", comparison, limit)
    assert {claim.outcome(result(value)), claim.opposite.outcome(result(value))} == {"holds", "fails"}
    assert claim.opposite.opposite == claim
    assert claim.outcome(result(None)) == "unknown"


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_a_claim_about_two_figures_of_one_run(factor):
    claim = Claim.parse(f"labels.accuracy >= {factor} * labels.accuracy_baseline")
    assert claim == Claim("labels.accuracy", ">=", factor, "labels.accuracy_baseline") == Claim.parse(str(claim))
    assert claim.outcome(result(0.5, baseline=0.5)) == ("holds" if factor <= 1.0 else "fails")
    assert claim.opposite.outcome(result(0.5, baseline=0.5)) != claim.outcome(result(0.5, baseline=0.5))
    assert claim.outcome(result(None, baseline=0.5)) == claim.outcome(result(0.5)) == "unknown"
    assert claim.described(result(0.5)) == "labels.accuracy is 0.5, labels.accuracy_baseline is null"


@pytest.mark.parametrize("comparison", ["<", "<=", ">", ">="])
@pytest.mark.parametrize("accuracy", [0.4, 0.6])
def test_the_margin_of_a_claim_is_positive_where_it_holds(comparison, accuracy):
    claim = Claim.parse(f"labels.accuracy {comparison} 0.5")
    assert claim.margin(result(accuracy)) == pytest.approx(0.1 if claim.outcome(result(accuracy)) == "holds" else -0.1)
    assert claim.opposite.margin(result(accuracy)) == pytest.approx(-claim.margin(result(accuracy)))
    assert Claim.parse(f"labels.accuracy {comparison} labels.accuracy_baseline").margin(result(accuracy)) is None


def test_a_figure_alone_is_once_that_figure():
    assert Claim.parse("labels.accuracy > labels.accuracy_baseline") == Claim.parse(
        "labels.accuracy > 1 * labels.accuracy_baseline"
    )


def test_a_claim_about_faults_is_unknown_without_faults():
    assert Claim.parse("faults.delivered >= 1").outcome(result(0.9)) == "unknown"


def test_a_claim_keeps_all_digits_of_its_limit():
    for limit in (0.7142857142, 0.1 + 0.2, 0.12345678901234567, 1e-7, 1e22, 5e-324):
        claim = Claim("labels.accuracy", "<", limit)
        assert Claim.parse(str(claim)) == claim
    assert str(Claim("labels.accuracy", "<", 1.0)) == "labels.accuracy < 1"


def test_a_claim_about_one_room():
    assert Claim.parse("labels.per_room.kitchen < 0.5").outcome(result(0.9)) == "holds"
    for name in ("living room", "children's room", "open-plan office"):
        claim = Claim.parse(f"labels.per_room.{name} < 0.5")
        assert claim.outcome(result(0.9)) == "unknown" and Claim.parse(str(claim)) == claim


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "claim '' is not understood; valid: a figure, <"),
        ("labels.accuracy", "is not understood"),
        ("labels.accuracy < high", "no figure 'high'"),
        ("labels.accuracy < 2 labels.accuracy", "is not understood"),
        ("labels.accuracy < labels.accuracy * 2", "is not understood"),
        ("labels.accuracy < 2 * labels", "labels is no number"),
        ("labels.accuracy < 1.2.3", "'1.2.3' is no number"),
        ("labels.accuracy < 1e999", "the limit is inf; valid: a finite number"),
        ("labels.acc < 0.7", "no figure 'acc' (did you mean 'accuracy'?); valid: accuracy, accuracy_baseline"),
        ("rooms.pg < 0.5", "no figure 'pg' (did you mean 'pq'?); valid: pq, precision"),
        ("ate_m > 0.1", "no figure 'ate_m' (did you mean 'trajectory.ate_m'?); valid: seed, preset"),
        ("accuracy < 1", "no figure 'accuracy' (did you mean 'labels.accuracy' or 'floors.accuracy'?); valid: seed"),
        ("room.pq < 1", "no figure 'room' (did you mean 'rooms'?); valid: seed"),
        ("ate < 1", "no figure 'ate' (did you mean 'trajectory.ate_m'?); valid: seed"),
        ("trajectory_ate_m < 1", "no figure 'trajectory_ate_m' (did you mean 'trajectory.ate_m'?); valid: seed"),
        ("wheels < 1", "no figure 'wheels'; valid: seed"),
        ("realtime < 1", "no figure 'realtime' (did you mean 'time.realtime_factor'?); valid: seed"),
        ("labels < 0.7", "labels is no number; valid: the name of a figure below it"),
        ("labels.per_room < 0.7", "labels.per_room is no number; valid: the name of a figure below it"),
        ("labels.accuracy.x < 0.7", "labels.accuracy.x is no figure; valid: labels.accuracy"),
        ("place_recognition.1.precison >= 0.5", "no figure 'precison' (did you mean 'precision'?); valid: tp, fp"),
        ("place_recognition.2.precision >= 0.5", "no figure '2'; valid: 1, 3, 5"),
        ("faults.deliverd >= 1", "no figure 'deliverd' (did you mean 'delivered'?); valid: given, frames"),
        ("slam >= 1", "slam is no number; valid: a figure, such as labels.accuracy"),
        ("faults.given >= 1", "faults.given is no number; valid: a figure, such as labels.accuracy"),
    ],
)
def test_bad_claims_are_named(text, message):
    with pytest.raises(SimError) as caught:
        Claim.parse(text).outcome(result(0.5))
    assert message in str(caught.value)


def test_a_condition_is_called_one_in_messages():
    for text in ("rooms.pqq < 1", "rooms.pq <", "rooms.pq < 1.2.3"):
        with pytest.raises(SimError, match=r"^condition 'rooms"):
            Claim.parse(text, "condition")


def test_an_unknown_comparison_is_named():
    with pytest.raises(SimError, match=r"'rooms.pq => 0.6': unknown comparison; valid: <= >= == != < >"):
        Claim("rooms.pq", "=>", 0.6)


@pytest.mark.parametrize("limit", ["0.6", None, math.inf])
def test_a_limit_that_is_no_finite_number_is_named(limit):
    with pytest.raises(SimError, match=r"claim 'rooms.pq': the limit is .*; valid: a finite number"):
        unchecked(Claim, figure="rooms.pq", comparison=">=", limit=limit)
