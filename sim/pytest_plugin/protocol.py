"""Decides how pytest runs and reports tests.

A decorated test runs in its own house, and then in further houses within the time budget. If the test fails, it runs
again in smaller houses.
"""

import time
from collections.abc import Generator
from itertools import count

import pytest

from sim.harness.world_tests import FreshWorld, WorldFamily
from sim.pytest_plugin.collection import SHARE_S, family_of, is_without_worlds, world_of
from sim.pytest_plugin.execution import EXECUTION, Execution, execute, reason_of
from sim.pytest_plugin.explanation import add_text
from sim.pytest_plugin.options import SEED, wants_to_shrink
from sim.pytest_plugin.shrinking import reference_of, shrunk


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run a decorated test, and report one outcome for all its executions."""
    family = family_of(item)
    if family is None or is_without_worlds(item):
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    reports, execution = _within_budget(item, nextitem, family)
    original, failed = execution.scenario, next((report for report in reports if report.failed), None)
    if execution.failure is not None and original is not None and failed is not None:  # None: only subtests have failed
        search, problem = None, None
        further = execution.world.name if execution.world not in (None, world_of(item)) else ""
        try:
            if wants_to_shrink(item.config) and not execution.failure.lacks_figure:
                execution, search = shrunk(item, nextitem, execution, original)
            if execution.reference is None:
                execution.reference = reference_of(item, nextitem, original)
        except Exception as error:  # whatever it is, the failure of the test must not be lost
            problem = error
        add_text(item, execution, failed, search, problem, further)
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def _within_budget(
    item: pytest.Item, nextitem: pytest.Item | None, family: WorldFamily
) -> tuple[list[pytest.TestReport], Execution]:
    """Execute a decorated test in its house, and then in further houses while it passes and its time budget lasts.

    Returns the reports and the record of the first execution that failed or, if none did, those of the first execution.
    """
    config = item.config
    ends_s = time.monotonic() + config.stash.get(SHARE_S, 0.0)
    first = world_of(item)
    reports, execution = execute(item, nextitem, first)
    if not isinstance(first, FreshWorld):
        return reports, execution
    for further in count(1):
        if not all(report.passed for report in reports) or time.monotonic() >= ends_s:
            break
        world = family.draw(config.stash[SEED], first.index + further * family.n)
        tried = execute(item, nextitem, world)
        if any(report.failed for report in tried[0]):
            return tried
    return reports, execution


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Record why a test failed, unless one of its fixtures failed.

    For a test that is not decorated, the explanation is added to the report at once.
    """
    report = yield
    execution = item.stash.get(EXECUTION, None)
    if execution is not None and call.when == "teardown" and execution.world is None:
        del item.stash[EXECUTION]  # a run takes much memory
    elif execution is not None and call.when == "call" and report.failed and call.excinfo is not None:
        if execution.world is None and execution.tested is None:  # a test that runs no SLAM
            return report
        execution.failure = reason_of(item, call.excinfo, execution.last.slam)
        if execution.world is None:
            add_text(item, execution, report)
    return report
