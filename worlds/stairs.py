"""U-shaped stairs: two flights with a landing, in a cell that is stacked on itself from storey to storey.

Both the way in and the way out are on the same side of the cell, so a stack of storeys needs one cell and one hall.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from shapely.geometry import Polygon

from worlds.errors import HouseError
from worlds.parts import Part
from worlds.spec import OpeningSpec

MAX_RISER_M = 0.19
MIN_TREAD_M = 0.22
LANDING_M = 0.95
TREAD_THICKNESS_M = 0.3
_APPROACH_M = 0.4
_COLOUR = (0.62, 0.47, 0.33)


@dataclass(frozen=True, eq=False)
class Stairs:
    """A pair of flights between two storeys."""

    room: str
    """Id of the stairs' room."""
    storey: int
    """The lower of the two storeys."""
    treads: tuple[Part, ...]
    """Boxes in world coordinates."""
    walking_line: Float64[np.ndarray, "k 3"]
    """Walked surface, from the lower storey's room in front of the stairs to the upper one's [m]."""


def build_stairs(
    room: str, storey: int, cell: Polygon, foot: OpeningSpec, floors_m: tuple[float, float], inset_m: float
) -> Stairs:
    """The flights that rise from opening `foot` of storey `storey` in the rectangular `cell` (wall centre lines).

    Raises `HouseError` where the cell is too small for walkable steps.
    """
    frame = _CellFrame.of(cell, foot, inset_m)
    rise = floors_m[1] - floors_m[0]
    steps = math.ceil(rise / 2 / MAX_RISER_M)
    riser, run = rise / (2 * steps), frame.length - LANDING_M
    tread = run / (steps - 1)
    if tread < MIN_TREAD_M or frame.width < 1.4:
        raise HouseError(
            f"stairs {room!r}: {frame.length:.2f} x {frame.width:.2f} m inside is too small for a rise of {rise:.2f} m; "
            f"needs at least {LANDING_M + (steps - 1) * MIN_TREAD_M:.2f} x 1.40 m"
        )
    half = frame.width / 2
    boxes = [frame.box(run, frame.length, 0.0, frame.width, floors_m[0] + steps * riser)]
    for i in range(1, steps):
        boxes.append(frame.box((i - 1) * tread, i * tread, 0.0, half, floors_m[0] + i * riser))
        boxes.append(frame.box(run - i * tread, run - (i - 1) * tread, half, frame.width, floors_m[0] + (steps + i) * riser))
    near, middle, far = half / 2, run + LANDING_M / 2, 1.5 * half
    low, landing, high = floors_m[0], floors_m[0] + steps * riser, floors_m[1]
    line = [
        (-_APPROACH_M, near, low), (0.0, near, low), (run, near, landing), (middle, near, landing),
        (middle, far, landing), (run, far, landing), (0.0, far, high), (-_APPROACH_M, far, high),
    ]  # fmt: skip
    walking_line = np.array([(*frame.world(u, v), z) for u, v, z in line])
    return Stairs(room, storey, tuple(boxes), walking_line)


@dataclass(frozen=True)
class _CellFrame:
    """Coordinates in the cell: u inwards from the entry side, v across from the first flight to the second."""

    origin: tuple[float, float]
    u_axis: tuple[float, float]
    v_axis: tuple[float, float]
    length: float
    width: float

    @staticmethod
    def of(cell: Polygon, foot: OpeningSpec, inset_m: float) -> "_CellFrame":
        x0, y0, x1, y1 = cell.bounds
        middle = np.add(foot.start_m, foot.end_m) / 2
        gaps = {(1, 0): middle[0] - x0, (-1, 0): x1 - middle[0], (0, 1): middle[1] - y0, (0, -1): y1 - middle[1]}
        u_axis = min(gaps, key=lambda side: abs(gaps[side]))
        centre = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
        size = np.array([x1 - x0, y1 - y0]) - 2 * inset_m
        u, v = np.array(u_axis, float), np.array([-u_axis[1], u_axis[0]], float)
        if (middle - centre) @ v > 0:
            v = -v  # the first flight starts behind the lower storey's opening
        length, width = float(abs(size @ u)), float(abs(size @ v))
        # The steps run through the entry side's wall line to the hall's floor, so u starts at the centre line.
        origin = centre - u * (length / 2 + inset_m) - v * width / 2
        return _CellFrame(tuple(origin), tuple(u), tuple(v), length + inset_m, width)

    def world(self, u: float, v: float) -> tuple[float, float]:
        x, y = np.array(self.origin) + u * np.array(self.u_axis) + v * np.array(self.v_axis)
        return float(x), float(y)

    def box(self, u0: float, u1: float, v0: float, v1: float, top: float) -> Part:
        (xa, ya), (xb, yb) = self.world(u0, v0), self.world(u1, v1)
        size = (abs(xb - xa), abs(yb - ya), TREAD_THICKNESS_M)
        return Part("box", ((xa + xb) / 2, (ya + yb) / 2, top - TREAD_THICKNESS_M / 2), size, _COLOUR, "wood")
