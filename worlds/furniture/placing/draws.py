"""`Draws`: a random stream of its own for every piece, so that a change to one leaves the others' draws alone."""

from collections.abc import Sequence
from functools import cache
from zlib import crc32

from numpy.random import Generator

_POOL = 2048
_MASK = _POOL - 1


def pool(rng: Generator) -> tuple[float, ...]:
    """The numbers in [0, 1) that all streams of a room are made of."""
    return tuple(rng.random(_POOL).tolist())


def stream_key(name: str, number: int, parent: int = 0) -> int:
    """A key for the `number`-th thing called `name` that belongs to the thing with key `parent`."""
    return crc32(_text(name, number), parent)


@cache
def _text(name: str, number: int) -> bytes:
    return f"{name} {number}".encode()


class Draws:
    """Numbers uniform in [0, 1): the room's pool, walked from a start and with an odd stride that the key gives.

    That is much faster than a generator per piece, and needs no order between pieces.
    """

    __slots__ = ("_at", "_pool", "_stride")

    def __init__(self, numbers: Sequence[float], key: int) -> None:
        """`numbers` is the room's `pool`, `key` a `stream_key`."""
        self._pool, self._at, self._stride = numbers, key & _MASK, key >> 11 | 1

    def random(self) -> float:
        """The next number."""
        self._at = at = (self._at + self._stride) & _MASK
        return self._pool[at]

    def uniform(self, low: float, high: float) -> float:
        """Between `low` and `high`."""
        return low + (high - low) * self.random()

    def index(self, count: int) -> int:
        """One of 0 ... `count` - 1."""
        return int(count * self.random())
