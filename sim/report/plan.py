"""The plan of a storey as a drawing: rooms in the colour of their label, walls, openings, furniture, names, a scale."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float64
from shapely.geometry import LineString, Polygon
from shapely.ops import polylabel

from sim.errors import SimError
from sim.report.data import FloorPlan, PlannedRoom
from sim.report.drawing import Drawing, Mark

_MARGIN_M = 0.5
_SCALE_M = 2.0
_OPENINGS = {"door": "door way", "cased": "cased opening", "open": "open boundary, no wall"}
_GLYPH_ASPECT = 0.58  # width over height of an average letter


def plan_drawing(plan: FloorPlan, colours: Mapping[str, str]) -> Drawing:
    """Draw a storey; `colours` is by room label. Raises `SimError` where the storey has no rooms."""
    if not plan.rooms:
        raise SimError(f"plan of storey {plan.level}: it has no rooms; at least one is needed")
    corners = np.concatenate([room.outline for room in plan.rooms])
    low, high = corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M
    low[1] -= 0.55  # for the scale
    marks = [
        *(Mark("polygon", "room", r.outline, colours[r.label], f"{r.name} ({r.label})") for r in plan.rooms),
        *(Mark("polygon", "tread", outline) for outline in plan.treads),
        *(Mark("polygon", "furniture", outline) for outline in plan.furniture),
        *(Mark("polygon", "fence", outline) for outline in plan.fences),
        *(Mark("polygon", "wall", outline) for outline in plan.walls),
        *(Mark("line", o.kind, o.ends, text=_OPENINGS[o.kind]) for o in plan.openings),
        *(mark for room in plan.rooms for mark in _name(room)),
        *_scale(low),
    ]
    return Drawing(marks, low, high, title=f"storey {plan.level}, floor at {plan.floor_m:.2f} m")


def _name(room: PlannedRoom) -> list[Mark]:
    """The name, as large as fits, on one line or on two."""
    place, width, height = _clear_place(room.outline)
    text = room.name if room.label in room.name else f"{room.name} ({room.label})"
    size, lines = max((_fitting_size(lines, width, height), lines) for lines in _layouts(text))
    drops = size * 1.15 * (np.arange(len(lines)) - (len(lines) - 1) / 2)
    places = place - np.outer(drops, [0, 1])
    return [Mark("text", "name", at[None], text=line, size=size) for at, line in zip(places, lines, strict=True)]


def _layouts(text: str) -> list[tuple[str, ...]]:
    words = text.split(" ")
    return [(text,), *((" ".join(words[:i]), " ".join(words[i:])) for i in range(1, len(words)))]


def _fitting_size(lines: tuple[str, ...], width: float, height: float) -> float:
    longest = max(map(len, lines))
    return float(np.clip(min(0.9 * width / (_GLYPH_ASPECT * longest), 0.8 * height / (1.15 * len(lines))), 0.14, 0.34))


def _clear_place(outline: Float64[np.ndarray, "corners 2"]) -> tuple[Float64[np.ndarray, "2"], float, float]:
    """A point well inside the polygon and the extents of the polygon through it [m]."""
    polygon = Polygon(outline)
    point = polylabel(polygon, tolerance=0.1)
    x0, y0, x1, y1 = polygon.bounds
    across = _chord(polygon, LineString([(x0 - 1, point.y), (x1 + 1, point.y)]), point.x, 0)
    along = _chord(polygon, LineString([(point.x, y0 - 1), (point.x, y1 + 1)]), point.y, 1)
    return np.array([np.mean(across), np.mean(along)]), across[1] - across[0], along[1] - along[0]


def _chord(polygon: Polygon, line: LineString, at: float, axis: int) -> tuple[float, float]:
    """The stretch of `line` inside `polygon` that holds coordinate `at`."""
    cut = polygon.intersection(line)
    pieces = [piece.bounds[axis::2] for piece in getattr(cut, "geoms", [cut])]
    low, high = min(pieces, key=lambda piece: max(piece[0] - at, at - piece[1]))
    return low, high


def _scale(low: Float64[np.ndarray, "2"]) -> list[Mark]:
    x, y = low + 0.5
    bar = np.array([[x, y + 0.08], [x, y], [x + _SCALE_M, y], [x + _SCALE_M, y + 0.08]])
    return [
        Mark("line", "scale", bar),
        Mark("text", "name", np.array([[x + _SCALE_M / 2, y - 0.22]]), text=f"{_SCALE_M:g} m", size=0.24),
    ]
