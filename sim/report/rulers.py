"""`with_rulers`: adds rulers above and to the left of a floor plan, from which coordinates can be read."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from sim.report.data import FloorPlan
from sim.report.drawing import GLYPH_ASPECT, Drawing, Mark

_LETTER_M = 0.2
"""Height of the numbers [m]."""
_OUTSIDE_M = 0.12
"""Distance between the outer edges of the rooms and the ticks [m]: walls are thinner."""
_TICK_M = 0.08
_GAP_M = 0.04
"""Distance between a tick and its number [m]."""
_GROWTH_M = 0.3
"""Length by which the drawing grows to the left and upwards, for the numbers [m]."""
_SHORT_M, _NUMBERED_M, _RARELY_NUMBERED_M = 16.0, 2, 5
"""There is a tick at every metre, and a number at every second metre, or at every fifth one if a side is longer than the
first length."""


def with_rulers(drawing: Drawing, plan: FloorPlan) -> Drawing:
    """Return the drawing of a plan with rulers for x and y in the house's frame W [m]."""
    corners = np.concatenate([room.outline for room in plan.rooms])
    low, high = corners.min(axis=0), corners.max(axis=0)
    step = _NUMBERED_M if (high - low).max() <= _SHORT_M else _RARELY_NUMBERED_M
    x = _ruler(float(low[0]), float(high[0]), np.array([0.0, high[1]]), np.array([1.0, 0.0]), np.array([0.0, 1.0]), step)
    y = _ruler(float(low[1]), float(high[1]), np.array([low[0], 0.0]), np.array([0.0, 1.0]), np.array([-1.0, 0.0]), step)
    marks = [*drawing.marks, *x, *y]
    return replace(drawing, marks=marks, low=drawing.low - [_GROWTH_M, 0.0], high=drawing.high + [0.0, _GROWTH_M])


def _ruler(
    first: float,
    last: float,
    origin: Float64[np.ndarray, "2"],
    along: Float64[np.ndarray, "2"],
    outward: Float64[np.ndarray, "2"],
    step: int,
) -> Iterator[Mark]:
    """Yield ticks and numbers at the whole metres from `first` to `last`, which count from `origin` in a direction."""
    for metre in range(int(np.ceil(first)), int(np.floor(last)) + 1):
        tick = origin + metre * along + np.array([[_OUTSIDE_M], [_OUTSIDE_M + _TICK_M]]) * outward
        yield Mark("line", "scale", tick)
        if metre % step == 0:
            text = f"{metre:d}"
            width = GLYPH_ASPECT * _LETTER_M * len(text)
            beyond = _GAP_M + (width if outward[0] else _LETTER_M / 2)
            at = tick[1] + beyond * outward - (0.0 if outward[0] else width / 2) * along
            yield Mark("text", "note", at[None], text=text, size=_LETTER_M)
