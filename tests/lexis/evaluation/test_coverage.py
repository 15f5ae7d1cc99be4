"""Coverage: a run that saw almost nothing reports this in `coverage` of result.json instead of perfect figures."""

from dataclasses import replace

import pytest

from sim.faults.delivery import Dropped
from sim.faults.poses import Kidnap, OdometryFreeze
from sim.harness import Scenario, evaluate, run
from worlds.presets import sample_from_rooms

CONFIG = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom", "bathroom"), seed=21), seed=5, fidelity="features", length_m=36.0,
    frame_rate_hz=4.0,
)  # fmt: skip
FOREVER_S = 1e6


@pytest.fixture(scope="module")
def whole():
    return evaluate(run(CONFIG)).data()


def test_a_run_without_faults_covers_its_walk(whole):
    coverage = whole["coverage"]
    assert coverage["rooms_visited"] == coverage["rooms"] == whole["house"]["rooms"]
    assert 0.97 < coverage["path_covered"] <= 1.0


@pytest.mark.parametrize(
    "fault",
    [Dropped(1.0), Kidnap(at_s=0.1, skip_s=FOREVER_S), OdometryFreeze(at_s=0.1, for_s=FOREVER_S)],
    ids=lambda fault: fault.name,
)
def test_a_run_of_one_keyframe_has_no_perfect_figures_of_nothing(fault, whole):
    result = evaluate(run(replace(CONFIG, faults=(fault,)))).data()
    assert result["run"]["keyframes"] == 1
    assert result["coverage"] == {
        "rooms_visited": 1,
        "rooms": whole["coverage"]["rooms"],
        "path_covered": 0.0,
    }
    for section in ("rooms", "trajectory"):
        assert set(result[section].values()) == {None}, section
    assert result["loops"]["precision"] is None and result["loops"]["recall"] is None
    assert result["planning"] == {"queries": 0, "success": None, "spl": None, "collisions": None}
    assert result["place_recognition"]["1"] == {"tp": 0, "fp": 0, "possible": 0, "precision": None}


def test_half_a_walk_is_covered_by_half():
    half_s = evaluate(run(CONFIG)).data()["run"]["duration_s"] / 2
    coverage = evaluate(run(replace(CONFIG, faults=(Kidnap(at_s=half_s, skip_s=FOREVER_S),)))).data()["coverage"]
    assert 0.35 < coverage["path_covered"] < 0.65


def test_a_stretch_that_was_never_seen_is_not_covered(whole):
    coverage = evaluate(run(replace(CONFIG, faults=(Kidnap(at_s=10.0, skip_s=20.0),)))).data()["coverage"]
    assert coverage["path_covered"] < whole["coverage"]["path_covered"] - 0.1


def test_queries_that_could_succeed_are_told_beside_those_that_did(whole):
    for counts in whole["place_recognition"].values():
        assert 0 <= counts["tp"] <= counts["possible"] < whole["run"]["keyframes"]
    assert whole["place_recognition"]["1"]["possible"] > 0
