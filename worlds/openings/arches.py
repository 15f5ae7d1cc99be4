"""The shape of an arch: upright sides under half an ellipse. Openings give its width and the height of its crown."""

import math

MAX_RISE_M = 0.4


def arch_rise(width_m: float) -> float:
    """How much lower an arch is at its sides than at its crown [m]."""
    return min(width_m / 2, MAX_RISE_M)


def arch_drop(width_m: float, offset_m: float) -> float:
    """How much lower than its crown an arch is at a distance from its middle [m]."""
    return arch_rise(width_m) * (1.0 - math.sqrt(max(0.0, 1.0 - (2.0 * offset_m / width_m) ** 2)))


def spandrel_area(width_m: float) -> float:
    """What an arch lacks of the rectangle around it, both corners together [m²]."""
    return width_m * arch_rise(width_m) * (1.0 - math.pi / 4.0)
