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
_WRAPS = ("living room", "dining room", "open-plan office", "library", "lobby", "gym", "meeting room", "classroom")
_STRETCH = 1.5
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
    """Share of such plans that have one; very long ones always do."""
    spine_m2: float = 0.0
    """Least area of a spine that is a room to live in."""
    wrapped: float = 0.35
    """Share of plans, where it can be, whose last room wraps round the end of the spine."""


@dataclass
class _Storey:
    """A storey's runs by band, and how far they reach."""

    bands: dict[Band, list[Run]]
    slot: Run | None = None
    lengths: dict[Band, int] = field(default_factory=dict)
    wrap: int = 0
    """How far the last room of the south band reaches beyond the spine and round its end [cm]."""
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
    if not at_end and rng.random() < style.wrapped:
        _wrap(storeys, shell, rng)
    shell = _measured(shell, storeys)
    roomy = min(520, round(1e4 * style.spine_m2 / shell.length))
    shell = replace(shell, depths=replace(shell.depths, spine=max(shell.depths.spine, roomy)))
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
    if total < 100 * style.winged_m or (total < 4000 and rng.random() > style.wings):
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
    if kind == "U" and 0 < depths.north - stairs.length <= 80:
        stairs = replace(stairs, length=depths.north)
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
        storeys.append(_Storey({band: bands.get(band, []) for band in room}, slot))
    return storeys


def _room_above(storey: _Storey, shell: Shell) -> dict[Band, int]:
    """What may be built on a storey: not on a band so short that little rooms would grow large below what is above."""
    length = {band: sum(_widths(storey, band, shell)) for band in storey.bands}
    return {band: n for band, n in length.items() if n > _SHORTEST_BAND + 100 or (band == "south" and n)}


def _wrap(storeys: Sequence[_Storey], shell: Shell, rng: np.random.Generator) -> None:
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


def _longest(shell: Shell, storeys: Sequence[_Storey]) -> dict[Band, int]:
    return {b: max(sum(_widths(s, b, shell)) if b in s.bands else 0 for s in storeys) for b in BANDS}


def _widths(storey: _Storey, band: Band, shell: Shell) -> list[int]:
    widths = [bay_width(bay, shell.depths.of(band)) for bay in storey.bays(band)]
    if widths and storey.wrap and band == "south":
        beyond = storey.wrap * (shell.depths.south + shell.depths.spine) // shell.depths.south
        widths[-1] = max(DOOR_FRONT + 40, widths[-1] - beyond)
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
        if len(bays) > 1 and filled[-1] != filled[-2] and bays[-1].twin == bays[-2].twin is not None:
            bays[-1] = bays[-1].apart(1)
        for bay, joint, width in zip(bays, joined, filled, strict=True):
            out.append(Placed(band, bay, start, width, joint))
            start += width
        if band == "south" and storey.wrap and out:
            out[-1] = replace(out[-1], wrap=storey.wrap)
    return out


def _joints(runs: Sequence[Run]) -> list[Run | None]:
    """For every bay, the run that joins it to the bay before it."""
    return [run if i else None for run in runs for i in range(len(run.bays))]
