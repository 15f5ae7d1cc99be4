"""`with_legend`: adds a legend below a drawing, a symbol and a text for each entry."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sim.report.drawing import GLYPH_ASPECT, STYLES, Drawing, Mark, arrow

_SYMBOL = 1.8
"""Least width of the symbols, in heights of letters. Dots that are larger need more, because they are as large as on the
plan."""
_GAP = 0.6
"""Distance between symbol and text, in heights of letters."""
_ROW = 1.7
"""Least distance between two rows, in heights of letters."""


@dataclass(frozen=True)
class LegendEntry:
    """An entry of a legend: what a kind of mark means."""

    kind: Literal["line", "arrow", "dot"]
    style: str
    """A key of `STYLES`."""
    text: str
    colour: str | None = None
    """Colour `#rrggbb` in place of the style's, as in `Mark`."""


def with_legend(drawing: Drawing, entries: Sequence[LegendEntry], letter_m: float) -> Drawing:
    """Return the drawing with a legend below it, in rows as wide as the drawing. Letters are `letter_m` high [m]."""
    left, right = float(drawing.low[0]) + letter_m, float(drawing.high[0])
    symbol_m = max(_SYMBOL * letter_m, *(2.0 * STYLES[entry.style].radius for entry in entries), 0.0)
    row_m = max(_ROW * letter_m, *(2.5 * STYLES[entry.style].radius for entry in entries), 0.0)
    x, y, marks = left, float(drawing.low[1]) - row_m / 2, list(drawing.marks)
    for entry in entries:
        width = symbol_m + letter_m * (_GAP + GLYPH_ASPECT * len(entry.text))
        if x > left and x + width > right:
            x, y = left, y - row_m
        marks += _entry(entry, x, y, symbol_m, letter_m)
        x += width + 2 * _GAP * letter_m
    return Drawing(marks, np.array([drawing.low[0], y - row_m]), drawing.high, title=drawing.title)


def _entry(entry: LegendEntry, x: float, y: float, symbol_m: float, letter_m: float) -> Iterator[Mark]:
    end = x + symbol_m
    points = np.array([[x, y], [end, y]])
    match entry.kind:
        case "line":
            yield Mark("line", entry.style, points, entry.colour)
        case "arrow":
            yield Mark("line", entry.style, arrow(points[0], points[1], letter_m / 2), entry.colour)
        case "dot":
            yield Mark("dot", entry.style, points.mean(axis=0, keepdims=True), entry.colour)
    yield Mark("text", "note", np.array([[end + _GAP * letter_m, y]]), text=entry.text, size=letter_m)
