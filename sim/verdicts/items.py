"""`items`: the values in an argument that has to hold several values of one kind, such as the results of many runs."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

from sim.errors import SimError
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
