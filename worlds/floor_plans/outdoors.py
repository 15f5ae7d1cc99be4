"""Gardens and balconies: places outside, behind the bands of a storey."""

from collections.abc import Sequence

import numpy as np

from worlds.floor_plans.bays import DOOR_FRONT
from worlds.floor_plans.programmes import StoreyProgramme
from worlds.floor_plans.rectangles import contact
from worlds.floor_plans.storey_draft import PlacedBay, StoreyDraft
from worlds.floor_plans.wings import Shell

_OUTSIDE_FIRST = ("living room", "dining room", "kitchen", "bedroom", "lobby", "library", "meeting room", "office")
_WIDEST_BALCONY, _LEAST_BALCONY = 500, 150
"""[cm]"""
_MARGIN = 60
"""What is left of a bay's back beside a balcony, if anything is [cm]."""


def add_outdoors(
    draft: StoreyDraft,
    programme: StoreyProgramme,
    shell: Shell,
    placed: Sequence[PlacedBay],
    hosts: Sequence[int],
    rng: np.random.Generator,
) -> None:
    """A garden all along the south, a balcony behind some room."""
    depth, edge, first = shell.depths.south, shell.edge("south"), 0
    open_bands = ("south", "west", "east") if shell.depths.cross else ("south", "north 0", "north 1", "north 2")
    backs = [(p, host) for p, host in zip(placed, hosts, strict=True) if p.band in open_bands]
    if programme.balcony:
        backs.sort(key=lambda pair: _wish(pair, programme.garden))
        p, host = backs[0]
        wide = p.width if p.width < _WIDEST_BALCONY + 2 * _MARGIN else _WIDEST_BALCONY
        start = p.start + (p.width - wide) // 2
        if programme.garden and p.band == "south":
            # Both have to share the south side.
            p, host = next(pair for pair in backs if pair[0].band == "south" and pair[0].start == 0)
            start, wide = 0, max(_LEAST_BALCONY, p.width // 3)
            first = wide
        out, away = shell.depths.of(p.band), int(rng.integers(140, 191))
        balcony = draft.add("balcony", [shell.edge(p.band).rect(start, out, start + wide, out + away)])
        draft.link(_behind(draft, balcony, host), balcony)
    if programme.garden:
        south = [(p, host) for p, host in backs if p.band == "south"]
        end = max(p.start + p.width + p.wrap for p, _ in south)
        garden = draft.add("garden", [edge.rect(first, depth, end, depth + int(rng.integers(360, 461)))])
        south.sort(key=lambda pair: _wish(pair, False))
        best = [host for p, host in south if p.bay.labels[0] in _OUTSIDE_FIRST[:3]] or [host for _, host in south]
        draft.link(_behind(draft, garden, best[int(rng.integers(len(best)))]), garden, "cased")


def _wish(pair: tuple[PlacedBay, int], south_last: bool) -> tuple[bool, int]:
    """How little a bay asks for a place outside."""
    label = pair[0].bay.labels[0]
    rank = _OUTSIDE_FIRST.index(label) if label in _OUTSIDE_FIRST else len(_OUTSIDE_FIRST)
    return south_last and pair[0].band == "south", rank


def _behind(draft: StoreyDraft, outside: int, host: int) -> int:
    """The room that leads outside: the host, unless what is carved from its back leaves it no wall there."""
    if contact(draft.rooms[outside].rects, draft.rooms[host].rects) >= DOOR_FRONT:
        return host
    return draft.nearest(outside, range(outside))
