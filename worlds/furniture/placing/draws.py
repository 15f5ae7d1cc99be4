"""`Draws`: a separate random stream for every piece, so that a change to one piece does not change the draws of others."""

from collections.abc import Sequence
from functools import cache
from zlib import crc32

from numpy.random import Generator

_POOL = 2048
_MASK = _POOL - 1


def pool(rng: Generator) -> tuple[float, ...]:
    """The numbers in [0, 1) that all streams of a room draw from."""
    return tuple(rng.random(_POOL).tolist())


def stream_key(name: str, number: int, parent: int = 0) -> int:
    """A key for the `number`-th thing called `name` that belongs to the thing with key `parent`."""
    return crc32(_text(name, number), parent)


@cache
def _text(name: str, number: int) -> bytes:
    return f"{name} {number}".encode()


class Draws:
    """A stream of uniform numbers from a room's pool, read from a start and with a stride that follow from the key.

    The stride is odd and the length of the pool is a power of two, so a stream visits the whole pool before it repeats.
    This is much faster than a generator per piece, and the draws do not depend on the order of the pieces.
    """

    __slots__ = ("_at", "_pool", "_stride")

    def __init__(self, numbers: Sequence[float], key: int) -> None:
        """`numbers` is the room's `pool`, `key` a `stream_key`."""
        self._pool, self._at, self._stride = numbers, key & _MASK, key >> 11 | 1

    def random(self) -> float:
        """The next number, uniform in [0, 1)."""
        self._at = at = (self._at + self._stride) & _MASK
        return self._pool[at]

    def uniform(self, low: float, high: float) -> float:
        """A number uniform in [low, high)."""
        return low + (high - low) * self.random()

    def index(self, count: int) -> int:
        """An integer from 0 to `count` - 1."""
        return int(count * self.random())
