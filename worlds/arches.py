"""The shape of an arch: vertical sides with half an ellipse on top.

An opening gives the width of the arch and the height of its crown, the highest point.
"""

import math

MAX_RISE_M = 0.4
"""Greatest height of the curved part of an arch [m]; a narrow arch is a semicircle."""


def arch_rise(width_m: float) -> float:
    """Height difference between the crown and the point where the curve meets the vertical sides [m]."""
    return min(width_m / 2, MAX_RISE_M)


def arch_drop(width_m: float, offset_m: float) -> float:
    """Height difference between the crown of an arch and its curve `offset_m` [m] beside the middle [m]."""
    return arch_rise(width_m) * (1.0 - math.sqrt(max(0.0, 1.0 - (2.0 * offset_m / width_m) ** 2)))


def spandrel_area(width_m: float) -> float:
    """Area between an arch and its bounding rectangle, both corners together [m²]."""
    return width_m * arch_rise(width_m) * (1.0 - math.pi / 4.0)
