"""How many pieces of a kind a room has: each piece has a threshold, and is present if `clutter` is at least that high.

A piece that is present at some clutter is therefore present at any higher clutter.
"""

from collections.abc import Iterator
from itertools import count as counted

from worlds.furniture.kinds import AgainstWall, Kind, OnFloor, OnTop, PerClutter
from worlds.furniture.placing.draws import Draws

USUAL = 1.0
"""Value of `clutter` in a usual home."""
_LOOSE_M2 = 0.4
"""Footprint below which a piece on the floor counts as loose [m²]. Higher clutter than usual adds more loose pieces."""
_ROOM_M2 = 12.0
"""Area of a room for which `PerClutter.per_clutter` gives the number of pieces on the floor [m²]."""


def appearances(kind: Kind, label: str, area_m2: float, draws: Draws) -> Iterator[tuple[float, int]]:
    """Return pairs (least clutter at which a piece is present, number of the piece), for a kind in a room with `label`.

    Pieces are numbered from 1. The sequence is infinite for `PerClutter`, and for a loose kind whose number is an expected
    number. Loose kinds are small, or are placed on top of other pieces. For all other kinds, the sequence ends at the
    clutter of a usual home.
    """
    expected, luck, more = kind.rooms[label], draws.random(), draws.random()
    if isinstance(expected, PerClutter):
        step = 1.0 if isinstance(kind.place, OnTop) else _ROOM_M2 / area_m2
        return ((USUAL + step * (k - luck) / expected.per_clutter, k) for k in counted(1))
    if isinstance(expected, tuple):
        low, high = expected
        total = low + int(more * (high - low + 1))
        return ((USUAL * (k - luck) / total, k) for k in range(1, total + 1))
    each = ((USUAL * (k - luck) / expected, k) for k in counted(1))
    return each if _is_loose(kind) else _usual(each)


def _usual(each: Iterator[tuple[float, int]]) -> Iterator[tuple[float, int]]:
    for since, k in each:
        if since > USUAL:
            return
        yield since, k


def _is_loose(kind: Kind) -> bool:
    match kind.place:
        case OnTop():
            return True
        case AgainstWall() | OnFloor():
            return kind.width[1] * kind.depth[1] < _LOOSE_M2
    return False
