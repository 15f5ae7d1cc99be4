"""`place_openings`: from which rooms are joined to where in their wall, how wide, and which way the doors swing."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from numpy.random import Generator, default_rng

from worlds.errors import WorldsError
from worlds.floor_plans.layout import Link, StoreyLayout
from worlds.openings.door_swings import hang_leaf
from worlds.openings.opening_draft import OpeningDraft, shared_walls
from worlds.spec import PASSABLE, OpeningKind, OpeningSpec
from worlds.walls import Boundary

CORNER_M = 0.15
APART_M = 0.1
MIN_DOOR_M = 0.7
MIN_OPEN_M = 0.8
"""Of a wall taken away; other walls reach into the gap at corners."""
_MIN_LOOK_M = 0.4
_WIDTHS_M: dict[OpeningKind, tuple[float, float]] = {
    "door": (0.8, 1.0), "cased": (1.1, 2.0), "arch": (1.1, 2.0), "half wall": (1.0, 3.0), "counter": (1.0, 2.2),
}  # fmt: skip
_DOORLESS = 0.06
"""Share of door ways without a leaf."""
_DRAWS = 7

Span = tuple[Boundary, float, float]
"""A free part of a shared wall, from where to where [m]."""


def place_openings(layout: StoreyLayout, rng: Generator) -> tuple[OpeningSpec, ...]:
    """All openings of a storey: those that the layout has already, then those of its links in their order.

    On the centimetre grid, clear of corners and of each other. A wall too short for the kind asked for gets a door. Every
    link has draws of its own. Raises `WorldsError`, naming the rooms, where not even a door fits.
    """
    rooms = {room.id: room for room in layout.rooms}
    gaps = [OpeningDraft.of(opening, rooms) for opening in layout.openings]
    draws = rng.random((len(layout.links), _DRAWS)).tolist()
    for i, link in enumerate(layout.links):
        if link.seed is not None:
            draws[i] = default_rng(link.seed).random(_DRAWS).tolist()
    walkable_pairs = {frozenset(link.rooms) for link in layout.links if link.kind in PASSABLE}
    placed: dict[int, list[OpeningDraft]] = {}
    # What one walks through has the first choice of the wall.
    for i in sorted(range(len(layout.links)), key=lambda k: layout.links[k].kind not in PASSABLE):
        link = layout.links[i]
        walls = shared_walls(rooms[link.rooms[0]], rooms[link.rooms[1]])
        alone = link.kind not in PASSABLE and frozenset(link.rooms) not in walkable_pairs
        placed[i] = _place(link, alone, walls, gaps, layout.height_m, draws[i])
        gaps += placed[i]
    first = len(layout.openings)
    gaps = gaps[:first] + [gap for i in range(len(layout.links)) for gap in placed[i]]
    owner = [i for i in range(len(layout.links)) for _ in placed[i]]
    for k, i in enumerate(owner, start=first):
        if gaps[k].kind == "door" and draws[i][4] >= _DOORLESS:
            gaps[k] = replace(gaps[k], leaf=hang_leaf(gaps[k], gaps, rooms, (draws[i][5], draws[i][6])))
    return (*layout.openings, *(gap.spec() for gap in gaps[first:]))


def _place(
    link: Link, alone: bool, walls: Sequence[Boundary], gaps: Sequence[OpeningDraft], storey_m: float, draws: Sequence[float]
) -> list[OpeningDraft]:
    """The gaps of one link; `alone`: there is no way yet between the rooms and this kind is none."""
    if link.kind == "open":
        wide = [span for span in free_spans(walls, gaps, 0.0, 0.0) if span[2] - span[1] >= MIN_OPEN_M]
        if not wide:
            raise _too_short(link, walls)
        return [make_gap("open", span, span[1], span[2], storey_m) for span in wide]
    spans = free_spans(walls, gaps)
    if link.kind in PASSABLE:
        return [_somewhere(link, walls, spans, storey_m, draws)]
    way_in = Link(link.rooms, "cased" if draws[4] < 0.5 else "door")
    found = [_somewhere(way_in, walls, spans, storey_m, draws)] if alone else []
    beside = free_spans(walls, [*gaps, *found])
    room_for = max((high - low for _, low, high in beside), default=0.0)
    if room_for >= _MIN_LOOK_M:
        found.append(_fit(link.kind, beside, room_for, storey_m, draws))
    elif not found:
        raise _too_short(link, walls)
    return found


def _somewhere(
    link: Link, walls: Sequence[Boundary], spans: Sequence[Span], storey_m: float, draws: Sequence[float]
) -> OpeningDraft:
    """A passable gap of the link's kind if it fits, of a door otherwise."""
    longest = max((high - low for _, low, high in spans), default=0.0) + 1e-9
    kind: OpeningKind = link.kind if longest >= _WIDTHS_M[link.kind][0] else "door"
    if longest < MIN_DOOR_M:
        raise _too_short(link, walls)
    return _fit(kind, spans, longest, storey_m, draws)


