"""The shape of an arch: vertical sides with half an ellipse on top.

The spec of an opening gives the width of the arch and the height of its crown, which is the highest point of the curve.
"""

import math

MAX_RISE_M = 0.4
"""Greatest height of the curved part of an arch [m]. An arch whose width is at most twice this height has a semicircle on
top."""


def arch_rise(width_m: float) -> float:
    """Return the height of the crown (the highest point) above the points where the curve meets the vertical sides [m]."""
    return min(width_m / 2, MAX_RISE_M)


def arch_drop(width_m: float, offset_m: float) -> float:
    """Return the height of the crown (the highest point) above another point of the curve [m].

    `offset_m` is the horizontal distance of this other point from the middle of the arch [m].
    """
    return arch_rise(width_m) * (1.0 - math.sqrt(max(0.0, 1.0 - (2.0 * offset_m / width_m) ** 2)))


def spandrel_area(width_m: float) -> float:
    """Return the area of both spandrels together [m²]: the corners between an arch and the rectangle around the arch."""
    return width_m * arch_rise(width_m) * (1.0 - math.pi / 4.0)
