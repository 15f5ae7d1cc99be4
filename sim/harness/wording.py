"""Words for messages: `joined` writes lists in sentences, and `kind_of` says what a value is."""

from collections.abc import Sequence


def joined(parts: Sequence[str], word: str) -> str:
    """Join parts by commas and, before the last one, a word: "drift, fault or clutter"; "" without parts."""
    return f" {word} ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def kind_of(value: object) -> str:
    """Say what a value is, for messages about a wrong argument: "an instance of list", or "the class GridSlam"."""
    return f"the class {value.__name__}" if isinstance(value, type) else f"an instance of {type(value).__name__}"
