"""`joined`: lists in sentences."""

from collections.abc import Sequence


def joined(parts: Sequence[str], word: str) -> str:
    """Join parts by commas and, before the last one, a word: "drift, fault or clutter"; "" without parts."""
    return f" {word} ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))
