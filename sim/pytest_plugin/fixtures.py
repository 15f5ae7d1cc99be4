"""The fixtures of decorated tests: the scenario, its house, the SLAM under test, and the evaluated run."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

from sim.errors import USER_ERRORS, SimError
from sim.pytest_plugin.collection import REFERENCE, family_of
from sim.pytest_plugin.execution import EXECUTION, Execution, Raised

if TYPE_CHECKING:
    from sim.harness.results import RunResult
    from sim.harness.scenario import Scenario
    from sim.harness.slam_under_test import SlamUnderTest
    from worlds.house import House


@pytest.fixture
def scenario(request: pytest.FixtureRequest) -> "Scenario":
    """The scenario of a test that is decorated with `worlds`."""
    execution: Execution = request.node.stash[EXECUTION]
    if execution.world is None:
        problem = f"{request.node.nodeid}: the test has no houses; valid: a test that is decorated with @worlds(...)"
        pytest.fail(problem, pytrace=False)
    with _mistakes_without_traceback():
        scenario = execution.scenario = execution.world.scenario()
    return scenario


@pytest.fixture
def house(scenario: "Scenario") -> "House":
    """The house of the scenario, built and checked."""
    from sim.harness.run_settings import house_spec
    from worlds.validation import built_and_checked

    with _mistakes_without_traceback():
        return built_and_checked(house_spec(scenario))


@pytest.fixture
def slam(scenario: "Scenario") -> "SlamUnderTest":
    """The SLAM under test: LEXIS, unless you override this fixture to test your own."""
    from sim.harness.adapters.lexis import Lexis

    return Lexis(scenario.encoder)


@pytest.fixture
def run(request: pytest.FixtureRequest, scenario: "Scenario", slam: "SlamUnderTest") -> "RunResult":
    """The result of the SLAM on the scenario. If the SLAM raises an exception, the test fails with this exception."""
    from sim.harness.figures import evaluate
    from sim.harness.planning import try_plans
    from sim.harness.runner import run as run_scenario
    from sim.report.findings import idle_faults

    execution: Execution = request.node.stash[EXECUTION]
    if execution.given is not None:
        return execution.given
    family, name = family_of(request.node), "slam"
    if execution.by_reference:
        name, slam = REFERENCE, request.getfixturevalue(REFERENCE)
    if slam is None:
        pytest.fail(f"the fixture {name} returned None; valid: a SLAM under test (is `return` missing?)", pytrace=False)
    try:
        finished = run_scenario(scenario, slam)
        result = evaluate(finished, try_plans(finished) if family is not None and family.plans else [])
    except USER_ERRORS as error:
        if execution.last.done is None:  # no SLAM, or a scenario that cannot be run
            with _mistakes_without_traceback():
                raise
        execution.raised = Raised(error, error.__traceback__)
        raise
    if text := idle_faults(result.data()):
        warnings.warn(text, pytest.PytestWarning, stacklevel=1)
    return result


@contextmanager
def _mistakes_without_traceback() -> Iterator[None]:
    """Let errors of the harness fail the test with their message alone, because their messages say all.

    Exceptions of other types are raised unchanged.
    """
    from worlds.errors import WorldsError

    try:
        yield
    except (SimError, WorldsError) as error:
        raise pytest.fail.Exception(str(error), pytrace=False) from None
