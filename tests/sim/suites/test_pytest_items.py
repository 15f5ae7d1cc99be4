"""`slam_checks` makes a test of each check, with expected failures."""

import re
from dataclasses import replace

import pytest
from helpers.flat_suite import FLAT, PART, Broken, FloorsByHeight, Oracle, WrongLabels, flat
from helpers.unchecked import untyped

from sim.errors import SimError
from sim.harness.adapters import OdometryOnly
from sim.harness.crash import COMPLETES
from sim.suites.laws import LAWS
from sim.suites.pytest_items import Item, slam_checks
from sim.suites.suite import claims


def test_slam_checks_makes_an_item_for_every_check():
    test = slam_checks(OdometryOnly, suite=FLAT, expected_failures={"flat: origin": "for the test"})
    (mark,) = test.pytestmark
    names = [parameter.id for parameter in mark.args[1]]
    assert names == [
        "flat: the run completes",
        "flat: labels.accuracy >= 0.8",
        "flat: floors.accuracy >= 0.9",
        "flat: origin",
    ]
    with pytest.raises(SimError, match=r"no check 'flat: orign' \(did you mean 'flat: origin'\?\)"):
        slam_checks(OdometryOnly, suite=FLAT, expected_failures={"flat: orign": "a typing error"})


def test_slam_checks_is_no_decorator():
    with pytest.raises(SimError, match=r"is no decorator; valid: test_slam = slam_checks\(MySlam"):

        @slam_checks(OdometryOnly, suite=FLAT)
        def test_slam():
            """Never called."""


def outcome_of(test, name):
    """What pytest reports for one item of `slam_checks`, with its text."""
    item = next(parameter.values[0] for parameter in test.pytestmark[0].args[1] if parameter.id == name)
    try:
        test(item)
    except (pytest.fail.Exception, pytest.skip.Exception, pytest.xfail.Exception) as raised:
        return type(raised).__name__, str(raised)
    return "Passed", ""


@pytest.mark.parametrize(
    ("slam", "check", "reported", "text"),
    [
        (FloorsByHeight, "origin", "XFailed", "^a reason$"),
        (Oracle, "origin", "Failed", r"^expected to fail \(a reason\), but it holds now: remove .*\nflat: origin: holds"),
        (
            WrongLabels,
            "labels.accuracy >= 0.8",
            "Failed",
            r"but it is undecided: more scenarios .*\n.*holds in 0 of 1 house",
        ),
        (
            OdometryOnly,
            "labels.accuracy >= 0.8",
            "Failed",
            r"but it could not be decided in any scenario: remove .*\n.*: not applicable \(labels\.accuracy is null\)$",
        ),
        (Broken, "origin", "Failed", "but no scenario reaches it"),
    ],
)
def test_an_expected_failure_that_does_not_fail_says_why(slam, check, reported, text):
    suite = replace(FLAT, parts=(replace(PART, n=1),))
    test = slam_checks(slam, suite, expected_failures={f"flat: {check}": "a reason"})
    outcome, said = outcome_of(test, f"flat: {check}")
    assert outcome == reported and re.search(text, said)


def test_a_pattern_that_also_names_a_check_that_does_not_fail_is_to_be_narrowed():
    suite = replace(FLAT, parts=(replace(PART, n=1),))
    _, said = outcome_of(slam_checks(FloorsByHeight, suite, {"flat: o*": "a reason"}), "flat: origin")
    assert said == "a reason"
    _, said = outcome_of(slam_checks(Oracle, suite, {"flat: *": "a reason"}), "flat: origin")
    assert "but it holds now: let 'flat: *' in the expected failures name fewer checks, or remove it\n" in said
    _, said = outcome_of(slam_checks(Oracle, suite, {"flat: or*": "a reason"}), "flat: origin")
    assert "but it holds now: remove 'flat: or*' from the expected failures\n" in said


@pytest.mark.parametrize(
    ("expected", "message"),
    [
        ({3: "a reason"}, "expected_failures has the key 3; valid: text"),
        ({"flat: origin": None}, "the reason of 'flat: origin' is None; valid: text"),
        ({"flat: origin": " "}, "the reason of 'flat: origin' is ' '; valid: text"),
    ],
)
def test_an_expected_failure_needs_a_name_and_a_reason(expected, message):
    with pytest.raises(SimError, match=message):
        untyped(slam_checks)(OdometryOnly, FLAT, expected)


def test_an_item_that_is_skipped_says_why():
    law = replace(FLAT, parts=(replace(PART, checks=(LAWS["false loop closures"],), n=1),))
    skipped = outcome_of(slam_checks(OdometryOnly, law), "flat: false loop closures")
    assert skipped == ("Skipped", "flat: false loop closures: not applicable (the change does not reach this SLAM)")


def test_a_part_that_cannot_be_drawn_is_tried_once_and_fails_every_item():
    drawn = []

    def impossible(rng, number):
        drawn.append(number)
        raise SimError("there is no house")

    test = slam_checks(OdometryOnly, replace(FLAT, parts=(replace(PART, draw=impossible),)))
    drawn.clear()  # the marks of the items need a scenario, too
    items = [parameter.values[0] for parameter in test.pytestmark[0].args[1]]
    depths = []
    for item in items:
        with pytest.raises(SimError, match="part flat has no possible scenarios from number 0: there is no house") as raised:
            test(item)
        depths.append(len(raised.traceback))
    assert len(drawn) == 20  # the draws for one scenario
    assert len(depths) == 4 and len(set(depths)) == 1


def _rendered(rng, number):
    return replace(flat(rng, number), encoder="mini", fidelity="render")


def test_items_are_marked_by_the_fidelity_of_the_scenarios():
    parts = PART, replace(PART, name="drawn", draw=_rendered), replace(PART, name="images", on_images=True)
    test = slam_checks(OdometryOnly, replace(FLAT, parts=parts))
    marks = {parameter.values[0].part.name: parameter.marks[0].name for parameter in test.pytestmark[0].args[1]}
    assert marks == {"flat": "features", "drawn": "render", "images": "render"}


def test_an_item_that_fails_shows_the_verdict_and_nothing_else():
    with pytest.raises(pytest.fail.Exception) as raised:
        slam_checks(FloorsByHeight, suite=FLAT)(Item(PART, "origin"))
    assert not raised.value.pytrace and str(raised.value).startswith(
        "flat: origin: holds in 0 of 2 scenarios (wanted: in all)"
    )


def test_an_expected_failure_without_its_part_is_refused_with_the_name_that_was_meant():
    many = replace(FLAT, parts=(replace(PART, checks=claims(0.9, *(f"rooms.pq >= {k}" for k in range(99)))),))
    with pytest.raises(
        SimError, match=r"no check 'rooms\.\*' \(did you mean 'flat: rooms\.\*'\?\); valid: flat: .* and 90 more"
    ):
        slam_checks(OdometryOnly, suite=many, expected_failures={"rooms.*": "no rooms"})


test_a_crash = slam_checks(Broken, suite=FLAT, expected_failures={f"flat: {COMPLETES}": "it crashes"})

test_oracle = slam_checks(Oracle, suite=replace(FLAT, parts=(replace(PART, n=1),)))
"""The ready test, used as a user would."""

test_floors_by_height = slam_checks(
    FloorsByHeight, suite=replace(FLAT, parts=(replace(PART, n=1),)), expected_failures={"flat: orig*": "absolute heights"}
)
