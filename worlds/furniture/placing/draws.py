"""`Draws`: a separate random stream for every piece, so that a change to one piece does not change the draws of others."""

from collections.abc import Sequence
from functools import cache
from zlib import crc32

from numpy.random import Generator

_POOL = 2048
_MASK = _POOL - 1


def pool(rng: Generator) -> tuple[float, ...]:
    """Draw the random numbers in [0, 1) that the streams of all pieces in a room share."""
    return tuple(rng.random(_POOL).tolist())


def stream_key(name: str, number: int, parent: int) -> int:
    """Return the key of the random stream of the `number`-th piece of the kind `name` in a room.

    For a piece that stands at or on, or hangs above another piece, `parent` is the key of that other piece; otherwise 0.
    """
    return crc32(_text(name, number), parent)


@cache
def _text(name: str, number: int) -> bytes:
    return f"{name} {number}".encode()


class Draws:
    """A stream of uniform random numbers for one piece, read from the numbers that all pieces of a room share (the `pool`).

    The key decides where in the pool the stream begins, and the stride by which it moves on for each number. The stride is
    odd and the length of the pool is a power of two, so a stream reads the whole pool before it repeats. A stream costs much
    less than a generator, and the numbers for a piece do not depend on the order of the pieces.
    """

    __slots__ = ("_at", "_pool", "_stride")

    def __init__(self, numbers: Sequence[float], key: int) -> None:
        """Begin the stream with this key (see `stream_key`); `numbers` is the `pool` of the room."""
        self._pool, self._at, self._stride = numbers, key & _MASK, key >> 11 | 1

    def random(self) -> float:
        """Return the next number, uniform in [0, 1)."""
        self._at = at = (self._at + self._stride) & _MASK
        return self._pool[at]

    def uniform(self, low: float, high: float) -> float:
        """Return a number uniform in [low, high)."""
        return low + (high - low) * self.random()

    def index(self, count: int) -> int:
        """Return a random integer from 0 to `count` - 1."""
        return int(count * self.random())