def _fit(kind: OpeningKind, spans: Sequence[Span], longest: float, storey_m: float, draws: Sequence[float]) -> OpeningDraft:
    """A gap as wide as drawn and as fits, more often near a corner than not."""
    least, most = _WIDTHS_M[kind]
    width = min(round(least + draws[0] * (most - least), 2), math.floor(longest * 100 + 1e-6) / 100)
    fitting = [span for span in spans if span[2] - span[1] >= width - 1e-9]
    span = _by_length(fitting, draws[1])
    slack = max(0.0, span[2] - span[1] - width)
    # Doors stand in corners: their leaves then open against a wall, and the room keeps its longest stretch of wall.
    shift = draws[2] * slack if kind != "door" or draws[3] < 0.3 else min(slack, 0.15 * draws[2])
    start = span[1] + shift if draws[3] < 0.65 else span[1] + slack - shift
    low = min(math.ceil(round(start, 6) * 100 - 1e-6), math.floor(round(span[2] - width, 6) * 100 + 1e-6)) / 100
    low = max(low, round(span[1], 6))
    return make_gap(kind, span, low, round(low + width, 6), storey_m)


def _by_length(spans: Sequence[Span], share: float) -> Span:
    left = share * sum(high - low for _, low, high in spans)
    for span in spans:
        left -= span[2] - span[1]
        if left <= 0.0:
            return span
    return spans[-1]


def make_gap(kind: OpeningKind, span: Span, low: float, high: float, storey_m: float) -> OpeningDraft:
    """A gap in a wall with the usual heights of its kind, in a storey that is `storey_m` high."""
    wall = span[0]
    crown = {"arch": 2.3, "cased": 2.1}.get(kind, 2.05)
    rooms = (str(wall.rooms[0]), str(wall.rooms[1]))
    return OpeningDraft(rooms, kind, wall.axis, wall.at, low, high, min(crown, round(storey_m - 0.05, 3)))


def free_spans(
    walls: Iterable[Boundary], gaps: Sequence[OpeningDraft], corner_m: float = CORNER_M, apart_m: float = APART_M
) -> list[Span]:
    """What is left of walls between corners and gaps, keeping the given distances [m] from both."""
    spans: list[Span] = []
    for wall in walls:
        start, stop = wall.low + corner_m, wall.high - corner_m
        taken = sorted((g.low, g.high) for g in gaps if (g.axis, g.at) == (wall.axis, wall.at))
        for low, high in taken:
            if high + apart_m <= start or low - apart_m >= stop:
                continue
            if low - apart_m > start:
                spans.append((wall, start, low - apart_m))
            start = max(start, high + apart_m)
        if stop > start:
            spans.append((wall, start, stop))
    return spans


def _too_short(link: Link, walls: Sequence[Boundary]) -> WorldsError:
    lengths = " + ".join(f"{wall.length:.2f}" for wall in walls) or "0"
    return WorldsError(
        f"no place for a {link.kind!r} between {link.rooms[0]!r} and {link.rooms[1]!r}: they share {lengths} m of wall; "
        f"a door needs {MIN_DOOR_M + 2 * CORNER_M:.2f} m in a row, clear of other openings"
    )
