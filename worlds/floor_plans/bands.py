"""Bands: which runs stand where on every storey, and how long that makes them.

Every storey stands on the one below: a band of rooms is at least as long as the one above it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from worlds.floor_plans.bays import DOOR_FRONT, bay_width, share_out
from worlds.floor_plans.programmes import Bay, BayRun, StoreyProgramme
from worlds.floor_plans.rectangles import area_m2
from worlds.floor_plans.storey_draft import PlacedBay
from worlds.floor_plans.wings import BANDS, Band, Shell, distribute

_SHORTEST_BELOW = 350
"""On a band shorter than this nothing is built: the little rooms in it would have to grow with what is above [cm]."""
_WRAPS = ("living room", "dining room", "open-plan office", "library", "lobby", "gym", "meeting room", "classroom")
_STRETCH = 1.5
"""Bands are widened to their shell up to this factor; shorter ones leave the storey's end open."""


@dataclass
class BandedStorey:
    """A storey's runs by band, and how far they reach [cm]."""

    bands: dict[Band, list[BayRun]]
    slot: BayRun | None = None
    lengths: dict[Band, int] = field(default_factory=dict)
    wrap: int = 0
    """How far the last room of the south band reaches beyond the spine and round its end [cm]."""
    past_spine: frozenset[Band] = frozenset()
    """Bands that go on beside stairs at the spine's end."""

    def bays(self, band: Band) -> list[Bay]:
        """All along a band."""
        return [bay for run in self.bands.get(band, ()) for bay in run.bays]


def assign(
    programmes: Sequence[StoreyProgramme], shell: Shell, room: dict[Band, int], rng: np.random.Generator
) -> list[BandedStorey]:
    """Bands of all runs; a storey uses only what is used below, and floors that repeat are the same."""
    storeys: list[BandedStorey] = []
    for k, programme in enumerate(programmes):
        if k and programme.runs is programmes[k - 1].runs:
            storeys.append(replace(storeys[-1]))
            continue
        runs = list(programme.runs)
        slot = _take_slot(runs, shell) if k == 0 or storeys[-1].slot else None
        allowed = dict(room) if k == 0 else _room_above(storeys[-1], shell)
        bands = distribute(runs, allowed, shell.depths, _kept(runs))
        for inside in bands.values():
            rng.shuffle(inside)
            if shell.at_end and inside:
                inside.sort(key=lambda run: bay_width(run.bays[-1], 420) >= 300)
            inside.sort(key=lambda run: run.bays[0].labels[0] != "garage")
            if shell.at_end and inside:
                inside[-1] = replace(inside[-1], bays=(*inside[-1].bays[:-1], inside[-1].bays[-1].with_front()))
        storeys.append(BandedStorey({band: bands.get(band, []) for band in room}, slot))
    return storeys


def _room_above(storey: BandedStorey, shell: Shell) -> dict[Band, int]:
    """What may be built on a storey: not on a band so short that little rooms would grow large below what is above."""
    length = {band: sum(_widths(storey, band, shell)) for band in storey.bands}
    return {band: n for band, n in length.items() if n > _SHORTEST_BELOW or (band == "south" and n)}


def wrap_round(storeys: Sequence[BandedStorey], shell: Shell, rng: np.random.Generator) -> None:
    """Let the south band of the ground storey, and of those that repeat it, end with a room round the spine's end."""
    south = storeys[0].bands["south"]
    able = [run for run in south if run.bays[-1].form == "plain" and run.bays[-1].twin is None]
    able = [run for run in able if run.bays[-1].labels[0] in _WRAPS and sum(run.bays[-1].areas) >= 16.0]
    if not able or shell.depths.spine > 280:
        return
    area = able[0].bays[-1].areas[0]
    wrap = round(min(450.0, 1e4 * area * rng.uniform(0.45, 0.65) / (shell.depths.south + shell.depths.spine)))
    if wrap < 180:
        return
    south.remove(able[0])
    south.append(able[0])
    for storey in storeys:
        storey.wrap = wrap if storey.bands["south"] is south else 0


