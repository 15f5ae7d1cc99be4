"""Comparisons of two SLAMs: no false alarms, enough power, exact counts."""

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT
from helpers.results import RESULT
from helpers.unchecked import untyped
from scipy.stats import binom

from sim.errors import SimError
from sim.harness.adapters import OdometryOnly
from sim.harness.results import MatchFigures
from sim.programs import Program
from sim.verdicts.comparison import ClaimChange, FigureChange, Rule, compare, compare_results


def results(accuracies, pqs=None):
    """Results of as many scenarios as there are label accuracies."""
    pqs = [0.7] * len(accuracies) if pqs is None else pqs
    found = []
    for i, (accuracy, pq) in enumerate(zip(accuracies, pqs, strict=True)):
        labels, rooms = replace(RESULT.labels, accuracy=accuracy), replace(RESULT.rooms, pq=pq)
        found.append(replace(RESULT, scenario=f"{i:016x}", seed=i, labels=labels, rooms=rooms))
    return found


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


def test_means_are_over_the_houses_in_which_both_slams_have_the_figure():
    compared = compare_results(results([0.9, 0.5, 0.5]), results([0.8, None, None]))
    (change,) = (each for each in compared.figures if each.name == "labels.accuracy")
    assert change.means == (0.9, 0.8) and (change.better, change.worse) == (0, 3)
    assert "labels.accuracy: only one SLAM has it in 2 of 3 houses" in str(compared)


def test_a_figure_that_only_one_slam_has_is_shown_and_counts_for_it():
    compared = compare_results(results([0.9, 0.5]), results([None, None]))
    (change,) = (each for each in compared.figures if each.name == "labels.accuracy")
    assert change.means == (0.7, None) and (change.better, change.worse) == (0, 2)
    (row,) = (line.split() for line in str(compared).splitlines() if line.startswith("labels.accuracy "))
    assert row[1:3] == ["0.700", "-"]
    assert "labels.accuracy: only one SLAM has it in 2 of 2 houses, which count for this SLAM\n" in f"{compared}\n"


def test_keyframes_that_end_just_before_the_walk_does_are_no_loss_of_coverage():
    """A SLAM with keyframes half a metre apart, compared with one that returns a pose for every frame of 80 m."""
    frames = [replace(each, coverage=replace(each.coverage, path_covered=1.0)) for each in results([0.9] * 12)]
    keyframes = [replace(each, coverage=replace(each.coverage, path_covered=1.0 - 0.5 / 80.0)) for each in frames]
    assert compare_results(frames, keyframes).verdicts["coverage.path_covered"] == "not shown to differ"


def test_the_table_says_how_often_a_claim_holds_for_each_slam():
    compared = compare_results(results([0.9, 0.5, 0.9, 0.9]), results([0.5, 0.5, 0.9, 0.5]), ["labels.accuracy >= 0.8"])
    (claim,) = (each for each in compared.claims if each.name == "labels.accuracy >= 0.8")
    assert claim.shares == (0.75, 0.25)
    (row,) = (line for line in str(compared).splitlines() if line.startswith("labels.accuracy >= 0.8"))
    assert row.split()[3:6] == ["75%", "25%", "0/2"]


def test_exchanging_the_slams_exchanges_the_verdicts():
    a, b = results(np.linspace(0.8, 0.9, 30)), results(np.linspace(0.7, 0.8, 30))
    forth, back = compare_results(a, b), compare_results(b, a)
    assert (forth.verdicts["labels.accuracy"], back.verdicts["labels.accuracy"]) == ("worse", "better")
    (low, high), (back_low, back_high) = (each.figures[0].interval(0.95) for each in (forth, back))
    assert (low, high) == pytest.approx((-back_high, -back_low))


