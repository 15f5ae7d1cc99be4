"""Suites and their parts: which scenarios and checks they have, and which of them are refused."""

import pickle
from dataclasses import dataclass, replace

import numpy as np
import pytest
from helpers.flat_suite import FLAT, ORIGIN, PART, FloorsByHeight, Oracle, outcomes
from helpers.unchecked import unchecked, untyped

from sim.errors import SimError
from sim.harness import Scenario
from sim.harness.claims import Claim
from sim.harness.crash import COMPLETES
from sim.suites.catalogue import OPENNESS, SUITES, suite_named
from sim.suites.checks import ClaimCheck
from sim.suites.examination import drawn_scenario, jobs_of
from sim.suites.report import check_slam
from sim.suites.suite import Suite, SuitePart, claims


def test_loose_limits_are_looser_than_tight_ones():
    for part in SUITES["pr"].parts:
        limits = {}
        for check in part.checks:
            if isinstance(check, ClaimCheck) and check.claim.quantity in limits:
                loose, tight = limits[check.claim.quantity], check.claim
                assert (tight.limit - loose.limit) * (1 if ">" in tight.comparison else -1) > 0, f"{part.name}: {tight}"
            elif isinstance(check, ClaimCheck):
                limits[check.claim.quantity] = check.claim


@pytest.mark.parametrize(("share", "n"), [(0.01, 5), (0.5, 30), (0.1, 5), (2.0, 120)])
def test_a_suite_of_another_size_has_whole_groups(share, n):
    assert SUITES["open-plan"].with_size(share).parts[0].n == n


@pytest.mark.parametrize("share", [0.0, -1.0, np.inf, np.nan])
def test_a_share_that_is_no_size_is_refused(share):
    with pytest.raises(SimError, match=r"suite open-plan: the share is .*valid: a positive number"):
        SUITES["open-plan"].with_size(share)


@dataclass
class Changeable:
    """A check that can change, and therefore has no hash."""

    name: str = "mine"
    says: str = ""
    rate: float | None = None

    def examine(self, base, new_slam):
        raise NotImplementedError


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"checks": [Changeable()]},
            "part flat: check 'mine' cannot be hashed: .*; valid: a check such as a frozen dataclass",
        ),
        ({"n": 0}, "part flat: n is 0; valid: a whole number from 1"),
        ({"group": 0}, "part flat: group is 0; valid: a whole number from 1"),
    ],
)
def test_a_part_that_cannot_be_examined_is_refused(change, message):
    with pytest.raises(SimError, match=message):
        unchecked(SuitePart, **vars(PART) | change)


def test_a_list_of_checks_is_as_good_as_a_tuple():
    assert unchecked(SuitePart, **vars(PART) | {"checks": list(PART.checks)}) == PART


def test_a_claim_that_has_to_hold_in_all_scenarios_is_refused_before_any_run():
    with pytest.raises(SimError, match=r"rate is 1\.0; valid: a number above 0 and below 1, such as 0\.99"):
        claims(1.0, "rooms.pq >= 0.5")


def test_parts_take_turns_and_draws_do_not_depend_on_other_parts():
    other = replace(PART, name="other", n=2)
    jobs = jobs_of(Suite("two", "", (PART, other)), seed=3)
    assert [(job.part.name, job.number) for job in jobs[:4]] == [("flat", 0), ("other", 0), ("flat", 1), ("other", 1)]
    alone = jobs_of(FLAT, seed=3)
    assert [drawn_scenario(job) for job in jobs if job.part is PART] == [drawn_scenario(job) for job in alone]


def test_limits_can_be_set_by_figure():
    strict = FLAT.with_limits({"labels.accuracy": 1.1})
    assert outcomes(check_slam(Oracle, strict, stop_at_failure=True))["labels.accuracy >= 1.1"] == "fails"
    with pytest.raises(SimError, match=r"suite flat: has no claim about 'labels.acuracy' \(did you mean .*valid: floors"):
        FLAT.with_limits({"labels.acuracy": 0.5})


def test_one_limit_for_a_claim_from_below_and_one_from_above_is_refused():
    both = ClaimCheck(Claim.parse("labels.accuracy >= 0.2"), 0.9), ClaimCheck(Claim.parse("labels.accuracy <= 0.99"), 0.9)
    suite = Suite("both", "Both sides.", (replace(PART, checks=both),))
    with pytest.raises(SimError, match=r"suite both: 'labels.accuracy' is limited from below and from above by one part"):
        suite.with_limits({"labels.accuracy": 0.5})


