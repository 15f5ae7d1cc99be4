"""Valid names in error messages: the one that was probably meant, and lists that stay on one line."""

import difflib
from collections.abc import Iterable, Sequence


def did_you_mean(word: str, valid: Iterable[str], likeness: float = 0.6) -> str:
    """A guess such as " (did you mean 'kitchen'?)" at the valid name that was meant; "" where none is like the word.

    `likeness` is the smallest similarity of the two names in [0, 1]; 1 accepts equal names only.
    """
    guess = difflib.get_close_matches(word, list(valid), n=1, cutoff=likeness)
    return f" (did you mean {guess[0]!r}?)" if guess else ""


def listed(names: Sequence[str], most: int = 30) -> str:
    """The names with commas between them, the first `most` of them and the number of the others."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
