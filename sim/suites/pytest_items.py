"""`slam_checks`: a test for pytest that checks a SLAM by a suite, one item for each claim and each law.

from sim import slam_checks
from my_slam import MySlam

test_my_slam = slam_checks(MySlam, suite="pr", expected_failures={"homes: a pause": "the clock is not yet handled"})
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from sim.errors import SimError
from sim.harness.last_run import LastRun, watched
from sim.harness.slam_under_test import check_slam_factory
from sim.harness.wording import kind_of
from sim.suites.catalogue import suite_named
from sim.suites.checks import NewSlam
from sim.suites.examination import COMPLETES
from sim.suites.report import SEED, CheckVerdict, SuiteReport, check_slam, runnable
from sim.suites.suite import Suite, SuitePart
from worlds.valid_names import did_you_mean

if TYPE_CHECKING:
    import pytest

_NONE_EXPECTED: Mapping[str, str] = MappingProxyType({})


class Item(NamedTuple):
    """One check of one part, which becomes one item of pytest."""

    part: SuitePart
    check: str

    @property
    def name(self) -> str:
        """Part and check, as `expected_failures` names them."""
        return f"{self.part.name}: {self.check}"


def slam_checks(
    new_slam: NewSlam,
    suite: Suite | str = "pr",
    expected_failures: Mapping[str, str] = _NONE_EXPECTED,
    seed: int = SEED,
) -> Callable[..., None]:
    """Make a test that checks a SLAM by a suite; assign it to a name that begins with `test`.

    An item fails if its check fails with the confidence of a suite (`sim.suites.report.CONFIDENCE`), and is skipped if the
    SLAM does not make the claims that the check is about. The first item of a part runs all scenarios of the part. The
    verdicts about several parts together, which are means and laws that parts share, have no items: see `check_slam`.

    Args:
        new_slam: makes a SLAM that has not run yet, such as a class that takes no arguments.
        suite: a suite, or the name of one.
        expected_failures: the reason for each check that is known to fail, by "part: check", or by a pattern such as
            "revisits: trajectory.*". These items are strict: they fail if their check does not fail.
        seed: seed of all scenarios.

    Raises:
        SimError: the suite or the name of a check is unknown, or an argument is of another kind.
    """
    import pytest

    check_slam_factory("slam_checks: new_slam", new_slam)
    if not isinstance(expected_failures, Mapping):
        raise SimError(
            f"slam_checks: expected_failures is {kind_of(expected_failures)}; valid: a mapping of 'part: check' to a reason"
        )
    chosen = runnable(suite_named(suite), new_slam)
    items = [Item(part, check) for part in chosen.parts for check in (COMPLETES, *(each.name for each in part.checks))]
    _check_names(expected_failures, items)
    parameters = [pytest.param(item, id=item.name, marks=_marks(item, expected_failures)) for item in items]

    reports = _Reports(new_slam, chosen, seed)

    @pytest.mark.parametrize("item", parameters)
    def test(item: Item) -> None:
        __tracebackhide__ = True
        verdict = reports.verdict(item)
        if verdict.outcome in ("not claimed", "not examined"):
            pytest.skip(str(verdict))
        assert verdict.outcome != "fails", str(verdict)

    return test


class _Reports:
    """The reports of the parts of a suite. When the first item of a part runs, all checks of the part are made."""

    def __init__(self, new_slam: NewSlam, suite: Suite, seed: int) -> None:
        self._new_slam, self._suite, self._seed = new_slam, suite, seed
        self._of_part: dict[str, SuiteReport] = {}

    def verdict(self, item: Item) -> CheckVerdict:
        """Return the verdict about one check."""
        name = item.part.name
        if name not in self._of_part:
            with watched(LastRun()):  # otherwise the plugin reports the last of the many runs
                self._of_part[name] = check_slam(self._new_slam, replace(self._suite, parts=(item.part,)), self._seed)
        return next(each for each in self._of_part[name].verdicts if each.check == item.check)


def _marks(item: Item, expected: Mapping[str, str]) -> "tuple[pytest.MarkDecorator, ...]":
    import pytest

    tier = pytest.mark.render if item.part.on_images else pytest.mark.features
    reason = next((reason for pattern, reason in expected.items() if fnmatchcase(item.name, pattern)), None)
    if reason is None:
        return (tier,)
    return (tier, pytest.mark.xfail(strict=True, reason=reason, raises=AssertionError))


def _check_names(expected: Mapping[str, str], items: list[Item]) -> None:
    names = [item.name for item in items]
    for pattern in expected:
        if not any(fnmatchcase(name, pattern) for name in names):
            guess = did_you_mean(pattern, names)
            raise SimError(f"slam_checks: no check {pattern!r:.80}{guess}; valid: {'; '.join(names)}")
