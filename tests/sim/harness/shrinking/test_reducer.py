"""The reducer: planted bugs are shrunk and blamed; deadline, interruption, memory and signatures are kept."""

from dataclasses import replace
from functools import cache

import pytest

from sim.bench.planted_bugs import drift, floors, no_bug, open_plan, planted
from sim.errors import SimError
from sim.harness import Claim, FailureTest, Lexis, Scenario, Signature, blame, evaluate, reduce, run
from sim.harness.adapters import OdometryOnly
from sim.harness.run_settings import with_listed_house
from sim.harness.shrinking.reducer import is_valid
from sim.harness.shrinking.reductions import STEPS
from sim.harness.shrinking.scenario_size import size
from worlds.presets import sample_from_rooms

LABELS = ("kitchen", "living room", "bedroom", "dining room")
FLAT = Scenario(
    house=sample_from_rooms(LABELS, seed=4, openness=0.6), seed=5, frame_rate_hz=2.0, fidelity="features", encoder="oracle"
)
TALL = replace(FLAT, house=sample_from_rooms(LABELS, seed=4, storeys=2), odometry="degraded")
BUGS = {
    "open plan": (FLAT, "labels.accuracy < 0.9", open_plan, {"openness 0"}),
    "floors": (TALL, "floors.accuracy < 0.9", floors, set()),
    "drift": (TALL, "trajectory.ate_m > 0.02", drift, {"perfect odometry"}),
}


@cache
def shrunk(name):
    scenario, claim, kind, _ = BUGS[name]
    test = FailureTest(Claim.parse(claim), planted(kind))
    return reduce(scenario, test, deadline_s=1e9), test


@pytest.mark.parametrize("name", ["open plan", "drift", pytest.param("floors", marks=pytest.mark.slow)])
def test_a_planted_bug_is_shrunk_and_blamed(name):
    reduction, test = shrunk(name)
    after = size(reduction.scenario)
    stairs = 2 if name == "floors" else 0
    assert after.rooms <= 3 + stairs and after.length_m <= 20.0 and after.furniture == 0
    assert after.storeys == (2 if name == "floors" else 1)
    assert after.drift == (name == "drift")
    assert reduction.ended == "smallest" and test(reduction.scenario) == reduction.signature == Signature(
        str(test.condition)
    )
    assert set(blame(reduction, test).named("mends")) == BUGS[name][3]


def odometry_alone(scenario, progress):
    return run(scenario, OdometryOnly())


@pytest.mark.parametrize("factor", ["", "0.66 * "])
def test_a_failure_to_be_better_than_the_odometry_is_shrunk_to_a_scenario_where_loop_closures_mend_it(factor):
    test = FailureTest(Claim.parse(f"trajectory.ate_m >= {factor}trajectory.ate_odometry_m"), odometry_alone)
    reduction = reduce(FLAT, test, deadline_s=1e9)
    after = size(reduction.scenario)
    assert after.rooms == 1 and after.drift == 1 and after.length_m < size(reduction.original).length_m
    assert test.condition.outcome(evaluate(run(reduction.scenario, Lexis("oracle")))) == "fails"
    assert "perfect odometry" in blame(reduction, test).named("cannot be told")


def test_accepted_scenarios_shrink_all_the_way_and_are_valid():
    reduction, _ = shrunk("open plan")
    sizes = [size(reduction.original), *(size(change.scenario) for change in reduction.accepted)]
    assert sizes == sorted(sizes, reverse=True) and len(set(sizes)) == len(sizes)
    assert is_valid(reduction.scenario) and reduction.accepted[-1].scenario == reduction.scenario
    assert any(change.step == "simpler openings" for change in reduction.passing)


class Counted:
    """Fails where the scenario has a kitchen and another room; counts the runs, and moves a clock by a second for each."""

    def __init__(self, stop_at=None):
        self.hashes, self.stop_at = [], stop_at

    def __call__(self, scenario):
        self.hashes.append(scenario.content_hash)
        if len(self.hashes) == self.stop_at:
            raise KeyboardInterrupt
        kitchen = "kitchen" in scenario.house.room_labels and len(scenario.house.storeys[0].rooms) > 1
        return Signature("a kitchen") if kitchen else None

    def clock(self):
        return float(len(self.hashes))


