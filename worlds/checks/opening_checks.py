"""Checks of openings and windows: they lie in the right walls, do not overlap, and let a body through."""

from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations

from worlds.house import House
from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.openings.windows import Window
from worlds.spec import PASSABLE, OpeningSpec
from worlds.walls import opening_span, segment_span

MIN_OPENING_WIDTH_M = 0.6
"""Least width of an opening that a body with a radius of 0.25 m can walk through [m]."""
MIN_OPENING_HEIGHT_M = 1.9
MIN_SILL_M = 0.3
"""Least sill of a half wall or counter [m]. A lower one could be stepped over."""
_TOLERANCE_M = 1e-3

Segment = tuple[int, float, float, float]
"""A line segment along x or y: its axis (0: x, 1: y), its coordinate on the other axis [m], and the smaller and the larger
coordinate of its ends on its own axis [m]."""


def opening_problems(house: House) -> Iterator[str]:
    """Yield a message for every rule that an opening or window breaks.

    Openings are named by their place in the spec, and windows by their id.
    """
    for level, storey in enumerate(house.spec.storeys):
        windows = [window for window in house.windows if window.storey == level]
        spans = [(f"openings[{i}]", opening_span(opening)) for i, opening in enumerate(storey.openings)]
        spans += [(window.id, span) for window in windows if (span := segment_span(window.start, window.end)) is not None]
        yield from _overlapping(level, spans)
        in_wall: dict[int, float] = defaultdict(float)
        for boundary, opening in house.boundaries[level]:
            if opening is not None and set(boundary.rooms) == set(opening.rooms):
                in_wall[id(opening)] += boundary.length
        for i, opening in enumerate(storey.openings):
            place = f"storeys[{level}].openings[{i}] ({opening.rooms[0]} - {opening.rooms[1]})"
            yield from _bad_opening(place, opening, in_wall[id(opening)], storey.height_m)
            if opening.leads is not None and not any(house.room_by_id[room].label == STAIRS for room in opening.rooms):
                yield f'{place}: "leads" says {opening.leads!r}, but neither room is stairs; leave it out'
        for window in windows:
            yield from _bad_window(house, window)


def _overlapping(level: int, spans: list[tuple[str, Segment]]) -> Iterator[str]:
    lines: dict[tuple[int, float], list[tuple[float, float, str]]] = defaultdict(list)
    for name, (axis, at, low, high) in spans:
        lines[axis, at].append((low, high, name))
    for line in lines.values():
        for (low, high, a), (start, stop, b) in combinations(line, 2):
            if min(high, stop) - max(low, start) > _TOLERANCE_M:
                yield f"storeys[{level}]: {a} and {b} overlap; openings and windows may only touch"


def _bad_opening(place: str, opening: OpeningSpec, in_wall_m: float, height_m: float) -> Iterator[str]:
    if opening.rooms[0] == opening.rooms[1]:
        yield f"{place}: both rooms are {opening.rooms[0]!r}; valid: two different rooms"
    elif in_wall_m < opening.width_m - _TOLERANCE_M:
        yield f"{place}: only {in_wall_m:.2f} of its {opening.width_m:.2f} m lie in the wall between the two rooms"
    low, high = opening.gap_m(height_m)
    if opening.kind not in PASSABLE:
        if not MIN_SILL_M - _TOLERANCE_M <= low < high <= height_m:
            span = f"{MIN_SILL_M} ... {height_m:.2f} m, up to the ceiling"
            yield f"{place}: open from {low:.2f} to {high:.2f} m; valid: a part of {span}"
        return
    if opening.width_m < MIN_OPENING_WIDTH_M - _TOLERANCE_M:
        yield f"{place}: {opening.width_m:.2f} m wide; a body needs at least {MIN_OPENING_WIDTH_M:.2f} m"
    if opening.kind != "open" and not MIN_OPENING_HEIGHT_M <= high <= height_m:
        yield f"{place}: {high:.2f} m high; valid: {MIN_OPENING_HEIGHT_M} ... {height_m:.2f} m"


def _bad_window(house: House, window: Window) -> Iterator[str]:
    if house.room_by_id[window.room].label in OUTDOOR_LABELS:
        yield f"{window.id} ({window.room}): is in a fence; valid: windows of indoor rooms"
        return
    storey = house.storeys[window.storey]
    bottom, top = window.position[2] - storey.floor_m, window.position[2] + window.size[2] - storey.floor_m
    if top > (height_m := storey.ceiling_m - storey.floor_m) + _TOLERANCE_M:
        yield f"{window.id} ({window.room}): from {bottom:.2f} to {top:.2f} m; valid: up to the ceiling ({height_m:.2f} m)"
