"""Valid names in error messages: a guess at the name that was meant, and lists of names that are short enough to read."""

import difflib
from collections.abc import Iterable, Sequence


def did_you_mean(word: str, valid: Iterable[str], likeness: float = 0.6) -> str:
    """Return a guess at the valid name that was meant, such as " (did you mean 'kitchen'?)".

    The result is "" if no valid name is similar enough. `likeness` is the least similarity to `word` that the guess must
    have, in [0, 1]; 1 accepts equal names only.
    """
    guess = difflib.get_close_matches(word, list(valid), n=1, cutoff=likeness)
    return f" (did you mean {guess[0]!r}?)" if guess else ""


def listed(names: Sequence[str], most: int = 30) -> str:
    """Return the first `most` names, separated by commas, followed by the number of the names that are left out, if any."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