def test_the_order_is_the_same_each_time():
    first, second = Counted(), Counted()
    a, b = reduce(FLAT, first), reduce(FLAT, second)
    assert first.hashes == second.hashes and a.scenario == b.scenario and size(a.scenario).rooms == 2


def test_nothing_is_run_twice():
    seen = []

    def fails(scenario):
        seen.append(scenario.content_hash)
        return Signature("all rooms") if size(scenario).rooms == len(FLAT.house.storeys[0].rooms) else None

    # In the second round, the rooms are dropped from the same scenario as in the first.
    reduction = reduce(FLAT, fails, steps={name: STEPS[name] for name in ("drop drift", "drop rooms")})
    assert reduction.scenario.odometry == "perfect" and len(set(seen)) == len(seen) > 3


@pytest.mark.parametrize(("deadline_s", "runs"), [(1.0, 1), (4.0, 4), (8.0, 8)])
def test_the_best_so_far_is_kept_when_time_is_up(deadline_s, runs):
    fails = Counted()
    reduction = reduce(FLAT, fails, deadline_s, clock=fails.clock)
    assert reduction.ended == "deadline" and len(fails.hashes) == runs
    assert fails(reduction.scenario) is not None and size(reduction.scenario) <= size(reduction.original)
    assert (size(reduction.scenario) < size(reduction.original)) == bool(reduction.accepted) >= (runs == 8)


def test_the_best_so_far_is_kept_on_interruption():
    fails = Counted(stop_at=6)
    reduction = reduce(FLAT, fails)
    assert reduction.ended == "interrupted" and len(reduction.accepted) >= 1
    assert size(reduction.scenario) < size(reduction.original) and "interrupted" in reduction.note


def test_no_candidate_is_listed_after_the_time_is_up(monkeypatch):
    asked = []
    hashes = Scenario.content_hash.fget
    monkeypatch.setattr(Scenario, "content_hash", property(lambda scenario: asked.append(scenario) or hashes(scenario)))
    reduction = reduce(FLAT, lambda scenario: Signature("always"), deadline_s=0.0, clock=lambda: 0.0)
    assert reduction.ended == "deadline" and reduction.passing == () and len(asked) == 1


def test_the_passing_neighbours_are_those_of_the_smallest_scenario():
    fails = Counted()
    reduction = reduce(FLAT, fails)
    tried = {change.scenario.content_hash: change.step for change in reduction.passing}
    near = {c.content_hash: name for name, step in STEPS.items() for c in step(reduction.scenario)}
    assert tried and tried.items() <= near.items()
    assert [*tried.values()] == sorted(tried.values(), key=list(STEPS).index)


def test_a_failure_with_another_signature_and_an_exception_do_not_count():
    def fails(scenario):
        if len(scenario.house.storeys[0].rooms) < 4:
            raise ZeroDivisionError
        return Signature("one" if scenario.odometry != "perfect" else "another")

    reduction = reduce(FLAT, fails)
    assert size(reduction.scenario).rooms == 4 and reduction.scenario.odometry == FLAT.odometry


def _unreachable(spec):
    return spec.model_copy(update={"storeys": tuple(s.model_copy(update={"openings": ()}) for s in spec.storeys)})


def test_invalid_houses_are_never_run():
    seen = []

    def fails(scenario):
        seen.append(scenario)
        return Signature("always")

    steps = {"broken": lambda scenario: iter([replace(scenario, house=_unreachable(scenario.house), odometry="perfect")])}
    reduction = reduce(FLAT, fails, steps=steps)
    assert len(seen) == 1 and reduction.tried == 1


def test_a_scenario_that_does_not_fail_is_refused():
    with pytest.raises(SimError, match="does not fail; valid: a scenario of which the failure is true"):
        reduce(FLAT, lambda scenario: None)


