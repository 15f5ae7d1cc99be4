"""`unused`: the name of an image's file, which is its stamp."""

from collections.abc import Container
from itertools import count


def unused(stamp: str, suffix: str, taken: Container[str]) -> str:
    """Return the name for an image of a stamp, with a number if a name in `taken` has this stamp, as after a stamp jump."""
    return next(name for k in count() if (name := f"{stamp}{f'-{k}' if k else ''}{suffix}") not in taken)
