"""`lay_out`: turns the lists of rooms of a building's storeys (programmes) into floor plans (layouts).

The plan of a building is a corridor, called the spine, with rows of rooms along it, called bands; a second corridor with two
more bands may leave the first at a right angle (see the drawing in `wings`). The parts of the plan that all storeys share -
the depths of the bands, the stairs - are called the shell. Every plan is valid by construction: none is made and then
rejected.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from worlds.floor_plans.bands import assign, measured, placed_bays, wrap_round
from worlds.floor_plans.bays import bay_width
from worlds.floor_plans.outdoors import add_outdoors
from worlds.floor_plans.programmes import StoreyProgramme
from worlds.floor_plans.rectangles import SquareSymmetry
from worlds.floor_plans.storey_draft import draft_storey
from worlds.floor_plans.wings import BANDS, Band, Depths, Shell, StairsBay, stairs_bay
from worlds.layout import StoreyLayout
from worlds.stairs.flights import StairsKind

SLAB_M = 0.3
_SHORTEST_BAND = 250
"""Least planned length of a band, that is, of a row of rooms along a corridor [cm]; shorter bands are left out."""


@dataclass(frozen=True)
class PlanStyle:
    """Dimensions of the floor plans of a kind of building, and shares of plans with certain features.

    A value is drawn from each (low, high) range.
    """

    spine_m: tuple[float, float] = (1.4, 2.0)
    """Width of the spine (the corridor) [m]."""
    depth_m: tuple[float, float] = (3.7, 4.6)
    """Depth of a band (a row of rooms along the corridor), at a right angle to the corridor [m]."""
    heights_m: tuple[float, ...] = (2.6,)
    """Possible heights of the ceiling above the floor; one is drawn for the whole building [m]."""
    stairs: tuple[StairsKind | None, ...] = ("U", "L", "straight", None)
    """Possible kinds of stairs, one of which is drawn at random. The entry None means U-shaped stairs at the end of the
    spine (the corridor); all other entries mean stairs on the north side of the spine."""
    one_sided_m: tuple[float, float] = (9.0, 16.0)
    """Range from which a limit is drawn [m]. If no storey's rooms, put side by side, reach this limit, all rooms stand on
    one side of the spine (the corridor)."""
    winged_m: float = 26.0
    """A plan may get a second wing (a second corridor with rooms along it) if the rooms of its largest storey, put side by
    side along one corridor, would be at least this long in total [m]."""
    wings: float = 0.7
    """Share of plans with a second wing if the rooms of the largest storey, put side by side, are `winged_m` to 40 m long.
    If they are longer, the plan always has a second wing."""
    spine_m2: float = 0.0
    """Least area of the spine, for plans in which a living room takes the place of the corridor [m²]. The spine is made
    wider to reach this area, but at most 5.2 m wide."""
    wrapped: float = 0.35
    """Share of plans in which a room south of the spine (the corridor) bends round the spine's end, if a room is suitable
    and no stairs stand there."""


def lay_out(programmes: Sequence[StoreyProgramme], style: PlanStyle, rng: np.random.Generator) -> tuple[StoreyLayout, ...]:
    """Return the layouts of all storeys, lowest first.

    The spine is the corridor, or the living room in its place; a band is a row of rooms along the spine.

    1. `_topology` decides how many bands there are, by the total length of the rooms, and draws the depths of the bands.
    2. `_stairs` chooses the stairs before any room is placed, because they take the same part of every storey.
    3. `bands.assign` chooses a band for every room, `bands.wrap_round` may bend a room of the south band round the spine's
       end, and `bands.measured` sets the lengths of all bands so that every storey stands on the storey below.
    4. The spine becomes wider if it is a living room whose area would be too small. This comes after step 3, because
       the area depends on the spine's length.
    5. Each storey is drafted in whole centimetres: spine, stairs, rooms (`storey_draft`), then gardens and balconies
       (`outdoors`). The drafts of all storeys are mirrored and rotated in the same random way, and become layouts.
    """
    depths, lengths = _topology(programmes, style, rng)
    height = float(rng.choice(style.heights_m))
    stairs, at_end, depths = _stairs(depths, lengths, style, len(programmes), height, rng)
    shell = Shell(depths, dict.fromkeys(BANDS, 0), stairs, at_end)
    storeys = assign(programmes, shell, lengths, rng)
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
    """Choose the form of the plan. Return the depths of spines and bands, and the planned length of each band [cm].

    A spine is a corridor, a band a row of rooms along it. The total length of the rooms on the largest storey, put side by
    side, decides the form. If this length is short, all rooms stand on one side of the spine. If it is longer, the rooms
    stand on both sides. If it is longer still, a second wing (another spine with bands) is added.
    """

    def draw(bounds: tuple[float, float]) -> int:
        return round(100 * float(rng.uniform(*bounds)))

    bays = [bay for programme in programmes for group in programme.groups for bay in group.bays]
    # A band must be deep enough for the largest bay: at this depth the bay is about 1.6 times as wide as deep.
    deep = round(100 * min(8.0, (0.62 * max((sum(bay.areas) for bay in bays), default=0.0)) ** 0.5))
    south, north, spine = max(draw(style.depth_m), deep), draw(style.depth_m), draw(style.spine_m)
    total = max(sum(bay_width(bay, (south + north) // 2) for group in p.groups for bay in group.bays) for p in programmes)
    if total < 100 * rng.uniform(*style.one_sided_m):
        return Depths(spine, south), {"south": total}
    if total < 100 * style.winged_m or (total < 4000 and rng.random() > style.wings):
        share = float(rng.choice([0.0, 0.3, 0.5]))
        half = total // 2
        lengths: dict[Band, int] = {"south": half, "north 0": round(half * share), "north 2": half - round(half * share)}
        return Depths(spine, south, north), _worth_while(lengths)
    share = float(rng.choice([0.0, 0.5, 0.5, 1.0]))
    main, wing = round(0.33 * total), round(0.17 * total)
    lengths = {
        "south": main, "north 0": round(main * share), "north 2": main - round(main * share), "west": wing, "east": wing,
    }  # fmt: skip
    west, east = draw(style.depth_m), max(draw(style.depth_m), deep if rng.random() < 0.5 else 0)
    return Depths(spine, south, north, max(150, spine - 10), west, east), _worth_while(lengths)


def _worth_while(lengths: dict[Band, int]) -> dict[Band, int]:
    """Return the planned length of each band (row of rooms) that is long enough for a room, and of the south band."""
    return {band: length for band, length in lengths.items() if length > _SHORTEST_BAND or band == "south"}


def _stairs(
    depths: Depths, lengths: dict[Band, int], style: PlanStyle, storeys: int, height_m: float, rng: np.random.Generator
) -> tuple[StairsBay | None, bool, Depths]:
    """Choose the stairs. Return them, whether they stand at the end of the spine (the corridor), and the changed depths.

    The stairs are None in a building of one storey. `depths` are changed to suit the stairs. `lengths`, the planned lengths
    of the bands (rows of rooms) [cm], are changed in place: stairs in the north push some of the rooms to the south, and
    with stairs at the end, two north bands may become one.
    """
    if storeys == 1:
        return None, False, depths
    kind = style.stairs[int(rng.integers(len(style.stairs)))]
    rise, flipped = height_m + SLAB_M, bool(rng.integers(2))
    if kind is None:
        # The stairs' room is as wide as the spine, which is therefore wide enough for two runs of steps side by side.
        depths = replace(depths, spine=min(max(depths.spine, 200), 240))
        # Without stairs or a second wing in between, the two north bands would be one.
        if not depths.cross and "north 0" in lengths:
            lengths["north 2"] = lengths.get("north 2", 0) + lengths.pop("north 0")
        return stairs_bay("U", rise, flipped, depths.spine / 100), True, depths
    stairs = stairs_bay(kind, rise, flipped)
    # U-shaped stairs that are almost as deep as the band fill it: the rest would be too shallow to use.
    if kind == "U" and 0 < depths.north - stairs.length <= 80:
        stairs = replace(stairs, length=depths.north)
    if depths.north:
        depths = replace(depths, north=max(depths.north, stairs.depth))
        lengths["south"] += stairs.front // 2
        for band in ("north 0", "north 2"):
            if band in lengths:
                lengths[band] = max(1, lengths[band] - stairs.front // 4)
    return stairs, False, depths
