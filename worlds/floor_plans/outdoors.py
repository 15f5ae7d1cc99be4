"""Gardens and balconies: outdoor areas along the outer walls of a storey's bands (its rows of rooms)."""

from collections.abc import Sequence

import numpy as np

from worlds.floor_plans.bays import DOOR_FRONT
from worlds.floor_plans.programmes import StoreyProgramme
from worlds.floor_plans.rectangles import contact
from worlds.floor_plans.storey_draft import PlacedBay, StoreyDraft
from worlds.floor_plans.wings import Shell

_LEADING_OUTSIDE = ("living room", "dining room", "kitchen", "bedroom", "lobby", "library", "meeting room", "office")
"""Labels of rooms that should lead outside, the most suitable first."""
_WIDEST_BALCONY, _LEAST_BALCONY = 500, 150
"""Width of a balcony along a much longer outer wall, and least width of a balcony beside a garden [cm]."""
_LEAST_GARDEN = 200
"""Least width of a garden beside a balcony [cm]."""
_MARGIN = 60
"""Least length of outer wall left on either side of a balcony that is narrower than the wall [cm]."""

_Back = tuple[PlacedBay, int]
"""A bay (a main room with its small rooms) with a free outer wall, and the number of its main room."""


def add_outdoors(
    draft: StoreyDraft,
    programme: StoreyProgramme,
    shell: Shell,
    placed: Sequence[PlacedBay],
    hosts: Sequence[int],
    rng: np.random.Generator,
) -> None:
    """Add the programme's garden and balcony, if it has them, each with an opening requested to a room that leads there.

    `hosts` are the numbers of the main rooms of the bays in `placed`, in the same order.

    Garden and balcony adjoin bays with free outer walls. In a plan with a second wing these are the bays in the south and
    along that wing, because the north bands (rows of rooms) lie in the corners between the wings.
    """
    open_bands = ("south", "west", "east") if shell.depths.cross else ("south", "north 0", "north 1", "north 2")
    backs = [(p, host) for p, host in zip(placed, hosts, strict=True) if p.band in open_bands]
    south = [(p, host) for p, host in backs if p.band == "south"]
    first, end = 0, max((p.start + p.width + p.wrap for p, _ in south), default=0)
    if programme.balcony:
        first = _add_balcony(draft, shell, backs, end if programme.garden else None, rng)
    if programme.garden:
        _add_garden(draft, shell, south, (first, end), rng)


def _add_balcony(
    draft: StoreyDraft, shell: Shell, backs: Sequence[_Back], garden_end: int | None, rng: np.random.Generator
) -> int:
    """Add a balcony to one of the bays `backs`, which have free outer walls. Return where the garden may begin [cm].

    `garden_end` is the east end of the south side, to which a garden reaches [cm]; None if there is no garden. The result
    is measured along the south side, too.

    The balcony adjoins the bay whose main room suits best; bays in the south come last if there is a garden. It is as wide
    as a bay of less than 6.2 m, and on a wider bay it is 5 m wide, in the middle. If only the south is left, balcony and
    garden share it: the balcony gets a part of the first bay's width, and the garden begins where the balcony ends. If this
    leaves too little for the garden, the balcony stands at the west end of the spine, the strip between the bands.
    """
    p, host = min(backs, key=lambda back: (garden_end is not None and back[0].band == "south", _outdoor_rank(back)))
    # A bay that is only a little wider than the widest balcony gets a balcony along its whole width.
    wide = p.width if p.width < _WIDEST_BALCONY + 2 * _MARGIN else _WIDEST_BALCONY
    start, garden_start = p.start + (p.width - wide) // 2, 0
    if garden_end is not None and p.band == "south":
        p, host = next(back for back in backs if back[0].band == "south" and back[0].start == 0)
        start, wide = 0, max(_LEAST_BALCONY, p.width // 3)
        garden_start = wide
    out, away = shell.depths.of(p.band), int(rng.integers(140, 191))
    place = shell.edge(p.band).rect(start, out, start + wide, out + away)
    if garden_end is not None and garden_start and garden_end - garden_start < _LEAST_GARDEN:
        garden_start, place = 0, (-away, 0, 0, shell.depths.spine)
    balcony = draft.add("balcony", [place])
    draft.link(_way_out(draft, balcony, host), balcony)
    return garden_start


def _add_garden(
    draft: StoreyDraft, shell: Shell, south: Sequence[_Back], span: tuple[int, int], rng: np.random.Generator
) -> None:
    """Add a garden along the part `span` of the south side, from its start to its end [cm].

    It is entered from a living room, dining room or kitchen in the south, or else from any main room there.
    """
    (start, end), depth = span, shell.depths.south
    garden = draft.add("garden", [shell.edge("south").rect(start, depth, end, depth + int(rng.integers(360, 461)))])
    ranked = sorted(south, key=_outdoor_rank)
    best = [host for p, host in ranked if p.bay.labels[0] in _LEADING_OUTSIDE[:3]] or [host for _, host in ranked]
    draft.link(_way_out(draft, garden, best[int(rng.integers(len(best)))]), garden, "cased")


def _outdoor_rank(back: _Back) -> int:
    """Return a sort key: bays whose main rooms should lead outside come first, the most suitable label first of all."""
    label = back[0].bay.labels[0]
    return _LEADING_OUTSIDE.index(label) if label in _LEADING_OUTSIDE else len(_LEADING_OUTSIDE)


def _way_out(draft: StoreyDraft, outside: int, host: int) -> int:
    """Return the number of the room that leads to the outdoor area `outside`.

    This is the room `host`. If `host` shares too little wall with the area for a door, it is the room that shares the
    longest wall with the area.
    """
    if contact(draft.rooms[outside].rects, draft.rooms[host].rects) >= DOOR_FRONT:
        return host
    return draft.nearest(outside, range(outside))
