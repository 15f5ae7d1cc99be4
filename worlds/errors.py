"""The exceptions of the package `worlds`, of which `WorldsError` is the base class, and checks of arguments."""

from numbers import Integral, Real


class WorldsError(ValueError):
    """A house, spec or argument cannot be used. The message names the place of the mistake and the valid values."""


class SpecError(WorldsError):
    """A house spec (or the JSON it came from) is malformed."""


class HouseError(WorldsError):
    """A well-formed spec describes an impossible house: it cannot be built, or its rooms cannot all be reached on foot."""


def reworded(error: WorldsError, message: str) -> WorldsError:
    """Return a new error with the class and the notes of `error`, but with another message."""
    other = type(error)(message)
    for note in getattr(error, "__notes__", ()):
        other.add_note(note)
    return other


def check_number(name: str, value: object, low: float, high: float, meaning: str) -> None:
    """Raise `WorldsError`, which names the argument, unless it is a number from `low` to `high`.

    `meaning` explains the scale in the message.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not low <= float(value) <= high:
        raise WorldsError(f"{name} is {value!r}; valid: {low:g} to {high:g} ({meaning})")


def check_whole(**numbers: object) -> None:
    """Raise `WorldsError`, which names the argument, for a number that is given (not None) and not whole."""
    for name, value in numbers.items():
        if value is not None and (isinstance(value, bool) or not isinstance(value, Integral)):
            raise WorldsError(f"{name} is {value!r}; valid: a whole number")
