"""Names in messages: a guess at the valid name that was meant, and lists that are short enough to read."""

import difflib
from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

_Thing = TypeVar("_Thing")


def did_you_mean(word: str, valid: Iterable[str], likeness: float = 0.6) -> str:
    """Return a guess at the valid name that was meant, such as " (did you mean 'kitchen'?)".

    The result is "" if no valid name is similar enough. `likeness` is the least similarity to `word` that the guess must
    have, in [0, 1]; 1 accepts equal names only.
    """
    guess = difflib.get_close_matches(word, list(valid), n=1, cutoff=likeness)
    return f" (did you mean {guess[0]!r}?)" if guess else ""


def listed(things: Sequence[_Thing], most: int = 30, *, shown: Callable[[_Thing], str] = str, separator: str = ", ") -> str:
    """Return the first `most` things, as text by `shown`, and how many things are left out: "kitchen, bath and 3 more".

    With the separator "; ", for texts that contain commas themselves: "a, b; c, d; and 3 more".
    """
    last = " " if separator == ", " else separator
    left_out = f"{last}and {len(things) - most} more" if len(things) > most else ""
    return separator.join(map(shown, things[:most])) + left_out
