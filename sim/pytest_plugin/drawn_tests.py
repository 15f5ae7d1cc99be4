"""Replays of tests whose arguments Hypothesis draws: the test runs once, in the house of the stored scenario."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from sim.harness.scenario import Scenario


@contextmanager
def replay_of_draws(item: pytest.Item, scenario: "Scenario | None") -> Iterator[None]:
    """While the block runs, let a test with `@given` run once, on the stored scenario and its house instead of drawn ones.

    Hypothesis still draws the other arguments. An exception of the test is raised at the end of the block only: if
    Hypothesis saw the exception, it would draw further examples. Tests without `@given` run as usual, and so do all tests if
    `scenario` is None.
    """
    handle = getattr(getattr(item, "obj", None), "hypothesis", None)
    if scenario is None or handle is None:
        yield
        return
    inner, outcomes = handle.inner_test, list[BaseException | None]()
    handle.inner_test = _once(inner, scenario, outcomes)
    try:
        yield
    finally:
        handle.inner_test = inner
    for error in outcomes:
        if error is not None:
            raise error


def _once(test: Callable[..., Any], scenario: "Scenario", outcomes: list[BaseException | None]) -> Callable[..., None]:
    """Wrap a test that Hypothesis calls: the first call runs the test, and later calls do nothing.

    The first call appends the exception of the test, or None, to `outcomes`.
    """

    @wraps(test)
    def once(*args: Any, **kwargs: Any) -> None:
        from hypothesis.errors import HypothesisException

        if outcomes:
            return
        try:
            test(*(_stored(value, scenario) for value in args), **{k: _stored(v, scenario) for k, v in kwargs.items()})
            outcomes.append(None)
        except HypothesisException:  # such as that of `assume`: Hypothesis draws again
            raise
        except (Exception, pytest.fail.Exception) as error:
            outcomes.append(error)

    return once


def _stored(value: object, scenario: "Scenario") -> object:
    """Return the stored scenario or house in place of a scenario or house; return any other value unchanged."""
    from sim.harness.scenario import Scenario
    from worlds.spec import HouseSpec

    if isinstance(value, Scenario):
        return scenario
    return scenario.house if isinstance(value, HouseSpec) and scenario.house is not None else value