def test_the_interval_of_the_median_change_covers_it():
    rng = np.random.default_rng(2)
    covered = []
    for _ in range(400):
        change = FigureChange("labels.accuracy", Rule(1, 0.0), np.zeros(25), rng.exponential(1.0, 25) - np.log(2.0))
        low, high = change.interval(0.9)
        covered.append(low <= 0.0 <= high)
    assert np.mean(covered) >= 0.88
    assert FigureChange("labels.accuracy", Rule(1, 0.0), np.zeros(5), np.ones(5)).interval(0.95) is None


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
    completed, change = compare_results(a, b, ["labels.accuracy >= 0.7"] * 2).claims
    assert completed.others == 10
    assert (change.only_a, change.only_b, change.others) == (8, 0, 2)
    assert change.p_value == pytest.approx(2 * 0.5**8)


def test_a_figure_that_is_lost_counts_as_worse():
    a, b = results([0.9] * 20), results([0.95] * 2 + [None] * 18)
    assert compare_results(a, b).verdicts["labels.accuracy"] == "worse"
    assert compare_results(b, a).verdicts["labels.accuracy"] == "better"


def test_figures_that_neither_slam_has_are_left_out():
    a = results([0.9] * 3)
    assert "loops.recall" not in [change.name for change in compare_results(a, a).figures]


def test_scenarios_in_which_only_one_slam_has_a_result_count():
    a, b = results([0.9] * 20), results([0.9] * 20)[12:]
    compared = compare_results(a, b)
    assert compared.scenarios == 8 and compared.worse == ("the run completes",)


def test_scenarios_of_one_house_count_as_one():
    a, b = results([0.9] * 12), results([0.8] * 12)
    one_house = [[replace(each, seed=5) for each in side] for side in (a, b)]
    assert compare_results(*one_house).worse == () and compare_results(*one_house).houses == 1
    assert compare_results(a, b).worse == ("labels.accuracy",)


def test_houses_of_one_seed_are_told_apart_by_preset_and_area():
    a, b = (
        [
            replace(each, seed=5, house=replace(each.house, area_m2=50.0 + i))
            for i, each in enumerate(results([accuracy] * 12))
        ]
        for accuracy in (0.9, 0.8)
    )
    assert compare_results(a, b).houses == 12 and compare_results(a, b).worse == ("labels.accuracy",)
    presets = [[replace(each, seed=5, preset=f"{i % 2}") for i, each in enumerate(results([0.9] * 12))]] * 2
    assert compare_results(*presets).houses == 2


