"""The rules of walkable stairs, and what follows from them: the steps of straight, L- and U-shaped stairs in a cell.

Everything here is about one storey's climb in the cell's own plan coordinates, in metres: u from the side of the cell where
the climb begins, v across; both start at wall centre lines.

    straight            L                    U
    +-----------+       +------+--------+    +-------------+
    |     ^     |       | turn |  ====> |    |   landing   |
    |     |     |       +------+--------+    +------+------+   u
    |     |     |       |  ^   |             |  ^   |  |   |   ^
    |     |     |       |  |   |   void      |  |   |  v   |   |
    +-----------+       +------+--------+    +------+------+   +--> v
"""

import math
from dataclasses import dataclass
from typing import Literal

StairsKind = Literal["straight", "L", "U"]

MAX_RISER_M = 0.19
MIN_TREAD_M = 0.22
MIN_WIDTH_M = 0.8
"""Of a flight; a landing is at least as long as its flight is wide."""
MIN_HEAD_ROOM_M = 1.95
"""Above every tread, landing and way in or out."""
MAX_FLIGHT_RISE_M = 3.7
"""Straight stairs that rise higher have a landing half way."""
WALL_INSET_M = 0.05
"""From a wall's centre line to its face."""
_USUAL_TREAD_M = 0.3
"""Where a cell is longer than needed, steps become no deeper than this."""
_USUAL_WIDTHS_M = (1.0, 0.9)
_USUAL_L_TREAD_M = 0.26
_TOLERANCE_M = 1e-6


def cell_needed(
    kind: StairsKind, rise_m: float, tread_m: float = MIN_TREAD_M, width_m: float = MIN_WIDTH_M
) -> tuple[float, float]:
    """Least length (along the first flight) and width of a cell between wall centre lines, rounded up to the centimetre [m].

    `rise_m` is from floor to floor; treads of at least `tread_m`, flights of at least `width_m`.
    """
    n = risers(kind, rise_m)
    if kind == "straight":
        landing = width_m - tread_m if rise_m > MAX_FLIGHT_RISE_M else 0.0
        return _up(n * tread_m + landing), _up(width_m + 2 * WALL_INSET_M)
    first = (n + 1) // 2
    length = (first - 0.5) * tread_m + width_m + WALL_INSET_M
    if kind == "U":
        return _up(length), _up(2 * width_m + 2 * WALL_INSET_M)
    return _up(length), _up((n - first - 0.5) * tread_m + width_m + WALL_INSET_M)


def risers(kind: StairsKind, rise_m: float) -> int:
    """Number of risers; even for U, whose two flights are alike."""
    if kind == "U":
        return 2 * math.ceil(rise_m / 2 / MAX_RISER_M - _TOLERANCE_M)
    return math.ceil(rise_m / MAX_RISER_M - _TOLERANCE_M)


def _up(length_m: float) -> float:
    return math.ceil(100 * length_m - _TOLERANCE_M) / 100
