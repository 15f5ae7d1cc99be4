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
    """The key of the random stream of a piece: the `number`-th `name` at, on or above the piece with the key `parent`."""
    return crc32(_text(name, number), parent)


@cache
def _text(name: str, number: int) -> bytes:
    return f"{name} {number}".encode()


class Draws:
    """A stream of uniform numbers. It steps through the pool of a room; the key gives the start and the stride.

    The stride is odd and the length of the pool is a power of two, so a stream visits the whole pool before it repeats.
    A stream costs much less than a generator, and the draws for a piece do not depend on the order of the pieces.
    """

    __slots__ = ("_at", "_pool", "_stride")

    def __init__(self, numbers: Sequence[float], key: int) -> None:
        """`numbers` is the `pool` of the room; `key` comes from `stream_key`."""
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