MEAN = Claim.parse("labels.accuracy >= 0.9")

UNEVEN = Suite("uneven", "Two parts.", (replace(PART, n=4), replace(PART, name="laws", checks=(ORIGIN,), n=6)), (MEAN,))


@pytest.mark.parametrize(("share", "sizes", "means"), [
    (0.5, (2, 3), (MEAN,)), (5.0, (20, 30), (MEAN,)), (0.3, (1, 2), ()), (0.01, (1, 1), ()),
])  # fmt: skip
def test_a_suite_of_another_size_claims_means_if_its_parts_keep_their_proportions(share, sizes, means):
    resized = UNEVEN.with_size(share)
    assert tuple(part.n for part in resized.parts) == sizes and resized.means == means


def test_without_laws_the_means_are_still_over_the_scenarios_of_all_parts():
    without = UNEVEN.without_laws()
    assert [(part.name, len(part.checks), part.n) for part in without.parts] == [("flat", 2, 4), ("laws", 0, 6)]
    assert without.means == (MEAN,)
    assert [part.name for part in replace(UNEVEN, means=()).without_laws().parts] == ["flat"]


def test_without_laws_a_suite_makes_its_claims_only():
    assert outcomes(check_slam(FloorsByHeight, FLAT.without_laws())).keys() == {
        COMPLETES, "labels.accuracy >= 0.8", "floors.accuracy >= 0.9",
    }  # fmt: skip
    with pytest.raises(SimError, match="suite language: has laws only; valid: with laws"):
        SUITES["language"].without_laws()


def test_a_limit_of_something_that_is_no_figure_is_refused():
    with pytest.raises(SimError, match="has no claim about 1; valid: "):
        untyped(Suite.with_limits)(suite_named("pr"), {1: 2.0})


def test_an_unknown_suite_is_refused():
    with pytest.raises(SimError, match=r"unknown suite 'open-plane' \(did you mean 'open-plan'\?\)"):
        suite_named("open-plane")


@pytest.mark.parametrize("name", [name for name in SUITES if name != "pr"])
def test_every_suite_can_draw_its_first_scenarios(name):
    for part in SUITES[name].parts:
        first = jobs_of(Suite(name, "", (part,)), seed=0)[:1]
        assert all(isinstance(drawn_scenario(job), Scenario) for job in first)


def test_the_open_plan_suite_opens_the_same_house_step_by_step():
    jobs = jobs_of(SUITES["open-plan"], seed=0)[: len(OPENNESS)]
    specs = [drawn_scenario(job).house for job in jobs]
    assert len({tuple(room.id for room in spec.storeys[0].rooms) for spec in specs}) == 1
    assert len({spec.to_json() for spec in specs}) == len(OPENNESS)


def test_all_checks_of_a_suite_have_different_names():
    for suite in SUITES.values():
        for part in suite.parts:
            names = [check.name for check in part.checks]
            assert len(names) == len(set(names)), part.name


@pytest.mark.parametrize("name", SUITES)
def test_every_scenario_of_a_suite_can_be_sent_to_another_process(name):
    for job in jobs_of(SUITES[name].with_size(0.01), seed=0):
        assert pickle.loads(pickle.dumps(job)) == job


def test_a_suite_can_be_rendered_for_a_slam_that_needs_images():
    scenario = drawn_scenario(jobs_of(SUITES["homes"].with_images(), seed=0)[0])
    assert (scenario.fidelity, scenario.frame_rate_hz) == ("render", 10.0)


def test_checks_of_equal_names_and_parts_of_equal_names_are_refused():
    with pytest.raises(SimError, match="part flat: the check 'origin' occurs twice"):
        replace(PART, checks=(ORIGIN, ORIGIN))
    with pytest.raises(SimError, match="suite twice: the part 'flat' occurs twice"):
        Suite("twice", "", (PART, PART))
    assert [c.name for c in SUITES["homes"].with_limits({"rooms.pq": 0.5}).parts[0].checks if "pq" in c.name] == [
        "rooms.pq >= 0.5"
    ]
