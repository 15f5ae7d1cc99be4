"""The law about plans sees steps through walls and wrong ends, in plans that nobody drives."""

import re
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from lexis.errors import PlanError
from sim.errors import EstimateError
from sim.harness import Lexis, Scenario, run
from sim.harness.adapters import GeometricRooms
from sim.harness.crash import attempt_plans
from sim.suites.checks import evaluated_run
from sim.suites.plans import _spread, plans_can_be_walked
from worlds.presets import sample_house

HOME = Scenario(
    house=sample_house("home", 12, rooms=4, storeys=1, openness=0.0), seed=3, length_m=60.0, frame_rate_hz=2.0,
    fidelity="features", encoder="oracle",
)  # fmt: skip


@pytest.fixture(scope="module")
def finished():
    return run(HOME, Lexis("oracle"))


class Planner:
    """Plans as LEXIS does, and changes the plan."""

    def __init__(self, lexis, change):
        self._lexis, self._change = lexis, change

    def plan(self, start, goal):
        return self._change(list(self._lexis.plan(start, goal)))


def fail(error):
    def change(plan):
        raise error

    return change


def test_plans_of_lexis_can_be_walked(finished):
    assert plans_can_be_walked(finished).holds


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda plan: [plan[0], plan[-1]], r"; [1-9]\d* steps are blocked"),
        (lambda plan: plan[::-1], " 0% begin and 0% end in a room of the wanted label; 0 steps"),
        (lambda plan: plan[:1], " 100% begin and 0% end in a room of the wanted label; 0 steps"),
        (fail(PlanError("no way")), "there is no plan from"),
        (fail(ZeroDivisionError("oh")), "raises ZeroDivisionError: oh"),
        (fail(SystemExit(0)), "raises SystemExit: 0"),
        (lambda plan: [], r"is \[\]; valid: one or more rows of the estimate, 0 to \d+; without a plan, raise PlanError"),
        (lambda plan: [0, 99999], r"is \[0, 99999\]; valid: one or more rows"),
        (lambda plan: [0, [1, 2]], r"is \[0, \[1, 2\]\]; valid: one or more rows"),
    ],
    ids=["straight ahead", "backwards", "stays", "none", "crash", "exit", "empty", "beyond", "ragged"],
)
def test_plans_through_walls_to_other_rooms_or_none_at_all_are_found(finished, change, said):
    found = plans_can_be_walked(replace(finished, slam=Planner(finished.slam, change)))
    assert found.holds is False and re.search(said, found.measured)
    assert found.is_crash == ("raises" in said)


def test_a_plan_that_is_no_list_of_rows_fails_the_run_and_not_the_suite(finished, monkeypatch):
    broken = replace(finished, slam=Planner(finished.slam, lambda plan: [0.5]))
    with pytest.raises(EstimateError, match=r"is \[0.5\]; valid: one or more rows of the estimate"):
        attempt_plans(broken)
    monkeypatch.setattr("sim.suites.checks.attempted", lambda *_: broken)
    found = evaluated_run(replace(HOME, fidelity="render", encoder="mini"), Lexis)
    assert found.holds is False and found.measured.startswith("the plan from ")


def test_the_plans_that_are_asked_for_begin_and_end_in_all_labels():
    pairs = list(permutations("abcde", 2))
    starts, goals = map(set, zip(*_spread(pairs), strict=True))
    assert starts == goals == set("abcde")
    assert _spread(pairs[:5]) == pairs[:5] and _spread([]) == []


def test_a_slam_without_plans_or_with_one_label_is_not_judged(finished):
    assert plans_can_be_walked(run(HOME, GeometricRooms())).holds is None
    one = replace(finished.estimate, labels=np.zeros_like(finished.estimate.labels))
    assert plans_can_be_walked(replace(finished, estimate=one)).holds is None
