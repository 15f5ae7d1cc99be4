"""Words for messages: lists in sentences (`joined`), counts (`counted`), shares (`percent`), seeds, errors and names."""

from collections.abc import Sequence


def joined(parts: Sequence[str], word: str) -> str:
    """Join parts by commas and, before the last one, a word: "drift, fault or clutter"; "" without parts."""
    return f" {word} ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def counted(n: int, noun: str) -> str:
    """Return a number with a noun that has a regular plural: "1 house", "2 houses"."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def percent(share: float) -> str:
    """Return a share in per cent with all its digits: "95%", but "99.5%", which is not 100%."""
    return f"{100 * share:g}%"


def seeds_text(seeds: Sequence[int]) -> str:
    """Return consecutive seeds as text: "seed 500", or "seeds 500 to 504"."""
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"


def qualified_name(value: object) -> str:
    """Return module and class of an object, or of a class itself, as options name them: "my_slam:MySlam"."""
    kind = value if isinstance(value, type) else type(value)
    return f"{kind.__module__}:{kind.__qualname__}"


def error_text(error: BaseException) -> str:
    """Return the class and the text of an exception, "RuntimeError: lost", even if the exception fails to make its text."""
    try:
        return f"{type(error).__name__}: {error}"
    except Exception as problem:  # whatever a user's class raises
        return f"{type(error).__name__}, whose text cannot be made: {type(problem).__name__}"


def class_of(value: object) -> str:
    """Say what a value is, for messages about a wrong argument: "an instance of list", or "the class GridSlam"."""
    return f"the class {value.__name__}" if isinstance(value, type) else f"an instance of {type(value).__name__}"
