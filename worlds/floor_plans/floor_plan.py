"""From programmes to layouts: a shell for all storeys, then the rooms of each; valid by construction, without retries."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from worlds.floor_plans.bands import assign, measured, placed_bays, wrap_round
from worlds.floor_plans.bays import bay_width
from worlds.floor_plans.layout import StoreyLayout
from worlds.floor_plans.outdoors import add_outdoors
from worlds.floor_plans.programmes import StoreyProgramme
from worlds.floor_plans.rectangles import SquareSymmetry
from worlds.floor_plans.storey_draft import draft_storey
from worlds.floor_plans.wings import BANDS, Band, Depths, Shell, StairsBay, stairs_bay
from worlds.stairs.flights import StairsKind

SLAB_M = 0.3
_SHORTEST_BAND = 250
"""A band planned for less [cm] is left out."""


@dataclass(frozen=True)
class PlanStyle:
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


def lay_out(programmes: Sequence[StoreyProgramme], style: PlanStyle, rng: np.random.Generator) -> tuple[StoreyLayout, ...]:
    """Layouts of all storeys, lowest first, turned to a random orientation."""
    depths, room = _topology(programmes, style, rng)
    height = float(rng.choice(style.heights_m))
    stairs, at_end, depths = _stairs(depths, room, style, len(programmes), height, rng)
    shell = Shell(depths, dict.fromkeys(BANDS, 0), stairs, at_end)
    storeys = assign(programmes, shell, room, rng)
    if not at_end and rng.random() < style.wrapped:
        wrap_round(storeys, shell, rng)
    shell = measured(shell, storeys)
    roomy = min(520, round(1e4 * style.spine_m2 / shell.length))
    shell = replace(shell, depths=replace(shell.depths, spine=max(shell.depths.spine, roomy)))
    swap, flip_x, flip_y = (bool(k) for k in rng.integers(0, 2, 3))
    turn = SquareSymmetry(swap, flip_x, flip_y)
    cross_apart = bool(rng.random() < 0.5)
    layouts = []
    for level, (programme, storey) in enumerate(zip(programmes, storeys, strict=True)):
        placed = placed_bays(storey, shell)
        draft, hosts = draft_storey(level, len(programmes), programme, shell, placed, storey.slot, cross_apart)
        add_outdoors(draft, programme, shell, placed, hosts, rng)
        layouts.append(draft.layout(level, turn, height))
    return tuple(layouts)


def _topology(
    programmes: Sequence[StoreyProgramme], style: PlanStyle, rng: np.random.Generator
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
    depths: Depths, room: dict[Band, int], style: PlanStyle, storeys: int, height_m: float, rng: np.random.Generator
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
