"""From programmes to layouts: a shell for all storeys, then the rooms of each; valid by construction, without retries.

Every storey stands on the one below: a band of rooms is at least as long as the one above it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from worlds.bays import DOOR_FRONT, bay_width, share_out
from worlds.flights import StairsKind
from worlds.layout import StoreyLayout
from worlds.programmes import Bay, Run, StoreyProgramme
from worlds.rectangles import Symmetry, area_m2
from worlds.storey_draft import Placed, draft_storey
from worlds.wings import BANDS, Band, Depths, Shell, StairsBay, distribute, stairs_bay

SLAB_M = 0.3
_SHORTEST_BAND = 250
"""A band planned for less [cm] is left out."""
_STRETCH = 1.4
"""Bands are widened to their shell up to this factor; shorter ones leave the storey's end open."""


@dataclass(frozen=True)
class Style:
    """Measures of a kind of building; ranges to draw from."""

    spine_m: tuple[float, float] = (1.4, 2.0)
    depth_m: tuple[float, float] = (3.7, 4.6)
    heights_m: tuple[float, ...] = (2.6,)
    stairs: tuple[StairsKind | None, ...] = ("U", "L", "straight", None)
    """To choose from; None: U-shaped, at the spine's end."""
    one_sided_m: tuple[float, float] = (9.0, 16.0)
    """Below the first total length of its rooms a plan has rooms on one side of the spine, above the second on both."""
    winged_m: float = 26.0
    """Above this total length there may be a second wing."""
    wings: float = 0.7
    """Share of such plans that have one."""


@dataclass
class _Storey:
    """A storey's runs by band, and how far they reach."""

    bands: dict[Band, list[Run]]
    slot: Run | None = None
    lengths: dict[Band, int] = field(default_factory=dict)
    past_spine: frozenset[Band] = frozenset()
    """Bands that go on beside stairs at the spine's end."""

    def bays(self, band: Band) -> list[Bay]:
        return [bay for run in self.bands.get(band, ()) for bay in run.bays]


def lay_out(programmes: Sequence[StoreyProgramme], style: Style, rng: np.random.Generator) -> tuple[StoreyLayout, ...]:
    """Layouts of all storeys, lowest first, turned to a random orientation."""
    depths, room = _topology(programmes, style, rng)
    height = float(rng.choice(style.heights_m))
    stairs, at_end, depths = _stairs(depths, room, style, len(programmes), height, rng)
    shell = Shell(depths, dict.fromkeys(BANDS, 0), stairs, at_end)
    storeys = _assign(programmes, shell, room, rng)
    shell = _measured(shell, storeys)
    swap, flip_x, flip_y = (bool(k) for k in rng.integers(0, 2, 3))
    turn = Symmetry(swap, flip_x, flip_y)
    cross_apart = bool(rng.random() < 0.5)
    return tuple(
        draft_storey(level, len(programmes), programme, shell, _placed(storey, shell), storey.slot, cross_apart, rng).layout(
            level, turn, height
        )
        for level, (programme, storey) in enumerate(zip(programmes, storeys, strict=True))
    )


