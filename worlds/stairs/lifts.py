"""Lifts: a platform that fills its cell (the room of the lift) and rises straight up, from one door to the door above.

A lift takes the place of a flight of stairs, and its cells are rooms of stairs. Each cell has one door, for the ride up and
for the ride down. The platform is wherever the walker is, and is not drawn: on a picture, a lift is an empty shaft.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from worlds.errors import HouseError
from worlds.labels import STAIRS
from worlds.spec import HouseSpec, RoomSpec
from worlds.stairs.cells import bounds, cell_on, inward, middle, openings_of

MIN_SHAFT_M = 1.0
"""Least length and width of the shaft of a lift, between the centre lines of its walls [m]."""
MIN_DOOR_M, MIN_DOOR_HEIGHT_M = 0.6, 1.95
"""Least width and height of the door of a lift [m]."""
_INSIDE_M = 0.8
"""Distance from the lower door at which the walker stands during the ride, if the shaft is deep enough [m]."""


class _Door(NamedTuple):
    """The door of a lift on one storey, on the floor."""

    middle: Float64[np.ndarray, "3"]
    """Middle of the door in W [m]."""
    inward: Float64[np.ndarray, "3"]
    """Unit vector from the door into the cell."""

    def at(self, depth_m: float) -> Float64[np.ndarray, "3"]:
        """Return the point in W straight behind the door, `depth_m` inside the cell [m]."""
        return self.middle + depth_m * self.inward


def lift_line(
    spec: HouseSpec, level: int, cells: tuple[RoomSpec, RoomSpec], floors_m: tuple[float, float], approach_m: float
) -> Float64[np.ndarray, "k 3"]:
    """Return the walking line of a lift in W [m], from outside of the lower door to outside of the upper door.

    Args:
        spec: the house.
        level: index of the lower storey.
        cells: the lift's cells on the lower and on the upper storey.
        floors_m: heights of these two storeys' floors in W [m].
        approach_m: distance from the cell at which the line begins and ends [m].

    Raises:
        HouseError: the shaft is too small, or a cell has no suitable door.
    """
    x0, y0, x1, y1 = bounds(cells[0])
    if min(x1 - x0, y1 - y0) < MIN_SHAFT_M - 1e-6:
        raise HouseError(
            f"lift {cells[0].id!r}: its shaft is {x1 - x0:.2f} x {y1 - y0:.2f} m; valid: at least {MIN_SHAFT_M} x "
            f"{MIN_SHAFT_M} m, between the walls' centre lines"
        )
    foot, head = (_door(spec, level + k, cells[k], floors_m[k]) for k in (0, 1))
    stand = foot.at(min(_INSIDE_M, abs(float(foot.inward @ [x1 - x0, y1 - y0, 0.0])) / 2))
    below_exit = head.at(float((stand - head.middle) @ head.inward))
    ride = [stand, stand + [0.0, 0.0, floors_m[1] - floors_m[0]]]
    line = np.round([foot.at(-approach_m), foot.middle, *ride, below_exit, head.middle, head.at(-approach_m)], 9)
    return np.array([line[0], *(b for a, b in pairwise(line) if (a != b).any())])


def check_lifts(spec: HouseSpec) -> None:
    """Raise `HouseError` for a lift without the label of stairs, and for one that continues as stairs on another storey."""
    for level, storey in enumerate(spec.storeys):
        for room in storey.rooms:
            if room.lift and room.label != STAIRS:
                raise HouseError(f"room {room.id!r} ({room.label}) is a lift; valid: lifts with the label {STAIRS!r}")
            above = cell_on(spec, level + 1, room)
            if above is not None and above.lift != room.lift:
                raise HouseError(f"{room.id!r} and {above.id!r} above: one is a lift, the other stairs; valid: both lifts")


def _door(spec: HouseSpec, level: int, cell: RoomSpec, floor_m: float) -> _Door:
    """Return the door of a lift on `storeys[level]`. Raises `HouseError` unless there is exactly one, and it is walkable."""
    doors = [opening for _, opening in openings_of(spec.storeys[level], cell)]
    if len(doors) != 1:
        raise HouseError(f"lift {cell.id!r} has {len(doors)} openings on storeys[{level}]; valid: one on every storey")
    height = doors[0].gap_m(spec.storeys[level].height_m)[1]
    if doors[0].width_m < MIN_DOOR_M - 1e-6 or height < MIN_DOOR_HEIGHT_M - 1e-6:
        raise HouseError(
            f"lift {cell.id!r}: its opening on storeys[{level}] is {doors[0].width_m:.2f} m wide and {height:.2f} m high; "
            f"valid: at least {MIN_DOOR_M} x {MIN_DOOR_HEIGHT_M} m"
        )
    return _Door(np.array([*middle(doors[0]), floor_m]), np.array([*inward(level, cell, doors[0]), 0.0]))