def test_steps_can_be_left_out():
    steps = {name: step for name, step in STEPS.items() if name != "drop drift"}
    kept = reduce(FLAT, lambda scenario: Signature("always"), steps=steps)
    assert kept.scenario.odometry == FLAT.odometry and size(kept.scenario).rooms == 1


def on(fidelities, needs=lambda scenario: True):
    """Fails on these fidelities, if `needs` is true of scenarios with images."""

    def fails(scenario):
        wrong = scenario.fidelity in fidelities and (scenario.fidelity == "features" or needs(scenario))
        return Signature("always") if wrong else None

    return fails


RENDERED = replace(FLAT, fidelity="render", encoder="mini")


def test_a_failure_with_images_is_searched_on_features_and_confirmed():
    reduction = reduce(RENDERED, on({"features", "render"}))
    assert reduction.searched_on == "features" and reduction.confirmed and reduction.scenario.fidelity == "render"
    assert size(reduction.scenario).rooms == 1 and reduction.ended_on == "features"
    assert "The search ran on feature fidelity, and the result was confirmed on rendered images." in reduction.note


def test_where_images_need_more_the_search_walks_back_up():
    reduction = reduce(RENDERED, on({"features", "render"}, lambda s: len(s.house.storeys[0].rooms) >= 3))
    assert reduction.confirmed and reduction.scenario.fidelity == "render" and size(reduction.scenario).rooms == 3


def test_a_search_that_goes_on_with_images_is_said_to_do_so():
    wide_or_long = lambda s: len(s.house.storeys[0].rooms) >= 3 or s.length_m is None or s.length_m > 60.0  # noqa: E731
    reduction = reduce(RENDERED, on({"features", "render"}, wide_or_long))
    assert (reduction.searched_on, reduction.ended_on) == ("features", "render")
    assert "The search began on feature fidelity, and went on with rendered images." in reduction.note


def test_what_passed_on_features_is_next_to_the_result_on_images():
    needs = lambda scenario: len(scenario.house.storeys[0].rooms) >= 3  # noqa: E731
    fails = lambda scenario: Signature("3 rooms") if needs(scenario) else None  # noqa: E731
    reduction = reduce(RENDERED, fails)
    assert reduction.confirmed and reduction.searched_on == "features"
    assert {change.step for change in reduction.passing} == {"drop rooms"}
    larger, change = reduction.last_passing
    assert needs(larger) and not needs(change.scenario) and change.step == "drop rooms"


def test_a_failure_of_images_alone_is_searched_on_images():
    reduction = reduce(RENDERED, on({"render"}))
    assert reduction.searched_on == "render" and size(reduction.scenario).rooms == 1
    assert "because the failure does not exist on feature fidelity" in reduction.note


def test_a_failure_on_features_that_gets_smaller_on_images_alone_is_said_to_do_so():
    rooms = lambda scenario: len(scenario.house.storeys[0].rooms)  # noqa: E731
    wrong = lambda scenario: scenario.fidelity == "render" or rooms(scenario) == rooms(with_listed_house(RENDERED))  # noqa: E731
    fails = lambda scenario: Signature("always") if wrong(scenario) else None  # noqa: E731
    reduction = reduce(RENDERED, fails, steps={"drop rooms": STEPS["drop rooms"]})
    assert (reduction.searched_on, reduction.on_features) == ("render", "fails")
    assert "because no smaller scenario was found that fails on feature fidelity and on images" in reduction.note


def test_what_could_not_be_confirmed_in_time_is_said():
    fails = Counted()
    reduction = reduce(RENDERED, fails, 6.0, clock=fails.clock)
    assert reduction.ended == "deadline" and size(reduction.scenario) < size(reduction.original)
    assert reduction.confirmed == (reduction.scenario.fidelity == "render")


def test_an_exception_of_the_slam_is_a_failure_too():
    def crashes(run):
        raise ZeroDivisionError

    test = FailureTest.parse("crash", planted(crashes))
    scenario = with_listed_house(FLAT)
    assert test(scenario) == Signature("raises ZeroDivisionError")
    assert FailureTest.parse("crash", planted(no_bug))(scenario) is None
