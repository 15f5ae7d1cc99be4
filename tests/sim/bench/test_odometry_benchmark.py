"""The benchmark of odometry: walks of one house that differ in the odometry alone."""

from dataclasses import replace

import pytest

from sim.bench.odometry import CASES, USUAL, OdometryRow, measure_odometry, summary
from sim.faults.poses import OdometryJump

ROW = OdometryRow(USUAL, 1, 0.4, 0.1, 0.9, 0.8, 3, 1, False)


@pytest.fixture(scope="module")
def laps():
    """Walks of three laps in one home, by case."""
    return {row.case: row for row in measure_odometry(list(CASES), "home", [300], "features", "loop")}


def test_every_case_has_its_own_odometry(laps):
    assert list(laps) == list(CASES)
    assert laps["mono"].odometry_m < laps["degraded"].odometry_m
    assert laps["odometry-freeze"].odometry_m > laps[USUAL].odometry_m < laps["kidnap"].odometry_m


def test_lexis_refuses_what_does_not_fit_and_corrects_the_map_of_a_robot_that_was_carried(laps):
    corrected = {case for case, row in laps.items() if row.is_corrected}
    assert corrected == {"odometry-freeze", "kidnap"}
    for row in laps.values():
        assert row.false == 0 and row.ate_m < 0.35 * row.odometry_m
        assert row.labels > laps[USUAL].labels - 0.05
    assert laps["kidnap"].refused > 3 * laps[USUAL].refused


def test_a_walk_that_ends_before_its_fault_begins_is_left_out(monkeypatch):
    late = {"late": {"faults": (OdometryJump(at_s=1e4),)}, "mono": CASES["mono"]}
    monkeypatch.setattr("sim.bench.odometry.CASES", late)
    assert [row.case for row in measure_odometry(["late", "mono"], "random", [1], "features", "rooms")] == ["mono"]


def test_the_summary_compares_every_case_with_the_usual_one_in_the_same_house():
    rows = [ROW, replace(ROW, seed=2, ate_m=0.5, labels=0.7)]
    worse = [replace(row, case="kidnap", labels=row.labels - 0.02, is_corrected=True) for row in rows]
    found = summary([*rows, *worse])
    assert found[USUAL].share_of_odometry == pytest.approx((0.1 / 0.4 + 0.5 / 0.4) / 2)
    assert found[USUAL].largest_excess_m == pytest.approx(0.1)
    assert found[USUAL].labels_gained == 0.0 and found["kidnap"].labels_gained == pytest.approx(-0.02)
    assert (found[USUAL].corrected, found["kidnap"].corrected, found["kidnap"].false) == (0, 2, 2)


def test_a_figure_that_a_walk_cannot_have_is_left_out():
    bare = replace(ROW, seed=2, odometry_m=None, ate_m=None, labels=None, rooms=None)
    both, alone = summary([ROW, bare])[USUAL], summary([bare])[USUAL]
    assert (both.houses, both.ate_m, both.labels, both.rooms) == (2, 0.1, 0.9, 0.8)
    assert alone.share_of_odometry is alone.largest_excess_m is alone.labels_gained is alone.rooms is None
    assert summary([replace(ROW, odometry_m=0.0)])[USUAL].share_of_odometry is None
    assert summary([replace(ROW, case="kidnap")])["kidnap"].labels_gained is None
