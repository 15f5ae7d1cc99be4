r"""Spiral stairs: a full turn of steps around a pole, from the landing in front of the entrances to the landing above it.

The circle of the steps stands at the far end of the cell. In front of it, a floor across the whole cell leads to the
entrances, which are all in the same side. u and v are the coordinates of `CellFrame`; the arrows point up the stairs.

    +------------------+
    |    . - <- - .    |      u
    |   /    pole  \   |      ^
    |  v       o    ^  |      |
    |   \  +-----+ /   |      +--> v
    |    ' |land.| '   |
    +------+-----+-----+
    |      floor       |
    +--- entrance -----+
"""

import math
from dataclasses import dataclass
from itertools import count, pairwise

from worlds.parts import Colour, Part
from worlds.stairs.cells import CellFrame
from worlds.stairs.flights import MIN_TREAD_M, Point, Rail, Slab
from worlds.stairs.geometry import WOOD
from worlds.walls import HALF_WALL_M

MAX_RISER_M = 0.21
"""Greatest height of a riser of spiral stairs [m]."""
MIN_RADIUS_M = 0.95
"""Least radius of spiral stairs [m]."""
MIN_FRONT_M = 0.6
"""Least depth of the floor between the entrances and the circle of the steps [m]."""
_POLE_M = 0.08
"""Radius of the pole [m]."""
_OUTER_M = 0.35
"""Distance of the walking line from the outer edge of the steps [m]."""
_LANDING_M = 0.8
"""Width of the landing between the floor and the pole [m]."""
_THICKNESS_M = 0.06
"""Thickness of a step [m]."""
_STEEL: Colour = (0.35, 0.36, 0.38)


@dataclass(frozen=True)
class Spiral:
    """Spiral stairs in the coordinates of their cell (the room of the stairs) [m]."""

    length: float
    """Extent of the cell from the entrances inwards, between the walls' centre lines [m]."""
    width: float
    """Extent of the cell along the side with the entrances, between the walls' centre lines [m]."""
    rise: float
    """Height from floor to floor [m]."""

    @property
    def radius(self) -> float:
        """Radius of the outer edge of the steps [m]: the largest that leaves the floor in front of the entrances."""
        return min(self.width / 2 - HALF_WALL_M, (self.length - HALF_WALL_M - MIN_FRONT_M) / 2)

    @property
    def walking_radius(self) -> float:
        """Radius of the walking line on the steps [m]."""
        return self.radius - _OUTER_M

    @property
    def centre(self) -> tuple[float, float]:
        """Place (u, v) of the pole [m]."""
        return self.length - HALF_WALL_M - self.radius, self.width / 2

    @property
    def front_m(self) -> float:
        """Depth of the floor between the side with the entrances and the circle of the steps [m]."""
        return self.centre[0] - self.radius

    @property
    def risers(self) -> int:
        """Number of risers; the last one leads from the highest step to the landing."""
        return math.ceil(self.rise / MAX_RISER_M - 1e-6)

    @property
    def tread_m(self) -> float:
        """Depth of the steps on the walking line [m]."""
        return self.walking_radius * self._step_rad

    @property
    def is_walkable(self) -> bool:
        """Whether the steps are deep enough, and the cell is large enough."""
        fits = self.radius >= MIN_RADIUS_M - 1e-6 and self.front_m >= MIN_FRONT_M - 1e-6
        return fits and self.tread_m >= MIN_TREAD_M

    @property
    def _landing_rad(self) -> float:
        """Half the angle that the landing takes up on the walking line [rad]."""
        return math.asin(_LANDING_M / 2 / self.walking_radius)

    @property
    def _step_rad(self) -> float:
        return (2 * math.pi - 2 * self._landing_rad) / (self.risers - 1)

    def _angles(self) -> list[float]:
        """Return the angle of the middle of each step, counted in the direction of the climb from the landing [rad]."""
        return [self._landing_rad + (k + 0.5) * self._step_rad for k in range(self.risers - 1)]

    def at(self, radius: float, angle: float) -> tuple[float, float]:
        """Return the place (u, v) at a distance from the pole [m] and an angle from the landing [rad]."""
        u, v = self.centre
        return u - radius * math.cos(angle), v + radius * math.sin(angle)

    def line(self, foot_v: float, head_v: float) -> list[Point]:
        """Return the walking line between the entrances, whose middles are at `foot_v` and `head_v` along their side [m]."""
        front, middle = self.front_m / 2, self.centre[1]
        below = [(0.0, foot_v), (front, foot_v), (front, middle), self.at(self.walking_radius, 0.0)]
        above = [self.at(self.walking_radius, 0.0), (front, middle), (front, head_v), (0.0, head_v)]
        steps = [self.at(self.walking_radius, angle) for angle in self._angles()]
        heights = [k * self.rise / self.risers for k in range(1, self.risers)]
        line = [
            *((u, v, 0.0) for u, v in below),
            *((u, v, z) for (u, v), z in zip(steps, heights, strict=True)),
            *((u, v, self.rise) for u, v in above),
        ]
        return [line[0], *(b for a, b in pairwise(line) if math.dist(a, b) > 1e-6)]

    def floors(self) -> list[Slab]:
        """Return the floor in front of the entrances on the upper storey, and the landing between it and the pole."""
        (u, v), half = self.centre, _LANDING_M / 2
        across = (HALF_WALL_M, self.width - HALF_WALL_M)
        return [
            Slab((0.0, self.front_m), across, self.rise),
            Slab((self.front_m, u - _POLE_M), (v - half, v + half), self.rise),
        ]

    def rails(self, goes_on: bool) -> list[Rail]:
        """Return the railings of the upper floor and its landing, except where the steps arrive.

        If another spiral `goes_on` from the landing, there is no railing where its steps begin.
        """
        (u, v), half, edge, top = self.centre, _LANDING_M / 2, self.front_m, self.rise
        beside_landing = Rail((edge, v + half, top), (u - _POLE_M, v + half, top))
        return [
            Rail((edge, HALF_WALL_M, top), (edge, v - half, top)),
            Rail((edge, v + half, top), (edge, self.width - HALF_WALL_M, top)),
            *([] if goes_on else [beside_landing]),
        ]

    def steps(self, frame: CellFrame, floor_m: float) -> tuple[Part, ...]:
        """Return the steps as boxes and the pole as a cylinder; `floor_m` is the height of the lower floor in W [m]."""
        middle, length = (_POLE_M + self.radius) / 2, self.radius - _POLE_M
        x, y = frame.world(*self.centre)
        parts = []
        for k, angle in enumerate(self._angles()):
            a, b = frame.world(*self.at(middle, angle))
            top = floor_m + (k + 1) * self.rise / self.risers
            size = (length, self.radius * self._step_rad, _THICKNESS_M)
            parts.append(Part("box", (a, b, top - _THICKNESS_M / 2), size, WOOD, "wood", math.atan2(b - y, a - x)))
        pole = Part("cylinder", (x, y, floor_m + self.rise / 2), (2 * _POLE_M, 2 * _POLE_M, self.rise), _STEEL)
        return (*parts, pole)


def least_cell(rise_m: float) -> tuple[float, float]:
    """Return the least length and width of a cell in which a spiral can rise `rise_m`, in whole centimetres [m].

    The length is measured from the entrances inwards, the width along their side.
    """
    diameters = (2 * MIN_RADIUS_M + k / 100 for k in count())
    cells = ((round(d + HALF_WALL_M + MIN_FRONT_M, 2), round(d + 2 * HALF_WALL_M, 2)) for d in diameters)
    return next(cell for cell in cells if Spiral(*cell, rise_m).is_walkable)
