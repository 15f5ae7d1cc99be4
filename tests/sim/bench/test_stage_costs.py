"""What stages cost: differences are paired by house, and the truth in place of a stage leaves nothing to lose."""

from dataclasses import replace

import numpy as np
import pytest

from sim.bench.stage_costs import UNCHANGED, StageRow, gains, measure_house


def row(seed, replaced, labels, preset="home"):
    return StageRow(preset, seed, replaced, labels, rooms=labels / 2, ate_m=1 - labels, plans=1.0)


def test_differences_are_paired_by_house():
    rows = [row(1, UNCHANGED, 0.5), row(2, UNCHANGED, 0.9), row(1, UNCHANGED, 0.7, "ori")]
    rows += [row(1, "truth", 0.6, "ori"), row(2, "truth", 1.0), row(1, "no clutter", 0.5)]
    found = gains(rows)
    assert found["truth"].mean.labels == pytest.approx(0.0) and found["truth"].houses == 2
    assert found["truth"].error.labels == pytest.approx(0.1) and found["truth"].mean.ate_m == pytest.approx(0.0)
    assert found["no clutter"].mean.labels == 0.0 and np.isnan(found["no clutter"].error.labels)
    assert found[UNCHANGED].mean.labels == pytest.approx(0.7) and found[UNCHANGED].houses == 3


def test_a_house_without_plans_does_not_count_in_their_error():
    rows = [replace(row(seed, UNCHANGED, 0.5), plans=plans) for seed, plans in enumerate((0.4, 0.6, np.nan, np.nan))]
    found = gains(rows)[UNCHANGED]
    assert found.error.plans == pytest.approx(0.1) == gains(rows[:2])[UNCHANGED].error.plans
    assert np.isnan(gains(rows[1:])[UNCHANGED].error.plans) and found.error.labels == 0.0


@pytest.mark.filterwarnings("error")
def test_a_figure_that_no_house_has_is_nan_without_a_warning():
    found = gains([replace(row(seed, UNCHANGED, 0.5), plans=np.nan) for seed in range(2)])[UNCHANGED]
    assert np.isnan([found.mean.plans, found.error.plans]).all() and found.mean.labels == 0.5


def test_the_order_of_houses_does_not_matter():
    rows = [row(seed, name, labels) for seed in range(4) for name, labels in ((UNCHANGED, 0.1 * seed), ("truth", 0.3))]
    forward, backward = (gains(order)["truth"] for order in (rows, rows[::-1]))
    np.testing.assert_allclose(forward.mean.labels, backward.mean.labels)
    np.testing.assert_allclose(forward.error.rooms, backward.error.rooms)


@pytest.fixture(scope="module")
def house():
    return {each.replaced: each for each in measure_house("home", 100)}


def test_the_truth_loses_nothing(house):
    assert house["true labels"].labels == 1.0 and house["perfect odometry"].ate_m < 0.01
    assert "no faults" not in house  # there are none, so the substitution would change nothing


def test_a_stage_that_labels_do_not_depend_on_changes_none(house):
    assert house["true labels"].ate_m == house[UNCHANGED].ate_m < house["loops off"].ate_m
