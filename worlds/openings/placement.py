"""`place_openings`: turns links (requests to connect two rooms) into openings with a position, a width and a door leaf."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from numpy.random import Generator, default_rng

from worlds.errors import WorldsError
from worlds.layout import Link, StoreyLayout
from worlds.openings.door_swings import hang_leaf
from worlds.openings.opening_draft import OpeningDraft, shared_walls
from worlds.spec import PASSABLE, OpeningKind, OpeningSpec
from worlds.walls import Boundary

CORNER_M = 0.15
"""Least distance of an opening from the ends of its wall [m]."""
APART_M = 0.1
"""Least distance between two openings [m]."""
MIN_DOOR_M = 0.7
"""Least width of a door [m]."""
MIN_OPEN_M = 0.8
"""Least length of a stretch of wall that is removed [m]. The opening is a little narrower, because walls at a right angle
may reach into it at both ends."""
_MIN_LOOK_THROUGH_M = 0.4
"""Least width of a half wall or counter [m], which one can only look over."""
_WIDTHS_M: dict[OpeningKind, tuple[float, float]] = {
    "door": (0.8, 1.0), "cased": (1.1, 2.0), "arch": (1.1, 2.0), "half wall": (1.0, 3.0), "counter": (1.0, 2.2),
}  # fmt: skip
"""Range from which the width of an opening is drawn, by kind [m]."""
_DOORLESS = 0.06
"""Share of doorways without a leaf."""
_DRAWS = 7
"""Number of random numbers that each link uses."""


class FreeSpan(NamedTuple):
    """A stretch of a wall between two rooms without an opening."""

    wall: Boundary
    low: float
    """Lower end of the stretch along the wall [m]."""
    high: float
    """Upper end of the stretch along the wall [m]."""

    @property
    def length(self) -> float:
        """Length of the stretch [m]."""
        return self.high - self.low


def place_openings(layout: StoreyLayout, rng: Generator) -> tuple[OpeningSpec, ...]:
    """Return all openings of a storey: first the openings given by the layout, then the openings for its links.

    A link is a request to connect two rooms. The openings for the links are in the order of the links.

    1. Each link gets `_DRAWS` random numbers, all drawn in advance, so that no link changes the numbers of another. Links of
       twin rooms share a seed, so they get the same numbers.
    2. Openings that one can walk through are placed first, because they must fit; half walls and counters take what is left.
       Openings lie on the centimetre grid, clear of corners and of each other. A wall too short for the requested kind gets
       a door.
    3. Door leaves are hung when all openings have a position, since a leaf must not block an opening.

    Raises `WorldsError`, naming the rooms, where not even a door fits.
    """
    rooms = {room.id: room for room in layout.rooms}
    gaps = [OpeningDraft.of(opening, rooms) for opening in layout.openings]
    draws = rng.random((len(layout.links), _DRAWS)).tolist()
    for i, link in enumerate(layout.links):
        if link.seed is not None:
            draws[i] = default_rng(link.seed).random(_DRAWS).tolist()
    walkable_pairs = {frozenset(link.rooms) for link in layout.links if link.kind in PASSABLE}
    placed: dict[int, list[OpeningDraft]] = {}
    # False sorts before True: links that one can walk through come first.
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
    """Return the openings for one link (a request to connect two rooms).

    `alone` says that the requested kind is a half wall or a counter, which one cannot walk through, and that no other link
    lets people walk between the two rooms. A door or a cased opening is then placed first. Raises `WorldsError` if no
    opening fits.
    """
    if link.kind == "open":
        wide = [span for span in free_spans(walls, gaps, 0.0, 0.0) if span.length >= MIN_OPEN_M]
        if not wide:
            raise _too_short(link, walls)
        return [make_opening("open", span.wall, span.low, span.high, storey_m) for span in wide]
    spans = free_spans(walls, gaps)
    if link.kind in PASSABLE:
        return [_place_passable(link, walls, spans, storey_m, draws)]
    way_in = Link(link.rooms, "cased" if draws[4] < 0.5 else "door")
    found = [_place_passable(way_in, walls, spans, storey_m, draws)] if alone else []
    beside = free_spans(walls, [*gaps, *found])
    room_for = max((span.length for span in beside), default=0.0)
    if room_for >= _MIN_LOOK_THROUGH_M:
        found.append(_fit(link.kind, beside, room_for, storey_m, draws))
    elif not found:
        raise _too_short(link, walls)
    return found


def _place_passable(
    link: Link, walls: Sequence[Boundary], spans: Sequence[FreeSpan], storey_m: float, draws: Sequence[float]
) -> OpeningDraft:
    """Return an opening of the link's kind if it fits into one of `spans`, otherwise a door.

    Raises `WorldsError` if no door fits either.
    """
    longest = max((span.length for span in spans), default=0.0) + 1e-9
    kind: OpeningKind = link.kind if longest >= _WIDTHS_M[link.kind][0] else "door"
    if longest < MIN_DOOR_M:
        raise _too_short(link, walls)
    return _fit(kind, spans, longest, storey_m, draws)


def _fit(
    kind: OpeningKind, spans: Sequence[FreeSpan], longest: float, storey_m: float, draws: Sequence[float]
) -> OpeningDraft:
    """Return an opening in one of `spans`, at a random position and with a width drawn for its kind.

    The opening is narrower if even the longest span, whose length is `longest` [m], is too short for the drawn width. A door
    mostly lies near an end of its span.
    """
    least, most = _WIDTHS_M[kind]
    width = min(round(least + draws[0] * (most - least), 2), math.floor(longest * 100 + 1e-6) / 100)
    fitting = [span for span in spans if span.length >= width - 1e-9]
    span = _by_length(fitting, draws[1])
    slack = max(0.0, span.length - width)
    # Doors are placed near corners: their leaves then open against a wall, and the room keeps its longest stretch of wall.
    shift = draws[2] * slack if kind != "door" or draws[3] < 0.3 else min(slack, 0.15 * draws[2])
    start = span.low + shift if draws[3] < 0.65 else span.low + slack - shift
    # Round up to the centimetre grid, but not past the last grid point at which the opening fits into the span.
    low = min(math.ceil(round(start, 6) * 100 - 1e-6), math.floor(round(span.high - width, 6) * 100 + 1e-6)) / 100
    low = max(low, round(span.low, 6))
    return make_opening(kind, span.wall, low, round(low + width, 6), storey_m)


def _by_length(spans: Sequence[FreeSpan], share: float) -> FreeSpan:
    """Return the span that contains a given point of all spans, if the spans are laid end to end.

    `share` in [0, 1) is the position of the point as a share of the total length. With a random share, each span is chosen
    in proportion to its length.
    """
    left = share * sum(span.length for span in spans)
    for span in spans:
        left -= span.length
        if left <= 0.0:
            return span
    return spans[-1]


def make_opening(kind: OpeningKind, wall: Boundary, low: float, high: float, storey_m: float) -> OpeningDraft:
    """Return an opening in a wall, with the usual height of its kind.

    `low` and `high` are the coordinates of the opening's ends along the wall [m]. The ceiling is `storey_m` above the floor
    [m], and the upper edge of the opening stays at least 5 cm below the ceiling.
    """
    crown = {"arch": 2.3, "cased": 2.1}.get(kind, 2.05)
    rooms = (str(wall.rooms[0]), str(wall.rooms[1]))
    return OpeningDraft(rooms, kind, wall.axis, wall.at, low, high, min(crown, round(storey_m - 0.05, 3)))


def free_spans(
    walls: Iterable[Boundary], gaps: Sequence[OpeningDraft], corner_m: float = CORNER_M, apart_m: float = APART_M
) -> list[FreeSpan]:
    """Return the free parts of walls, at least `corner_m` from the walls' ends and `apart_m` from all `gaps` [m]."""
    spans: list[FreeSpan] = []
    for wall in walls:
        start, stop = wall.low + corner_m, wall.high - corner_m
        taken = sorted((g.low, g.high) for g in gaps if (g.axis, g.at) == (wall.axis, wall.at))
        for low, high in taken:
            if high + apart_m <= start or low - apart_m >= stop:
                continue
            if low - apart_m > start:
                spans.append(FreeSpan(wall, start, low - apart_m))
            start = max(start, high + apart_m)
        if stop > start:
            spans.append(FreeSpan(wall, start, stop))
    return spans


def _too_short(link: Link, walls: Sequence[Boundary]) -> WorldsError:
    lengths = " + ".join(f"{wall.length:.2f}" for wall in walls) or "0"
    return WorldsError(
        f"no place for a {link.kind!r} between {link.rooms[0]!r} and {link.rooms[1]!r}: they share {lengths} m of wall; "
        f"a door needs {MIN_DOOR_M + 2 * CORNER_M:.2f} m in a row, clear of other openings"
    )
