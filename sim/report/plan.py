"""Draws a storey's floor plan: rooms in the colour of their label, walls, openings, furniture, names and a scale bar."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Float64

from sim.errors import SimError
from sim.report.data import FloorPlan, PlannedRoom
from sim.report.drawing import GLYPH_ASPECT, Drawing, Mark
from sim.report.symbols import NAMES, WINDOW, WITH_LEAF, climb_marks, leaf_marks, opening_marks, sample_marks, window_marks

_MARGIN_M = 0.5
_INSET_M = 0.16
_SCALE_M = 2.0
LETTER_M = 0.26
"""Usual height of the letters of names [m]."""
_NOTE = 0.92
"""Height of the letters of the title and beside the scale bar, relative to names."""
_LEGEND = 0.77
"""Height of the letters of the legend, relative to names."""
_LEAST_TEXT_M = 0.02
_SAMPLE_M = 0.6
"""Length of the symbols in the legend [m]."""


def plan_drawing(
    plan: FloorPlan,
    colours: Mapping[str, str],
    names_labels: bool = True,
    room_colours: Mapping[str, str] = MappingProxyType({}),
    letter_m: float = LETTER_M,
) -> Drawing:
    """Draw the plan of a storey. `colours` maps room labels to colours. Raises `SimError` for a storey without rooms.

    `names_labels` says whether the label of a room is written beside a name that does not contain it. `room_colours` maps
    names of rooms to the colours of the estimated rooms that match them. `letter_m` is the height of the letters of names
    [m], where they fit into their room.
    """
    if not plan.rooms:
        raise SimError(f"plan of storey {plan.level}: it has no rooms; at least one is needed")
    corners = np.concatenate([room.outline for room in plan.rooms])
    low, high = corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M
    symbols = list(_legend(plan, low + [_MARGIN_M, -0.05], float(high[0]), _LEGEND * letter_m))
    low[1] = min([low[1] - 0.4, *(float(mark.points[:, 1].min()) - 0.75 for mark in symbols)])
    notes = [*_scale(low, _NOTE * letter_m), *symbols]
    high[0] = max([high[0], *(mark.points[0, 0] + _text_m(mark) + _INSET_M for mark in notes if mark.style == "note")])
    marks = [
        *(_floor(room, colours[room.label], room_colours.get(room.name)) for room in plan.rooms),
        *(Mark("polygon", "tread", outline) for outline in plan.treads),
        *(mark for path in plan.climbs for mark in climb_marks(path)),
        *(Mark("polygon", "furniture", outline) for outline in plan.furniture),
        *(Mark("polygon", "fence", outline) for outline in plan.fences),
        *(Mark("polygon", "wall", outline) for outline in plan.walls),
        *(mark for opening in plan.openings for mark in opening_marks(opening)),
        *(mark for ends in plan.windows for mark in window_marks(ends)),
        *(mark for leaf in plan.leaves for mark in leaf_marks(leaf)),
        *(mark for room in plan.rooms for mark in _name(room, names_labels, letter_m)),
        *notes,
    ]
    return Drawing(marks, low, high, title=f"storey {plan.level}, floor at {plan.floor_m:.2f} m")


def titled(drawing: Drawing) -> Drawing:
    """Return the drawing with its title above it."""
    at = np.array([[drawing.low[0] + _MARGIN_M, drawing.high[1]]])
    size = _NOTE * LETTER_M
    title = Mark("text", "note", at, text=drawing.title, size=size)
    return replace(drawing, marks=[*drawing.marks, title], high=drawing.high + [0.0, 2 * size])


def _floor(room: PlannedRoom, colour: str, room_colour: str | None) -> Mark:
    return Mark("polygon", "room", room.outline, colour, f"{room.name} ({room.label})", room_colour=room_colour)


def _name(room: PlannedRoom, names_label: bool, letter_m: float) -> Iterator[Mark]:
    """Yield the room's name in an upper left corner of the room, where few paths run.

    The name has one or two lines. The corner and the line break are chosen so that the text is as large as possible. A name
    that would be too small to read is left out.
    """
    text = room.name if room.label in room.name or not names_label else f"{room.name} ({room.label})"
    (size, _, lines), corner = max(
        (
            ((_fitting_size(lines, width, letter_m), corner[1], lines), corner)
            for corner, width in _corners(room.outline)
            for lines in _layouts(text)
        ),
        key=lambda fit: fit[0],
    )
    if size < _LEAST_TEXT_M:
        return
    for i, line in enumerate(lines):
        yield Mark("text", "name", corner[None] - [0, (0.6 + 1.15 * i) * size], text=line, size=size)


def _text_m(mark: Mark) -> float:
    """Return the width of a text [m]."""
    return GLYPH_ASPECT * mark.size * len(mark.text)


def _layouts(text: str) -> list[tuple[str, ...]]:
    words = text.split(" ")
    return [(text,), *((" ".join(words[:i]), " ".join(words[i:])) for i in range(1, len(words)))]


def _fitting_size(lines: tuple[str, ...], width: float, letter_m: float) -> float:
    return min(letter_m if len(lines) == 1 else 0.96 * letter_m, width / (GLYPH_ASPECT * max(map(len, lines))))


def _corners(outline: Float64[np.ndarray, "corners 2"]) -> Iterator[tuple[Float64[np.ndarray, "2"], float]]:
    """Yield, for each upper edge of the room, its left end, moved inside the room, and the width available there [m]."""
    for right, left in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if left[0] < right[0]:  # counter-clockwise: upper edges run to the left
            yield left + [_INSET_M, -_INSET_M], float(right[0] - left[0]) - 2 * _INSET_M


def _legend(plan: FloorPlan, start: Float64[np.ndarray, "2"], right: float, letter_m: float) -> Iterator[Mark]:
    """Yield the marks of the legend: each symbol of the plan with its name, in rows as wide as the plan."""
    kinds = {opening.kind for opening in plan.openings if not opening.has_leaf}
    leaf, window = [WITH_LEAF] if plan.leaves else [], [WINDOW] if plan.windows else []
    x, y = start
    for name in [*leaf, *(NAMES[kind] for kind in NAMES if kind in kinds), *window]:
        width = _SAMPLE_M + 0.12 + GLYPH_ASPECT * letter_m * len(name) + 0.3
        if x > start[0] and x + width > right:
            x, y = start[0], y - max(0.45, 1.7 * letter_m)
        ends = np.array([[x, y], [x + _SAMPLE_M, y]])
        yield from sample_marks(name, ends)
        yield Mark("text", "note", ends[1:] + [0.12, 0.0], text=name, size=letter_m)
        x += width


def _scale(low: Float64[np.ndarray, "2"], letter_m: float) -> list[Mark]:
    x, y = low[0] + _MARGIN_M, low[1] + 0.35
    bar = np.array([[x, y + 0.08], [x, y], [x + _SCALE_M, y], [x + _SCALE_M, y + 0.08]])
    return [
        Mark("line", "scale", bar),
        Mark("text", "note", np.array([[x + _SCALE_M + 0.15, y + 0.06]]), text=f"{_SCALE_M:g} m", size=letter_m),
    ]
