"""`slam_checks`: a test for pytest that checks a SLAM by a suite, one item for each claim and each law.

from sim import slam_checks
from my_slam import MySlam

test_my_slam = slam_checks(MySlam, suite="pr", expected_failures={"homes: a pause": "the clock is not yet handled"})
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from inspect import signature
from types import TracebackType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sim.errors import SimError
from sim.harness.crash import COMPLETES
from sim.harness.slam_under_test import check_slam_factory
from sim.programs.program import Program
from sim.suites.catalogue import suite_named
from sim.suites.checks import Check, CheckFinding, NewSlam
from sim.suites.examination import replayed_finding
from sim.suites.expected_failures import NONE_EXPECTED, ExpectedFailure, expected_failures_of
from sim.suites.failed_items import about_failure, replayed_scenario
from sim.suites.report import SEED, CheckVerdict, SuiteReport, check_slam, runnable
from sim.suites.suite import Suite, SuitePart
from worlds.errors import WorldsError

if TYPE_CHECKING:
    import pytest


class Item(NamedTuple):
    """One check of one part, which becomes one item of pytest."""

    part: SuitePart
    check: str

    @property
    def name(self) -> str:
        """Part and check, as `expected_failures` names them."""
        return f"{self.part.name}: {self.check}"

    @property
    def checked(self) -> Check | None:
        """The check itself; None for the check that the run completes."""
        return self.part.check_named(self.check)


def slam_checks(
    new_slam: NewSlam,
    suite: Suite | str = "pr",
    expected_failures: Mapping[str, str] = NONE_EXPECTED,
    seed: int = SEED,
) -> Callable[..., None]:
    """Make a test that checks a SLAM by a suite; assign it to a name that begins with `test`.

    An item fails if its check fails with the confidence of a suite (`sim.suites.report.CONFIDENCE`). Its text names a folder
    with the first scenario in which the check fails, and the command that replays it (`--lexis-replay`); a replay checks
    this scenario alone. An item is skipped, and says why, if the check could not be decided in any scenario, for example
    because the SLAM does not estimate what the check is about. The first item of a part runs all scenarios of the
    part; with pytest-xdist and `--dist loadgroup`, all items of a part run in one process. The verdicts about several parts
    together, which are means and laws that parts share, have no items: see `check_slam`.

    Args:
        new_slam: makes a SLAM that has not run yet, such as a class that takes no arguments.
        suite: a suite, or the name of one.
        expected_failures: the reason for each check that is known to fail, by "part: check", or by a pattern such as
            "revisits: trajectory.*". These items are strict: they fail whenever their check does not fail, and say why.
        seed: seed of all scenarios.

    Raises:
        SimError: the suite or the name of a check is unknown, or an argument is of another kind.
    """
    import pytest

    if not isinstance(new_slam, Program):
        check_slam_factory("slam_checks: new_slam", new_slam)
    chosen = runnable(suite_named(suite), new_slam)
    items = [Item(part, check) for part in chosen.parts for check in (COMPLETES, *(each.name for each in part.checks))]
    expected = expected_failures_of(expected_failures, [item.name for item in items])
    marks = {part.name: (_tier(part), pytest.mark.xdist_group(part.name)) for part in chosen.parts}
    parameters = [pytest.param(item, id=item.name, marks=marks[item.part.name]) for item in items]

    reports = _Reports(new_slam, chosen, seed)

    @pytest.mark.parametrize("item", parameters)
    def test(item: object, request: "pytest.FixtureRequest | None" = None) -> None:
        if not isinstance(item, Item):
            raise SimError("slam_checks returns a test and is no decorator; valid: test_slam = slam_checks(MySlam, ...)")
        scenario = None if request is None else replayed_scenario(request.node)
        if scenario is not None:
            _report_replay(item, replayed_finding(item.checked, scenario, new_slam))
            return
        verdict, entry = reports.verdict(item), next((entry for entry in expected if item.name in entry.checks), None)
        _report(verdict, entry, lambda: "" if request is None else about_failure(request.node, verdict, new_slam))

    test.__signature__ = signature(lambda item, request: None)  # type: ignore[attr-defined]  # pytest skips defaults
    return test


class _Reports:
    """The reports of the parts of a suite. When the first item of a part runs, all checks of the part are made."""

    def __init__(self, new_slam: NewSlam, suite: Suite, seed: int) -> None:
        self._new_slam, self._suite, self._seed = new_slam, suite, seed
        self._of_part: dict[str, SuiteReport] = {}
        self._errors: dict[str, tuple[Exception, TracebackType | None]] = {}

    def verdict(self, item: Item) -> CheckVerdict:
        """Return the verdict about one check. For all items of a part, raises the exception that ended its scenarios."""
        name = item.part.name
        if name not in self._of_part and name not in self._errors:
            self._examine(item.part)
        if name in self._errors:
            error, origin = self._errors[name]
            raise error.with_traceback(origin)  # otherwise the traceback would grow from item to item
        return next(each for each in self._of_part[name].verdicts if each.check == item.check)

    def _examine(self, part: SuitePart) -> None:
        try:
            report = check_slam(self._new_slam, replace(self._suite, parts=(part,)), self._seed)
        except Exception as error:
            self._errors[part.name] = error, error.__traceback__
            return
        if report.interrupted:
            raise KeyboardInterrupt
        if report.error is not None:
            self._errors[part.name] = report.error, report.error.__traceback__
            return
        self._of_part[part.name] = report


def _tier(part: SuitePart) -> "pytest.MarkDecorator":
    """Return the mark for the fidelity of a part. One scenario shows it, because the scenarios of a part are of one kind."""
    import pytest

    try:
        is_rendered = part.on_images or part.draw(np.random.default_rng(0), 0).fidelity == "render"
    except (SimError, WorldsError):  # an unlucky draw
        is_rendered = False
    return pytest.mark.render if is_rendered else pytest.mark.features


def _report_replay(item: Item, found: CheckFinding) -> None:
    """Let an item of pytest pass, fail or be skipped by what its check found in a single scenario."""
    import pytest

    if found.holds is None:
        pytest.skip(f"{item.name}: {found.measured}")
    if not found.holds:
        pytest.fail(f"{item.name}: {found.measured}", pytrace=False)


def _report(verdict: CheckVerdict, expected: ExpectedFailure | None, about_failure: Callable[[], str]) -> None:
    """Let an item of pytest pass, fail, fail as expected, or be skipped.

    `expected` is the entry that names the item. `about_failure` returns further lines of text about a failure that is not
    expected.
    """
    import pytest

    if verdict.outcome == "fails":
        if expected is not None:
            pytest.xfail(expected.reason)  # with pytest --runxfail, this does nothing
        pytest.fail(f"{verdict}{about_failure()}", pytrace=False)
    if expected is not None:
        pytest.fail(f"{expected.instead(verdict.outcome)}\n{verdict}", pytrace=False)
    if verdict.outcome in ("not applicable", "not examined"):
        pytest.skip(str(verdict))
