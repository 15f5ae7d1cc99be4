"""How many pieces of a kind there are, as the clutter from which on each of them is there.

What stands at some clutter stands at any higher one: pieces are added in that order, and left out below it.
"""

from collections.abc import Iterator
from itertools import count as counted

from worlds.furniture.kinds import AgainstWall, Hoarded, Kind, OnFloor, OnTop
from worlds.furniture.placing.draws import Draws

USUAL = 1.0
"""The clutter of a usual home."""
_LOOSE_M2 = 0.4
"""What stands on the floor and covers less lies about: there is more of it in a cluttered room."""
_ROOM_M2 = 12.0


def appearances(kind: Kind, label: str, area_m2: float, draws: Draws) -> Iterator[tuple[float, int]]:
    """(clutter from which on it is there, number) of each piece of a kind in a room with `label`, from number 1 on."""
    expected, luck, more = kind.rooms[label], draws.random(), draws.random()
    if isinstance(expected, Hoarded):
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