def _kept(runs: Sequence[BayRun]) -> dict[int, Band]:
    """Something lies in the south of every storey: what would have a garden or a balcony."""
    garden = ("living room", "dining room", "kitchen")
    best = max(range(len(runs)), key=lambda i: (sum(b.labels[0] in garden for b in runs[i].bays), runs[i].bays[0].areas[0]))
    return {best: "south"}


def _take_slot(runs: list[BayRun], shell: Shell) -> BayRun | None:
    """The run that fits the place behind the stairs, taken from `runs`."""
    slot = shell.slot()
    if slot is None or len(runs) < 3:
        return None
    area = area_m2([slot])
    fitting = [run for run in runs if len(run.bays) == 1 and run.bays[0].form == "plain" and run.bays[0].twin is None]
    fitting = [run for run in fitting if 0.7 <= area / run.bays[0].areas[0] <= 1.5]
    if not fitting:
        return None
    runs.remove(fitting[0])
    return fitting[0]


def measured(shell: Shell, storeys: Sequence[BandedStorey]) -> Shell:
    """The shell as long as its longest storey in every band; says every storey how far its bands reach, top down."""
    shell = replace(shell, lengths=_longest(shell, storeys))
    for storey in storeys:
        if _STRETCH * sum(_widths(storey, "south", shell)) < shell.length:
            storey.wrap = 0  # too much of the spine has nothing in the south
    shell = replace(shell, lengths=_longest(shell, storeys))
    if shell.at_end:
        passed: set[Band] = set()
        for storey in reversed(storeys):
            passed |= {b for b in storey.bands if shell.reach(b, sum(_widths(storey, b, shell))) > shell.length}
            storey.past_spine = frozenset(passed)
        shell = replace(shell, lengths=_longest(shell, storeys))
    shell = shell.flush()
    above: dict[Band, int] = {}
    for storey in reversed(storeys):
        storey.lengths = {}
        for band in storey.bands:
            own = sum(_widths(storey, band, shell))
            whole = shell.lengths[band]
            if shell.at_end and band not in storey.past_spine:
                whole -= max(0, shell.reach(band, whole) - shell.length)
            whole = whole if whole <= _STRETCH * own else 0
            if band == "south" and storey.wrap:
                whole = shell.length
            storey.lengths[band] = max(own, whole, above.get(band, 0)) if own else 0
        above = storey.lengths
    return shell


def _longest(shell: Shell, storeys: Sequence[BandedStorey]) -> dict[Band, int]:
    return {b: max(sum(_widths(s, b, shell)) if b in s.bands else 0 for s in storeys) for b in BANDS}


def _widths(storey: BandedStorey, band: Band, shell: Shell) -> list[int]:
    widths = [bay_width(bay, shell.depths.of(band)) for bay in storey.bays(band)]
    if widths and storey.wrap and band == "south":
        beyond = storey.wrap * (shell.depths.south + shell.depths.spine) // shell.depths.south
        widths[-1] = max(DOOR_FRONT + 40, widths[-1] - beyond)
    if widths and shell.stairs and band in storey.past_spine:
        # The last bay reaches past the spine's end, but enough of it has to touch the spine.
        widths[-1] = max(widths[-1], shell.stairs.length + DOOR_FRONT)
    return widths


def placed_bays(storey: BandedStorey, shell: Shell) -> list[PlacedBay]:
    """The bays of a storey that has been measured, with their places."""
    out = []
    for band in storey.bands:
        bays, widths = storey.bays(band), _widths(storey, band, shell)
        start, joined = 0, _joints(storey.bands[band])
        filled = share_out(widths, bays, storey.lengths[band]) if bays else []
        if len(bays) > 1 and filled[-1] != filled[-2] and bays[-1].twin == bays[-2].twin is not None:
            bays[-1] = bays[-1].apart(1)
        for bay, joint, width in zip(bays, joined, filled, strict=True):
            out.append(PlacedBay(band, bay, start, width, joint))
            start += width
        if band == "south" and storey.wrap and out:
            out[-1] = replace(out[-1], wrap=storey.wrap)
    return out


def _joints(runs: Sequence[BayRun]) -> list[BayRun | None]:
    """For every bay, the run that joins it to the bay before it."""
    return [run if i else None for run in runs for i in range(len(run.bays))]
