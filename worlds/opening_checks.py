"""What is wrong with the openings and windows of a house."""

from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations

from worlds.house import House
from worlds.labels import OUTDOOR_LABELS
from worlds.spec import PASSABLE, OpeningSpec, WindowSpec
from worlds.walls import opening_span

MIN_WIDTH_M = 0.6
"""Of what a body of radius 0.25 m walks through."""
MIN_HEIGHT_M = 1.9
_TOLERANCE_M = 1e-3

Span = tuple[int, float, float, float]


def opening_problems(house: House) -> Iterator[str]:
    """Rules about openings and windows, storey by storey, each with its place in the spec."""
    for level, storey in enumerate(house.spec.storeys):
        windows = storey.windows or ()
        spans = [(f"openings[{i}]", opening_span(opening)) for i, opening in enumerate(storey.openings)]
        spans += [(f"windows[{i}]", _window_span(window)) for i, window in enumerate(windows)]
        yield from _not_apart(level, spans)
        in_wall: dict[int, float] = defaultdict(float)
        for boundary, opening in house.boundaries[level]:
            if opening is not None and set(boundary.rooms) == set(opening.rooms):
                in_wall[id(opening)] += boundary.length
        for i, opening in enumerate(storey.openings):
            place = f"storeys[{level}].openings[{i}] ({opening.rooms[0]} - {opening.rooms[1]})"
            yield from _bad_opening(place, opening, in_wall[id(opening)], storey.height_m)
        for i, window in enumerate(windows):
            yield from _bad_window(house, level, f"storeys[{level}].windows[{i}] ({window.room})", window)


def _not_apart(level: int, spans: list[tuple[str, Span]]) -> Iterator[str]:
    lines: dict[tuple[int, float], list[tuple[float, float, str]]] = defaultdict(list)
    for name, (axis, at, low, high) in spans:
        lines[axis, at].append((low, high, name))
    for line in lines.values():
        for (low, high, a), (start, stop, b) in combinations(line, 2):
            if min(high, stop) - max(low, start) > _TOLERANCE_M:
                yield f"storeys[{level}]: {a} and {b} overlap; openings and windows may only touch"


def _bad_opening(place: str, opening: OpeningSpec, in_wall_m: float, height_m: float) -> Iterator[str]:
    if in_wall_m < opening.width_m - _TOLERANCE_M:
        yield f"{place}: only {in_wall_m:.2f} of its {opening.width_m:.2f} m lie in the wall between the two rooms"
    low, high = opening.gap_m(height_m)
    if opening.kind not in PASSABLE:
        if not low < high <= height_m:
            yield f"{place}: open from {low:.2f} to {high:.2f} m; valid: a part of 0 ... {height_m:.2f} m, floor to ceiling"
        return
    if opening.width_m < MIN_WIDTH_M - _TOLERANCE_M:
        yield f"{place}: {opening.width_m:.2f} m wide; a body needs at least {MIN_WIDTH_M:.2f} m"
    if opening.kind != "open" and not MIN_HEIGHT_M <= high <= height_m:
        yield f"{place}: {high:.2f} m high; valid: {MIN_HEIGHT_M} ... {height_m:.2f} m"


def _bad_window(house: House, level: int, place: str, window: WindowSpec) -> Iterator[str]:
    height_m = house.spec.storeys[level].height_m
    if not window.sill_m < window.height_m <= height_m:
        yield f"{place}: from {window.sill_m:.2f} to {window.height_m:.2f} m; valid: rising, up to {height_m:.2f} m"
    axis, at, low, high = _window_span(window)
    outside = sum(
        max(0.0, min(high, boundary.high) - max(low, boundary.low))
        for boundary, _ in house.boundaries[level]
        if (boundary.axis, boundary.at) == (axis, at) and _leads_outside(house, window.room, boundary.rooms)
    )
    if outside < high - low - _TOLERANCE_M:
        yield f"{place}: only {outside:.2f} of its {high - low:.2f} m lie in a wall between the room and the outside"


def _leads_outside(house: House, room: str, sides: tuple[str | None, str | None]) -> bool:
    if room not in sides:
        return False
    other = sides[0] if sides[1] == room else sides[1]
    return other is None or house.room_by_id[other].label in OUTDOOR_LABELS


def _window_span(window: WindowSpec) -> Span:
    return opening_span(
        OpeningSpec.model_construct(rooms=(window.room, "the outside"), start_m=window.start_m, end_m=window.end_m)
    )
