"""Shafts, which are cells (rooms of stairs) with a lift or with spiral stairs: their entrances, and the way through a lift.

A shaft has one entrance on each storey, for the way up and for the way down. The platform of a lift fills the cell. It is
wherever the walker is, and is not rendered: on images, a lift is an empty shaft.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from worlds.errors import HouseError
from worlds.labels import STAIRS
from worlds.spec import HouseSpec, RoomSpec
from worlds.stairs.cells import APPROACH_M, BODY_HALF_M, MIN_HEAD_ROOM_M, bounds, cell_on, inward, openings_of

MIN_SHAFT_M = 1.0
"""Least length and width of the shaft of a lift, between the centre lines of its walls [m]."""
MIN_SHAFT_ENTRANCE_M = 2 * BODY_HALF_M
"""Least width of the entrance of a shaft [m]."""
_INSIDE_M = 0.8
"""Distance from the lower entrance at which the walker stands during the ride, if the shaft is deep enough [m]."""


class Entrance(NamedTuple):
    """The entrance of a shaft on one storey: an opening of any kind that one can walk through, on the floor."""

    middle: Float64[np.ndarray, "3"]
    """Middle of the entrance in W [m]."""
    inward: Float64[np.ndarray, "3"]
    """Unit vector from the entrance into the cell."""

    def at(self, depth_m: float) -> Float64[np.ndarray, "3"]:
        """Return the point in W straight behind the entrance, `depth_m` inside the cell [m]."""
        return self.middle + depth_m * self.inward


def lift_line(
    spec: HouseSpec, level: int, cells: tuple[RoomSpec, RoomSpec], floors_m: tuple[float, float]
) -> Float64[np.ndarray, "k 3"]:
    """Return the walking line of a lift in W [m], from outside of the lower entrance to outside of the upper entrance.

    Args:
        spec: the house.
        level: index of the lower storey.
        cells: the lift's cells on the lower and on the upper storey.
        floors_m: heights of these two storeys' floors in W [m].

    Raises:
        HouseError: the shaft is too small, or a cell has no suitable entrance.
    """
    x0, y0, x1, y1 = bounds(cells[0])
    if min(x1 - x0, y1 - y0) < MIN_SHAFT_M - 1e-6:
        raise HouseError(
            f"lift {cells[0].id!r}: its shaft is {x1 - x0:.2f} x {y1 - y0:.2f} m; valid: at least {MIN_SHAFT_M} x "
            f"{MIN_SHAFT_M} m, between the walls' centre lines"
        )
    foot, head = (entrance(spec, level + k, cells[k], floors_m[k]) for k in (0, 1))
    stand = foot.at(min(_INSIDE_M, abs(float(foot.inward @ [x1 - x0, y1 - y0, 0.0])) / 2))
    below_exit = head.at(float((stand - head.middle) @ head.inward))
    ride = [stand, stand + [0.0, 0.0, floors_m[1] - floors_m[0]]]
    line = np.round([foot.at(-APPROACH_M), foot.middle, *ride, below_exit, head.middle, head.at(-APPROACH_M)], 9)
    return np.array([line[0], *(b for a, b in pairwise(line) if (a != b).any())])


def check_shafts(spec: HouseSpec) -> None:
    """Raise `HouseError` for a shaft without the label of stairs, or with another way to climb on another storey."""
    for level, storey in enumerate(spec.storeys):
        for room in storey.rooms:
            if room.climb != "flights" and room.label != STAIRS:
                raise HouseError(
                    f"room {room.id!r} is labelled {room.label!r} but has climb {room.climb!r}; "
                    f"valid: climb only in rooms labelled {STAIRS!r}"
                )
            above = cell_on(spec, level + 1, room)
            if above is not None and above.climb != room.climb:
                raise HouseError(
                    f"{room.id!r} has the climb {room.climb!r}, and {above.id!r} above it {above.climb!r}; valid: the same"
                )


def entrance(spec: HouseSpec, level: int, cell: RoomSpec, floor_m: float) -> Entrance:
    """Return the entrance of a shaft on `storeys[level]`. Raises `HouseError` unless there is one, and it is walkable."""
    entrances = [opening for _, opening in openings_of(spec.storeys[level], cell)]
    if len(entrances) != 1:
        raise HouseError(
            f"{cell.climb} {cell.id!r} has {len(entrances)} openings on storeys[{level}]; valid: one on every storey"
        )
    height = entrances[0].gap_m(spec.storeys[level].height_m)[1]
    if entrances[0].width_m < MIN_SHAFT_ENTRANCE_M - 1e-6 or height < MIN_HEAD_ROOM_M - 1e-6:
        raise HouseError(
            f"{cell.climb} {cell.id!r}: its opening on storeys[{level}] is {entrances[0].width_m:.2f} x {height:.2f} m; "
            f"valid: at least {MIN_SHAFT_ENTRANCE_M} x {MIN_HEAD_ROOM_M} m"
        )
    return Entrance(np.array([*entrances[0].middle_m, floor_m]), np.array([*inward(level, cell, entrances[0]), 0.0]))
