"""Checks of numbers that a user gives: `is_finite`, `check_count` for whole numbers, `check_between` for an interval."""

import math
from numbers import Real

from sim.errors import SimError


def is_finite(value: object) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, Real) and math.isfinite(value)


def check_count(place: str, value: object, least: int, most: int | None = None) -> None:
    """Raise `SimError` unless `value` is a whole number from `least` to `most`; None stands for no upper limit.

    `place` names the argument in the message, as in "suite: seed".
    """
    if not isinstance(value, bool) and isinstance(value, int) and least <= value and (most is None or value <= most):
        return
    raise SimError(f"{place} is {value!r:.60}; valid: a whole number from {least}" + ("" if most is None else f" to {most}"))


def check_between(place: str, value: object, low: float, high: float, example: float) -> None:
    """Raise `SimError` unless `value` is a number above `low` and below `high`; the message gives an example."""
    if not isinstance(value, int | float) or not low < value < high:
        raise SimError(f"{place} is {value!r:.60}; valid: a number above {low:g} and below {high:g}, such as {example:g}")
