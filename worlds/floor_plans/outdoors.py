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


def add_outdoors(
    draft: StoreyDraft,
    programme: StoreyProgramme,
    shell: Shell,
    placed: Sequence[PlacedBay],
    hosts: Sequence[int],
    rng: np.random.Generator,
) -> None:
    """Add the programme's garden and balcony, if it has them, each with an opening requested to a room that leads there.

    A bay is a main room with its small rooms. `hosts` are the numbers of the main rooms of the bays in `placed`, in the same
    order.

    1. The bays with free outer walls are collected. In a plan with a second wing these are the bays in the south and along
       that wing, because the north bands (rows of rooms) lie in the corners between the wings.
    2. The balcony adjoins the bay whose main room suits best (a living room first); if there is a garden, bays in the south
       are considered last. The balcony is as wide as a bay of less than 6.2 m; on a wider bay it is 5 m wide, in the middle.
    3. The garden takes the whole south side. If the balcony has to be there too, the balcony gets a part of the first bay's
       width, and the garden starts where the balcony ends. If this leaves too little for the garden, the balcony stands at
       the west end of the spine, the strip between the bands.
    4. The garden is entered from a living room, dining room or kitchen in the south. If none of these is in the south, the
       garden is entered from any main room there.
    """
    depth, edge, first = shell.depths.south, shell.edge("south"), 0
    open_bands = ("south", "west", "east") if shell.depths.cross else ("south", "north 0", "north 1", "north 2")
    backs = [(p, host) for p, host in zip(placed, hosts, strict=True) if p.band in open_bands]
    end = max((p.start + p.width + p.wrap for p, _ in backs if p.band == "south"), default=0)
    if programme.balcony:
        backs.sort(key=lambda pair: _balcony_rank(pair, programme.garden))
        p, host = backs[0]
        # A bay that is only a little wider than the widest balcony gets a balcony along its whole width.
        wide = p.width if p.width < _WIDEST_BALCONY + 2 * _MARGIN else _WIDEST_BALCONY
        start = p.start + (p.width - wide) // 2
        if programme.garden and p.band == "south":
            # Every bay that faces the outside is in the south, so balcony and garden share that side.
            p, host = next(pair for pair in backs if pair[0].band == "south" and pair[0].start == 0)
            start, wide = 0, max(_LEAST_BALCONY, p.width // 3)
            first = wide
        out, away = shell.depths.of(p.band), int(rng.integers(140, 191))
        place = shell.edge(p.band).rect(start, out, start + wide, out + away)
        if first and end - first < _LEAST_GARDEN:
            # The south is too short for both. The balcony moves to the west end of the spine, where nothing else stands.
            first, place = 0, (-away, 0, 0, shell.depths.spine)
        balcony = draft.add("balcony", [place])
        draft.link(_way_out(draft, balcony, host), balcony)
    if programme.garden:
        south = [(p, host) for p, host in backs if p.band == "south"]
        garden = draft.add("garden", [edge.rect(first, depth, end, depth + int(rng.integers(360, 461)))])
        ranked = sorted(south, key=lambda pair: _balcony_rank(pair, False))
        best = [host for p, host in ranked if p.bay.labels[0] in _LEADING_OUTSIDE[:3]] or [host for _, host in ranked]
        draft.link(_way_out(draft, garden, best[int(rng.integers(len(best)))]), garden, "cased")


def _balcony_rank(pair: tuple[PlacedBay, int], south_last: bool) -> tuple[bool, int]:
    """Return a sort key: bays whose main rooms suit a balcony come first; with `south_last`, bays in the south come last.

    `pair` is a bay (a main room with its small rooms) and the number of its main room.
    """
    label = pair[0].bay.labels[0]
    rank = _LEADING_OUTSIDE.index(label) if label in _LEADING_OUTSIDE else len(_LEADING_OUTSIDE)
    return south_last and pair[0].band == "south", rank


def _way_out(draft: StoreyDraft, outside: int, host: int) -> int:
    """Return the number of the room that leads to the outdoor area `outside`.

    This is the room `host`. If `host` shares too little wall with the area for a door, it is the room that shares the
    longest wall with the area.
    """
    if contact(draft.rooms[outside].rects, draft.rooms[host].rects) >= DOOR_FRONT:
        return host
    return draft.nearest(outside, range(outside))