def test_a_scenario_in_which_one_side_lacks_a_figure_does_not_move_the_mean_of_its_house():
    def side(accuracies):
        return [replace(each, seed=each.seed // 2) for each in results(accuracies)]

    lacking, hard = side([0.6, None] * 12), side([0.6, 0.2] * 12)
    compared = compare_results(lacking, hard)
    assert compared.worse == () and compared.verdicts["labels.accuracy"] == "not shown to differ"
    assert compare_results(side([None, None] * 12), side([0.6, 0.2] * 12)).verdicts["labels.accuracy"] == "better"


def test_lost_scenarios_of_one_house_count_as_one_lost_run():
    a = [replace(each, seed=each.seed // 4) for each in results([0.9] * 20)]
    completed = compare_results(a, a[8:]).claims[0]
    assert (completed.only_a, completed.only_b, completed.others) == (2, 0, 3)
    assert completed.p_value == pytest.approx(0.5)
    other = compare_results([*a[:1], *a[4:]], [*a[1:]]).claims[0]
    assert (other.only_a, other.only_b, other.others) == (0, 1, 4)


def test_differences_that_do_not_matter_are_ties():
    a, b = results([0.9] * 20), results([0.8995] * 20)
    assert compare_results(a, b).figures[0].worse == 0


def test_results_that_cannot_be_paired_are_refused():
    a = results([0.9])
    with pytest.raises(SimError, match="no scenario in common; valid: results of two SLAMs on the same scenarios"):
        compare_results(a, [])
    with pytest.raises(SimError, match=f"scenario {a[0].scenario} has two results on one side"):
        compare_results([*a, *a], a)
    with pytest.raises(SimError, match="confidence is 2"):
        compare_results(a, a, confidence=2.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([OPEN_FLAT], OdometryOnly, OdometryOnly), "a is an instance of list; valid: the class of a SLAM, or a function"),
        ((OdometryOnly, OdometryOnly(), [OPEN_FLAT]), "b is an instance of OdometryOnly; valid: the class of a SLAM"),
        (
            (OdometryOnly, Program("slam {dataset} {out}"), [OPEN_FLAT]),
            "b is an instance of Program, which cannot be called without arguments: missing a required argument: 'scenario'"
            "; valid: a class or function without arguments; results of programs are compared by `compare_results`",
        ),
        ((OdometryOnly, OdometryOnly, OPEN_FLAT), "scenarios is an instance of Scenario; valid: several values"),
        ((OdometryOnly, OdometryOnly, [OPEN_FLAT] * 2), "the scenario with seed .* is given twice; valid: different"),
        ((OdometryOnly, lambda: None, [OPEN_FLAT]), "SLAM under test: NoneType has no method start"),
        ((OdometryOnly, OdometryOnly, [3]), r"scenarios\[0\] is an instance of int; valid: an instance of Scenario"),
        ((OdometryOnly, OdometryOnly, [], "rooms.pq >= 0.5"), r"claims is the text .*such as \['rooms.pq >= 0.5'\]"),
        ((OdometryOnly, OdometryOnly, [], (), ["rooms.pq"]), "figures is .*; valid: a mapping, such as {'rooms.pq': Rule"),
        ((OdometryOnly, OdometryOnly, [], (), {"rooms.pq": 1}), "figures is .*; valid: a mapping"),
        ((OdometryOnly, OdometryOnly, [], (), {}, "0.95"), "confidence is '0.95'; valid: a number above 0.5 and below 1"),
        ((OdometryOnly, OdometryOnly, [], [0.5]), r"claims\[0\] is an instance of float; valid: a claim"),
    ],
)
def test_arguments_of_the_wrong_kind_are_named(arguments, message):
    with pytest.raises(SimError, match=f"^(compare: )?{message}"):
        untyped(compare)(*arguments)


@pytest.mark.parametrize("claims", [[], [f"rooms.pq >= 0.{k}" for k in range(1, 9)]])
def test_too_few_houses_for_any_difference_are_told_with_the_number_that_suffices(claims):
    _, second, *_ = str(compare_results(results([0.9] * 4), results([0.1] * 4), claims)).splitlines()
    fewest = int(re.fullmatch(r"with 4 houses no difference can be shown; at least (\d+) are needed", second)[1])

    def lost(houses):
        """Every figure and every claim is lost in all houses."""
        changes = tuple(ClaimChange(each.name, houses, 0, 0, (1.0, 0.0)) for each in compared.claims)
        figures = tuple(replace(each, a=np.ones(houses), b=np.full(houses, np.nan)) for each in compared.figures)
        return replace(compared, houses=houses, figures=figures, claims=changes)

    compared = compare_results(results([0.9] * 4), results([0.1] * 4), claims)
    assert lost(fewest).worse and not lost(fewest - 1).worse
    assert "no difference can be shown" not in str(lost(fewest))
    assert "no difference can be shown" not in str(compare_results(*(results([0.9] * fewest),) * 2, claims))


def test_the_columns_of_the_table_are_aligned():
    names = "place_recognition.1.precision", "labels.accuracy >= 0.7 * labels.accuracy_baseline"
    a = [replace(each, place_recognition={"1": MatchFigures(1, 2, 3, 0.5)}) for each in results([0.9] * 3)]
    _, _, _, head, *rows = str(compare_results(a, a, names[1:])).splitlines()
    assert {row.rindex("  not shown to differ") for row in rows} == {head.rindex("  verdict")}
    assert {names[0], names[1]} <= {row.partition("  ")[0] for row in rows}


def test_two_slams_run_on_the_same_scenarios():
    scenarios = [replace(OPEN_FLAT, seed=seed) for seed in (1, 2)]
    compared = compare(OdometryOnly, OdometryOnly, scenarios)
    assert compared.scenarios == 2
    assert compared.worse == ()
    assert "trajectory.ate_m" in str(compared)
