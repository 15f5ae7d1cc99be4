"""`items` and `independent_results`: the values in an argument that holds several of one kind, such as results of runs."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

from sim.errors import SimError
from sim.harness.results import RunResult
from sim.wording import class_of

T = TypeVar("T")


def items(place: str, kind: type[T], given: object) -> Iterator[T]:
    """Yield the values in an argument, one by one, so that a generator runs no further than it is read.

    `place` names the argument in messages. Raises `SimError` if the argument is a single value, and when a value is of
    another kind.
    """
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise SimError(f"{place} is {class_of(given)}; valid: several values of the class {kind.__name__}, such as a list")
    for i, value in enumerate(given):
        if not isinstance(value, kind):
            raise SimError(f"{place}[{i}] is {class_of(value)}; valid: an instance of {kind.__name__}")
        yield value


def independent_results(place: str, given: object) -> Iterator[RunResult]:
    """Yield the results in an argument as `items` does. Raises `SimError` for a second result of one scenario."""
    indices: dict[str, int] = {}
    for i, result in enumerate(items(place, RunResult, given)):
        if (first := indices.setdefault(result.scenario, i)) != i:
            raise SimError(
                f"{place}[{i}] is a run in the scenario of results[{first}]; valid: a scenario of its own for each"
            )
        yield result