def _topology(
    programmes: Sequence[StoreyProgramme], style: Style, rng: np.random.Generator
) -> tuple[Depths, dict[Band, int]]:
    """Measures across, and how much length each band is to get."""

    def draw(bounds: tuple[float, float]) -> int:
        return round(100 * float(rng.uniform(*bounds)))

    bays = [bay for programme in programmes for run in programme.runs for bay in run.bays]
    deep = round(100 * min(8.0, max(0.62 * max((sum(bay.areas) for bay in bays), default=0.0), 0.0) ** 0.5))
    south, north, spine = max(draw(style.depth_m), deep), draw(style.depth_m), draw(style.spine_m)
    total = max(sum(bay_width(bay, (south + north) // 2) for run in p.runs for bay in run.bays) for p in programmes)
    if total < 100 * rng.uniform(*style.one_sided_m):
        return Depths(spine, south), {"south": total}
    if total < 100 * style.winged_m or rng.random() > style.wings:
        share = float(rng.choice([0.0, 0.3, 0.5]))
        half = total // 2
        rooms: dict[Band, int] = {"south": half, "north 0": round(half * share), "north 2": half - round(half * share)}
        return Depths(spine, south, north), _worth_while(rooms)
    share = float(rng.choice([0.0, 0.5, 0.5, 1.0]))
    main, wing = round(0.33 * total), round(0.17 * total)
    rooms = {
        "south": main, "north 0": round(main * share), "north 2": main - round(main * share), "west": wing, "east": wing,
    }  # fmt: skip
    west, east = draw(style.depth_m), max(draw(style.depth_m), deep if rng.random() < 0.5 else 0)
    return Depths(spine, south, north, max(150, spine - 10), west, east), _worth_while(rooms)


def _worth_while(room: dict[Band, int]) -> dict[Band, int]:
    return {band: length for band, length in room.items() if length > _SHORTEST_BAND or band == "south"}


def _stairs(
    depths: Depths, room: dict[Band, int], style: Style, storeys: int, height_m: float, rng: np.random.Generator
) -> tuple[StairsBay | None, bool, Depths]:
    if storeys == 1:
        return None, False, depths
    kind = style.stairs[int(rng.integers(len(style.stairs)))]
    rise, flipped = height_m + SLAB_M, bool(rng.integers(2))
    if kind is None:
        depths = replace(depths, spine=min(max(depths.spine, 200), 240))
        if not depths.cross and "north 0" in room:
            room["north 2"] = room.get("north 2", 0) + room.pop("north 0")
        return stairs_bay("U", rise, depths.spine / 100, flipped), True, depths
    stairs = stairs_bay(kind, rise, flipped=flipped)
    if depths.north:
        depths = replace(depths, north=max(depths.north, stairs.depth))
        room["south"] += stairs.front // 2
        for band in ("north 0", "north 2"):
            if band in room:
                room[band] = max(1, room[band] - stairs.front // 4)
    return stairs, False, depths


def _assign(
    programmes: Sequence[StoreyProgramme], shell: Shell, room: dict[Band, int], rng: np.random.Generator
) -> list[_Storey]:
    """Bands of all runs; a storey uses only what is used below, and floors that repeat are the same."""
    storeys: list[_Storey] = []
    for k, programme in enumerate(programmes):
        if k and programme.runs is programmes[k - 1].runs:
            storeys.append(_Storey(storeys[-1].bands, storeys[-1].slot))
            continue
        runs = list(programme.runs)
        slot = _take_slot(runs, shell) if k == 0 or storeys[-1].slot else None
        allowed = {b: n for b, n in room.items() if k == 0 or storeys[-1].bands[b]}
        bands = distribute(runs, allowed, shell.depths, _kept(runs))
        for inside in bands.values():
            rng.shuffle(inside)
            if shell.at_end and inside:
                inside.sort(key=lambda run: bay_width(run.bays[-1], 420) >= 300)
            inside.sort(key=lambda run: run.bays[0].labels[0] != "garage")
            if shell.at_end and inside:
                inside[-1] = replace(inside[-1], bays=(*inside[-1].bays[:-1], inside[-1].bays[-1].with_front()))
        storeys.append(_Storey({band: bands.get(band, []) for band in room}, slot))
    return storeys


def _kept(runs: Sequence[Run]) -> dict[int, Band]:
    """Something lies in the south of every storey: what would have a garden or a balcony."""
    garden = ("living room", "dining room", "kitchen")
    best = max(range(len(runs)), key=lambda i: (sum(b.labels[0] in garden for b in runs[i].bays), runs[i].bays[0].areas[0]))
    return {best: "south"}


def _take_slot(runs: list[Run], shell: Shell) -> Run | None:
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


def _measured(shell: Shell, storeys: Sequence[_Storey]) -> Shell:
    """The shell as long as its longest storey in every band; says every storey how far its bands reach, top down."""
    lengths = _longest(shell, storeys)
    shell = replace(shell, lengths=lengths)
    if shell.at_end:
        passed: set[Band] = set()
        for storey in reversed(storeys):
            passed |= {b for b in storey.bands if shell.reach(b, sum(_widths(storey, b, shell))) > shell.length}
            storey.past_spine = frozenset(passed)
        lengths = _longest(shell, storeys)
        shell = replace(shell, lengths=lengths)
    above: dict[Band, int] = {}
    for storey in reversed(storeys):
        storey.lengths = {}
        for band in storey.bands:
            own = sum(_widths(storey, band, shell))
            whole = lengths[band] if lengths[band] <= _STRETCH * own else 0
            if band not in storey.past_spine and shell.reach(band, whole) > shell.length:
                whole = 0
            storey.lengths[band] = max(own, whole, above.get(band, 0)) if own else 0
        above = storey.lengths
    return shell


def _longest(shell: Shell, storeys: Sequence[_Storey]) -> dict[Band, int]:
    return {b: max(sum(_widths(s, b, shell)) if b in s.bands else 0 for s in storeys) for b in BANDS}


def _widths(storey: _Storey, band: Band, shell: Shell) -> list[int]:
    widths = [bay_width(bay, shell.depths.of(band)) for bay in storey.bays(band)]
    if widths and shell.stairs and band in storey.past_spine:
        # The last bay reaches past the spine's end, but enough of it has to touch the spine.
        widths[-1] = max(widths[-1], shell.stairs.length + DOOR_FRONT)
    return widths


def _placed(storey: _Storey, shell: Shell) -> list[Placed]:
    out = []
    for band in storey.bands:
        bays, widths = storey.bays(band), _widths(storey, band, shell)
        start, joined = 0, _joints(storey.bands[band])
        filled = share_out(widths, bays, storey.lengths[band]) if bays else []
        for bay, joint, width in zip(bays, joined, filled, strict=True):
            out.append(Placed(band, bay, start, width, joint))
            start += width
    return out


def _joints(runs: Sequence[Run]) -> list[Run | None]:
    """For every bay, the run that joins it to the bay before it."""
    return [run if i else None for run in runs for i in range(len(run.bays))]
