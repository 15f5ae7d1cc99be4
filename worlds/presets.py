"""Presets: families of generated houses, one house for every seed.

The presets "home", "ori", "uh2-apt" and "uh2-office" are named after the datasets of the LEXIS paper (Sec. IV-A).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from worlds.errors import WorldsError, check_number, check_whole
from worlds.floor_plans.building_kinds import BUILDING_KINDS, BuildingKind
from worlds.floor_plans.floor_plan import SLAB_M, PlanStyle, lay_out
from worlds.floor_plans.preset_names import MAX_ROOMS_ASKED, MAX_STOREYS_ASKED, MIN_ROOMS_ASKED
from worlds.floor_plans.preset_names import PRESETS as PRESETS
from worlds.floor_plans.programmes import LayoutShares, StoreyProgramme
from worlds.floor_plans.room_lists import by_storey, draw_programmes, programmes_of
from worlds.labels import CIRCULATION_LABELS, OUTDOOR_LABELS, ROOM_LABELS, STAIRS
from worlds.openings.openness import with_openness
from worlds.openings.placement import place_openings
from worlds.spec import CLUTTER_SCALE, HouseSpec, StoreySpec
from worlds.valid_names import did_you_mean


def sample_house(
    preset: str,
    seed: int,
    *,
    openness: float | None = None,
    clutter: float = 1.0,
    rooms: int | None = None,
    storeys: int | None = None,
) -> HouseSpec:
    """Generate the house of a preset that belongs to `seed`; the same arguments always give the same house.

    Args:
        preset: one of `PRESETS`.
        seed: 0 ... 2**63 - 1.
        openness: share of the area of the inner walls that is permanently open, in [0, 1] (see `worlds.openings.openness`);
            None: as the preset draws it.
        clutter: how much furniture is filled in (see `HouseSpec`).
        rooms: number of rooms, without corridors, halls and stairs; None: as the preset draws it.
        storeys: number of storeys; None: as the preset draws it.

    Raises:
        WorldsError: the preset is unknown, or an argument is out of its range.
    """
    if preset not in PRESETS:
        raise WorldsError(f"unknown preset {preset!r}{did_you_mean(preset, PRESETS)}; valid: {', '.join(PRESETS)}")
    check_whole(seed=seed, rooms=rooms, storeys=storeys)
    rngs = _generators(seed)
    kind = _random_kind(rngs[0]) if preset == "random" else BUILDING_KINDS[preset]
    programmes, style = draw_programmes(kind, *_counts(kind, rooms, storeys, rngs[0]), rngs[0])
    return _finished(f"{preset}-{seed}", seed, programmes, style, rngs, openness, clutter)


def sample_from_rooms(
    labels: Sequence[str],
    seed: int,
    *,
    openness: float | None = None,
    clutter: float = 1.0,
    storeys: int = 1,
) -> HouseSpec:
    """Generate a house with a room for each of `labels`; the same arguments always give the same house.

    The rooms stand along the first corridor, entrance hall or lobby in the list. If the list has none of these, a corridor
    is added. Stairs are added if there are several storeys. Raises `WorldsError` for labels or numbers that are not valid.
    See `sample_house` for the other arguments.
    """
    check_whole(seed=seed, storeys=storeys)
    possible = [label for label in ROOM_LABELS if label != STAIRS]
    if unknown := [label for label in labels if label not in possible]:
        raise WorldsError(
            f"no room can be a {unknown[0]!r}{did_you_mean(unknown[0], possible)}; valid: {', '.join(possible)}"
        )
    if not 1 <= len(labels) <= MAX_ROOMS_ASKED:
        raise WorldsError(f"{len(labels)} rooms were asked for; valid: 1 to {MAX_ROOMS_ASKED}")
    spine = next((label for label in labels if label in CIRCULATION_LABELS), None)
    others = list(labels)
    if spine is not None:
        others.remove(spine)
    _check_storeys(storeys, sum(label not in OUTDOOR_LABELS for label in others))
    if others.count("garden") > 1:
        raise WorldsError(f"{others.count('garden')} gardens were asked for; a house has at most one")
    if others.count("balcony") > storeys:
        raise WorldsError(f"{others.count('balcony')} balconies were asked for; valid: at most one per storey ({storeys})")
    rngs = _generators(seed)
    shares = LayoutShares(open_plan=0.5, twins=0.3)
    programmes = programmes_of(by_storey(others, storeys, ("bedroom", "children's room"), rngs[0]), shares, None, rngs[0])
    programmes = tuple(replace(p, spine=spine or "corridor") for p in programmes)
    return _finished(f"rooms-{seed}", seed, programmes, PlanStyle(), rngs, openness, clutter)


def _generators(seed: int) -> tuple[np.random.Generator, ...]:
    """Return three random generators: for the list of rooms, for their positions, and for the openings between the rooms."""
    if not 0 <= seed < 2**63:
        raise WorldsError(f"house seed {seed} is not in 0 ... 2**63 - 1")
    return tuple(np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(3))


def _random_kind(rng: np.random.Generator) -> BuildingKind:
    """Draw the kind of building for the preset "random": one of five kinds, or a mixture of rooms with any label."""
    names = ("home", "apartment", "office", "clinic", "school", None, None)
    name = names[int(rng.integers(len(names)))]
    indoors = [label for label in ROOM_LABELS if label not in (*OUTDOOR_LABELS, *CIRCULATION_LABELS, STAIRS)]
    order = [indoors[i] for i in rng.permutation(len(indoors))]
    kind = (
        BUILDING_KINDS[name]
        if name
        else replace(BUILDING_KINDS["office"], first=(), more=(*order, *OUTDOOR_LABELS), repeats=0.2)
    )
    most = 2 + round(38 * float(rng.random()) ** 3)
    storeys = (1, 1, 1, 2, 2, 2, 3, 4) if most >= 5 else (1,)
    return replace(kind, rooms=(most, most), storeys=storeys, halls=(*kind.halls, None))


def _counts(kind: BuildingKind, rooms: int | None, storeys: int | None, rng: np.random.Generator) -> tuple[int, int]:
    """Return the numbers of rooms and storeys of a building: the requested numbers, or drawn numbers if None is given.

    A drawn number of storeys is limited so that there are enough rooms for all storeys. Raises `WorldsError` for numbers
    that are not valid.
    """
    usual, levels = int(rng.integers(kind.rooms[0], kind.rooms[1] + 1)), int(rng.choice(kind.storeys))
    if rooms is not None and not MIN_ROOMS_ASKED <= rooms <= MAX_ROOMS_ASKED:
        raise WorldsError(f"{rooms} rooms were asked for; valid: {MIN_ROOMS_ASKED} to {MAX_ROOMS_ASKED}")
    if storeys is not None:
        _check_storeys(storeys, rooms if rooms is not None else storeys)
        levels, usual = storeys, max(usual, 3 * storeys if usual < 2 * storeys else 0)
    if rooms is not None:
        return rooms, levels if storeys is not None else min(levels, max(1, 3 * rooms // 4))
    if kind.flat is not None and levels > 1:
        usual = levels * int(rng.integers(kind.flat[0], kind.flat[1] + 1))
    return usual, min(levels, max(1, 3 * usual // 4))


def _check_storeys(storeys: int, indoors: int) -> None:
    if not 1 <= storeys <= MAX_STOREYS_ASKED:
        raise WorldsError(f"{storeys} storeys were asked for; valid: 1 to {MAX_STOREYS_ASKED}")
    if indoors < storeys:
        raise WorldsError(
            f"{indoors} indoor rooms besides the corridor cannot fill {storeys} storeys; valid: at least one for each storey"
        )


def _finished(
    name: str,
    seed: int,
    programmes: Sequence[StoreyProgramme],
    style: PlanStyle,
    rngs: Sequence[np.random.Generator],
    openness: float | None,
    clutter: float,
) -> HouseSpec:
    """Lay out the rooms that the programmes list for each storey, place the openings, and return the spec of the house."""
    check_number("clutter", clutter, 0.0, 4.0, CLUTTER_SCALE)
    layouts = lay_out(programmes, style, rngs[1])
    storeys = tuple(
        StoreySpec(height_m=layout.height_m, rooms=layout.rooms, openings=place_openings(layout, rngs[2]))
        for layout in layouts
    )
    spec = HouseSpec(name=name, seed=seed, slab_m=SLAB_M, clutter=clutter, storeys=storeys)
    return spec if openness is None else with_openness(spec, openness)
