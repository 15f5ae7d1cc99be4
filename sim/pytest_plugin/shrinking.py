"""Shrinking: a failing test is executed in smaller and smaller scenarios, as long as it fails in the same way.

If the user has a fixture `reference_slam`, the test also has to pass with this SLAM in each of these scenarios.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pytest

from sim.errors import SimError
from sim.pytest_plugin.collection import REFERENCE, has_own_fixture
from sim.pytest_plugin.execution import Execution, execute

if TYPE_CHECKING:
    from sim.harness.failures.search import Reference, Search
    from sim.harness.finished_run import Run
    from sim.harness.results import RunResult
    from sim.harness.scenario import Scenario
    from sim.harness.shrinking.failure_signature import Signature


@dataclass(frozen=True)
class _Chosen:
    """A `World` that returns an existing scenario."""

    chosen: "Scenario"
    name: str = "chosen"

    def scenario(self) -> "Scenario":
        """Return the existing scenario."""
        return self.chosen


class ReferenceSlam:
    """The SLAM of the fixture `reference_slam`: a smaller scenario counts only if the test passes with it."""

    def __init__(self, item: pytest.Item, nextitem: pytest.Item | None) -> None:
        """Leave the reference out if the user has none."""
        self._item, self._nextitem = item, nextitem
        self._is_used, self._is_first = has_own_fixture(item, REFERENCE), True
        self._left_out = ""
        self._run: Run | None = None

    def outcome(self) -> "Reference":
        """Return the last run with which the test passed, or why the reference is left out."""
        from sim.harness.failures.search import Reference

        return Reference(self._run, self._left_out)

    def passes(self, scenario: "Scenario") -> bool:
        """Return whether the test passes with the reference in a scenario; True without a reference.

        The first call is for the original scenario. If the test fails there, the reference is left out from then on.
        """
        if not self._is_used:
            return True
        reports, tried = execute(self._item, self._nextitem, _Chosen(scenario), by_reference=True)
        passed = all(report.passed for report in reports)
        if passed:
            self._run = tried.run
        elif self._is_first:
            self._is_used, self._left_out = False, self._why_left_out(tried)
        self._is_first = False
        return passed or not self._is_used

    def _why_left_out(self, tried: Execution) -> str:
        if "run" not in self._item.fixturenames:  # type: ignore[attr-defined]
            return f"{REFERENCE} is not used, because the test does not take run."
        how = "" if tried.failure is None else f": {tried.failure.message.splitlines()[0]}"
        return f"{REFERENCE} is not used, because the test fails with it, too{how}."


def reference_of(item: pytest.Item, nextitem: pytest.Item | None, scenario: "Scenario") -> "Reference":
    """Execute a failing test with the reference in its scenario, if the user has one; see `ReferenceSlam`."""
    slam = ReferenceSlam(item, nextitem)
    slam.passes(scenario)
    return slam.outcome()


class _Failure:
    """The failure of a test: says for any scenario whether the test fails there in the same way.

    It is a function for `reduce` and `blame`, and keeps the last execution of the test that showed the failure.
    """

    def __init__(self, item: pytest.Item, nextitem: pytest.Item | None, found: Execution) -> None:
        """Remember how the test failed in the execution `found`."""
        from sim.harness.shrinking.original_failure import OriginalFailure

        self._item, self._nextitem = item, nextitem
        self._signature = _signature(found)
        self.figure = found.failure.figure if found.failure else None
        self.original, self.reference = OriginalFailure(), ReferenceSlam(item, nextitem)
        self.last = found

    def __call__(self, scenario: "Scenario") -> "Signature | None":
        """Execute the test in a scenario; return the signature of its failure, or None if it passes.

        Raises `SimError` if the test cannot run there, or is skipped.
        """
        reports, tried = execute(self._item, self._nextitem, _Chosen(scenario))
        signature = _signature(tried)
        if signature is not None and signature == self._signature:
            return self._compared(scenario, tried, signature)
        if tried.failure is not None and isinstance(tried.failure.error, SimError):
            raise tried.failure.error
        if any(report.skipped for report in reports):
            raise SimError("the test is skipped in this scenario; valid: a scenario in which it runs")
        if signature is None and any(report.failed for report in reports):
            raise SimError("the test cannot be set up in this scenario; valid: a scenario that can run")
        return signature

    def _compared(self, scenario: "Scenario", tried: Execution, signature: "Signature") -> "Signature":
        """Return the signature of a failure after a comparison with the original failure and the reference."""

        def passes(result: "RunResult") -> bool:
            return all(report.passed for report in execute(self._item, self._nextitem, _Chosen(scenario), result)[0])

        if tried.run is not None and self.original.is_unavoidable(tried.run, tried.last.trials, passes):
            return signature.unavoidable
        if tried.run is not None and not self.original.is_like(tried.run, self.figure):
            return signature.with_other_errors
        if not self.reference.passes(scenario):
            return signature.of_reference
        tried.reference, self.last = self.reference.outcome(), tried
        return signature


def shrunk(
    item: pytest.Item, nextitem: pytest.Item | None, found: Execution, scenario: "Scenario"
) -> "tuple[Execution, Search | None]":
    """Search for the smallest scenario in which the test fails in the same way.

    Returns the execution of the test in this scenario, and the search. If the failure does not recur, `found` and None are
    returned. After Ctrl-C, the smallest failure so far is returned, and pytest is told to stop after this test.
    """
    from sim.harness.adapters.lexis import Lexis
    from sim.harness.failures.blame_table import blame
    from sim.harness.failures.search import Search
    from sim.harness.shrinking.reducer import reduce
    from worlds.errors import WorldsError

    failure = _Failure(item, nextitem, found)
    try:
        reduction = reduce(scenario, failure)
    except (SimError, WorldsError):  # the failure does not recur, or the house cannot be built
        return found, None
    except KeyboardInterrupt:  # before the reducer has anything to keep
        _stop(item)
        return found, None
    if failure.last.scenario != reduction.scenario and failure(reduction.scenario) != _signature(found):
        return found, None
    smallest = failure.last  # kept, because `blame` executes the test again
    blamed = blame(reduction, failure, smallest.run is not None and isinstance(smallest.run.slam, Lexis))
    if blamed.interrupted:
        _stop(item)
    said = found.failure.text if found.failure else ""
    kinds = "" if smallest.run is None else failure.original.compared(smallest.run, failure.figure)
    return smallest, Search(scenario, said, _place(found), kinds, reduction, blamed)


def _place(found: Execution) -> str:
    """Return where the original run first went wrong, as text; "" if it is not known."""
    try:
        return found.first_wrong
    except Exception:  # whatever it is, the failure of the test must not be lost
        return ""


def _stop(item: pytest.Item) -> None:
    item.session.shouldstop = "interrupted while a failing scenario was made smaller"


def _signature(execution: Execution) -> "Signature | None":
    """Return the signature of a failure: the type of the exception and the line that raised it; None without a failure."""
    from sim.harness.shrinking.failure_signature import Signature

    failure = execution.failure
    return None if failure is None else Signature(f"raises {failure.kind} at {failure.where}")
