"""Words for messages: `joined` writes lists in sentences, `counted` counts, and `kind_of` says what a value is."""

from collections.abc import Sequence


def joined(parts: Sequence[str], word: str) -> str:
    """Join parts by commas and, before the last one, a word: "drift, fault or clutter"; "" without parts."""
    return f" {word} ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def counted(n: int, noun: str) -> str:
    """Return a number with a noun that has a regular plural: "1 house", "2 houses"."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def kind_of(value: object) -> str:
    """Say what a value is, for messages about a wrong argument: "an instance of list", or "the class GridSlam"."""
    return f"the class {value.__name__}" if isinstance(value, type) else f"an instance of {type(value).__name__}"
