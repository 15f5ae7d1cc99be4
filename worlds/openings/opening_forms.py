"""Forms in which a partition (the wall between two rooms) can be opened by a given area.

A form is a function that takes a `Task` (a partition and the area to open) and returns openings: a removed part of the wall,
an arch, a half wall, or a hatch (an opening above a sill) beside the door. Each form covers only some range of areas, so
`open_by` tries several.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from worlds.arches import spandrel_area
from worlds.openings.opening_draft import OpeningDraft
from worlds.openings.partitions import Partition, gap_area
from worlds.openings.placement import CORNER_M, MIN_DOOR_M, MIN_OPEN_M, FreeSpan, free_spans, make_opening
from worlds.spec import PASSABLE, OpeningKind
from worlds.walls import Boundary

_MIN_STRETCH_M = 0.6
"""Least length of a stretch of wall that is removed [m], because a body could not walk through a shorter opening."""
_MIN_HATCH_M = 0.2
"""Least width of a hatch [m]."""
_MAX_FRAMED_M = 2.6
"""Greatest width of an arch or a cased opening [m]."""
_HATCH_CORNER_M = 0.05
"""Distance of a hatch from the ends of its wall [m]."""
_DOOR_CORNER_M = 0.1
"""Distance between a corner and a door that is moved there to make space for a hatch [m], so that the leaf can swing."""
_LOW_SILL_M = 0.3
"""Height of the sill of a low hatch [m], which opens more of the wall than a usual hatch."""
_EXACT_M2 = 0.03
"""Greatest difference from the requested area at which a form of opening is accepted without trying other forms [m²]."""
_DOOR_M = 0.85
"""Usual width of a door [m]."""


@dataclass(frozen=True)
class Task:
    """A partition (the wall between two rooms), and the area by which it is to be opened."""

    part: Partition
    old: tuple[OpeningDraft, ...]
    """The openings that the partition had before."""
    area: float
    """Area that the new openings should have [m²]."""
    draw: float
    """Number in [0, 1) that decides where along the wall an opening lies."""
    blocked: tuple[OpeningDraft, ...] = ()
    """Stretches of wall with furniture in front of them; a new door is placed elsewhere if possible."""

    @property
    def main(self) -> Boundary:
        """The longest straight stretch of the partition (the wall between two rooms)."""
        return max(self.part.walls, key=lambda wall: wall.length)


Gaps = tuple[OpeningDraft, ...]


def open_by(task: Task, style: str) -> Gaps:
    """Return openings with the area that the task requests, or as near to this area as possible.

    A form is a way of opening the wall, such as an arch. The form named `style` is tried first, then all other forms in the
    order of `FORMS`. The first form with the right area (within 0.03 m²) is taken. If no form has the right area, the form
    with the nearest area is taken, or the partition is closed if an area of 0 is nearer.
    """
    best, least = closed(task), math.inf
    for name in (style, *(name for name in FORMS if name != style)):
        gaps = FORMS[name](task)
        if gaps is None:
            continue
        off = abs(area_of(gaps, task.part) - task.area)
        if off <= _EXACT_M2:
            return gaps
        if off < least:
            best, least = gaps, off
    return closed(task) if task.area < least else best


def area_of(gaps: Sequence[OpeningDraft], part: Partition) -> float:
    """Return the area by which openings permanently open a partition (the wall between two rooms); doors count as 0 [m²]."""
    return math.fsum(gap_area(gap.spec(), part.height_m) for gap in gaps)


def fully_open(task: Task) -> Gaps:
    """Remove the wall on every stretch that is long enough to walk through."""
    return tuple(_open_gap(task, wall, wall.low, wall.high) for wall in task.part.walls if wall.length >= _MIN_STRETCH_M)


def closed(task: Task) -> Gaps:
    """Close the partition. If a person could walk through it before, it gets a door, so that the rooms stay connected.

    Existing doors stay. If there are none, a door is placed in the longest free span of wall, if possible not where
    furniture stands. If no span is long enough, the door takes the place of the widest opening that one could walk through.
    """
    doors = tuple(gap for gap in task.old if gap.kind == "door")
    ways = [gap for gap in task.old if gap.kind in PASSABLE]
    if doors or not ways:
        return doors
    for spans in (free_spans(task.part.walls, task.blocked), free_spans(task.part.walls, ())):
        span = max(spans, key=lambda span: span.length, default=None)
        if span is not None and span.length >= MIN_DOOR_M:
            return (_in_span("door", task, span, min(_DOOR_M, span.length)),)
    widest = max(ways, key=lambda gap: gap.width)
    margin = min(_DOOR_CORNER_M, max(0.0, (widest.width - MIN_DOOR_M) / 2))
    low, high = round(widest.low + margin, 6), round(widest.high - margin, 6)
    return (replace(widest, kind="door", low=low, high=round(min(high, low + _DOOR_M), 6), height=_height("door", task)),)


def _wall_removed(task: Task) -> Gaps:
    """Remove a part of the wall, from floor to ceiling.

    The longest straight stretch is removed first, beginning at one of its ends; further stretches follow if that is not
    enough. Stretches too short to walk through stay.
    """
    left = task.area / task.part.height_m
    gaps: list[OpeningDraft] = []
    for wall in sorted(task.part.walls, key=lambda wall: -wall.length):
        if wall.length < _MIN_STRETCH_M or (gaps and left < MIN_OPEN_M):
            break
        width = min(wall.length, max(MIN_OPEN_M, round(left, 2)))
        low = wall.low if task.draw < 0.5 else round(wall.high - width, 6)
        gaps.append(_open_gap(task, wall, low, round(low + width, 6)))
        left -= width
    return tuple(gaps)


def _framed(kind: OpeningKind) -> Callable[[Task], Gaps | None]:
    def form(task: Task) -> Gaps | None:
        """Return a wide opening under a lintel or an arch, in the longest straight stretch; None if it is too short."""
        span = FreeSpan(task.main, task.main.low + CORNER_M, task.main.high - CORNER_M)
        most, least = min(_MAX_FRAMED_M, span.length), 1.0 if kind == "arch" else MIN_DOOR_M
        if most < least:
            return None
        height = _height(kind, task)
        # Area that an arch lacks of its bounding rectangle, per metre of width: from 0.8 m on, the curves of all arches are
        # equally high, so this area is proportional to the width.
        rise = spandrel_area(1.0) if kind == "arch" else 0.0
        return (_in_span(kind, task, span, min(max(task.area / (height - rise), least), most)),)

    return form


def _half_wall(task: Task) -> Gaps | None:
    """Return a passage from floor to ceiling at one end of the longest straight stretch, and a half wall beside the passage.

    The result is None if the stretch is too short for both.
    """
    wall, height = task.main, task.part.height_m
    passage, sill = 0.9, 1.0
    most = wall.length - passage
    if most < _MIN_HATCH_M:
        return None
    width = round(min(max((task.area - passage * height) / (height - sill), _MIN_HATCH_M), most), 6)
    cuts = [wall.low, wall.low + passage, wall.low + passage + width]
    if task.draw >= 0.5:
        cuts = [wall.high, wall.high - passage, wall.high - passage - width]
    (a, b, c) = (round(cut, 6) for cut in cuts)
    return (
        _open_gap(task, wall, min(a, b), max(a, b)),
        make_opening("half wall", wall, min(b, c), max(b, c), height),
    )


def _hatch(kind: OpeningKind, sill: float, narrow_door: bool = False) -> Callable[[Task], Gaps | None]:
    def form(task: Task) -> Gaps | None:
        """Return the doors that `closed` keeps or places, and a hatch beside them that is as wide as the area requires.

        With `narrow_door`, the door first moves to a corner. The result is None if there is no room for a hatch.
        """
        doors = closed(task)
        if narrow_door and doors:
            start = task.main.low + _DOOR_CORNER_M
            ends = round(start, 6), round(start + MIN_DOOR_M, 6)
            doors = (make_opening("door", task.main, *ends, task.part.height_m),)
        spans = free_spans(task.part.walls, doors, _HATCH_CORNER_M)
        span = max(spans, key=lambda span: span.length, default=FreeSpan(task.main, 0.0, 0.0))
        if span.length < _MIN_HATCH_M or (doors and doors[-1].high > span.wall.high):
            return None
        # The area of a hatch is proportional to its width, so a hatch of 1 m gives the area per metre.
        hatch = replace(make_opening(kind, span.wall, 0.0, 1.0, task.part.height_m), sill=sill)
        width = task.area / area_of([hatch], task.part)
        placed = _in_span(kind, task, span, min(max(width, _MIN_HATCH_M), span.length))
        return (*doors, replace(placed, sill=sill))

    return form


def _open_gap(task: Task, wall: Boundary, low: float, high: float) -> OpeningDraft:
    return make_opening("open", wall, low, high, task.part.height_m)


def _height(kind: OpeningKind, task: Task) -> float:
    return make_opening(kind, task.main, 0.0, 0.0, task.part.height_m).height


def _in_span(kind: OpeningKind, task: Task, span: FreeSpan, width: float) -> OpeningDraft:
    """Return an opening of this width [m] in a free span of wall, at the position that `task.draw` gives.

    Width and position are rounded to 1 cm where possible. The opening must not reach past the ends of the span, which are
    not always whole centimetres.
    """
    start, stop = round(span.low, 6), round(span.high, 6)
    width = min(round(width, 2), round(stop - start, 6))
    low = min(round(start + task.draw * (stop - start - width), 2), round(stop - width, 6))
    low = max(low, start)
    return make_opening(kind, span.wall, low, round(low + width, 6), task.part.height_m)


FORMS: dict[str, Callable[[Task], Gaps | None]] = {
    "open": _wall_removed,
    "arch": _framed("arch"),
    "cased": _framed("cased"),
    "half wall": _half_wall,
    "counter": _hatch("counter", 1.0),
    "hatch": _hatch("half wall", 1.0),
    "low hatch": _hatch("half wall", _LOW_SILL_M),
    "narrow": _hatch("counter", 1.0, narrow_door=True),
    "narrow and low": _hatch("half wall", _LOW_SILL_M, narrow_door=True),
}
"""All forms of opening a partition, by name; the forms that people build most often come first."""
STYLES = {"open": (0.5, 0.85), "arch": (0.2, 0.5), "cased": (0.2, 0.5), "half wall": (0.5, 0.75), "counter": (0.1, 0.3)}
"""Forms of openings, by name. For each partition, one form is drawn at random and tried before the others. The form opens a
share of the partition's area, which is drawn from the range (low, high)."""
