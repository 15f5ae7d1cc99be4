"""Assignment of the groups of bays to the bands of every storey, their order in the bands, and the lengths of the bands.

A band is a row of rooms along one side of a corridor (see the drawing in `wings`). A band is filled with groups of bays that
stay side by side; a bay is one slice of a band, with one main room (see `programmes`). Every storey has to stand on the
storey below, so a band is at least as long as the same band of the storey above.

The functions are called in this order:

1. `assign` chooses a band for every group, from the ground storey upwards: a storey may only use bands that exist below it.
2. `wrap_round` (in some plans) bends the last room of the south band round the corridor's end, so that not all rooms are
   rectangles.
3. `measured` sets the lengths of all bands, from the top storey downwards: a band must reach as far as the same band of the
   storey above.
4. `placed_bays` turns the lengths into a position and a width for every bay.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from worlds.floor_plans.bays import DOOR_FRONT, bay_width, share_out
from worlds.floor_plans.programmes import Bay, BayGroup, StoreyProgramme
from worlds.floor_plans.rectangles import area_m2
from worlds.floor_plans.storey_draft import PlacedBay
from worlds.floor_plans.wings import BANDS, Band, Shell, distribute
from worlds.spec import OpeningKind

_SHORTEST_BELOW = 350
"""Least length of a band (a row of rooms along a corridor) on which the next storey may have rooms [cm]. A shorter band
would have to be lengthened to carry these rooms, and its own small rooms would become too large."""
_WRAPPING_LABELS = ("living room", "dining room", "open-plan office", "library", "lobby", "gym", "meeting room", "classroom")
"""Labels of rooms that may bend round the end of the spine (the corridor)."""
_STRETCH = 1.5
"""Greatest factor by which a band (a row of rooms) is stretched to the building's length; a band that would need a larger
factor ends before the building does."""


@dataclass
class BandedStorey:
    """The groups of bays of a storey, sorted into bands (rows of rooms along a corridor), and the bands' lengths."""

    bands: dict[Band, list[BayGroup]]
    slot: BayGroup | None = None
    """The room in the space behind the stairs (see `Shell.slot`); None: no room is there."""
    lengths: dict[Band, int] = field(default_factory=dict)
    """Length of every band (row of rooms) [cm]; `measured` fills it in."""
    wrap: int = 0
    """Length of the part that the last southern room has beyond the end of the spine (the corridor), if this room bends
    round that end [cm]; 0: no room bends."""
    past_spine: frozenset[Band] = frozenset()
    """Bands (rows of rooms) that continue past the end of the spine (the corridor), beside the stairs at this end."""

    def bays(self, band: Band) -> list[Bay]:
        """Return the bays (main rooms with the small rooms carved from them) of a band, in order along the band."""
        return [bay for group in self.bands.get(band, ()) for bay in group.bays]


def assign(
    programmes: Sequence[StoreyProgramme], shell: Shell, lengths: dict[Band, int], rng: np.random.Generator
) -> list[BandedStorey]:
    """Choose a band for every group of bays of every storey, and the order of the groups in each band.

    A band is a row of rooms along a corridor; the bays of a group stay side by side. For each storey, lowest first:

    1. If the storey repeats the storey below (it has the same `groups` object), it gets a copy of that storey's result, so
       that both stay equal. The other steps are skipped.
    2. A single room may go behind the stairs, where no band reaches; on an upper storey only if the storey below has a room
       there, too.
    3. `distribute` shares the other groups among the bands. On the ground storey, the bands have the planned `lengths`
       [cm]; on an upper storey, they have the lengths of the storey below, on which they stand.
    4. `_put_in_order` puts the groups of each band into their order along the band.
    """
    storeys: list[BandedStorey] = []
    for k, programme in enumerate(programmes):
        if k and programme.groups is programmes[k - 1].groups:
            storeys.append(replace(storeys[-1]))
            continue
        groups = list(programme.groups)
        slot = _take_slot(groups, shell) if k == 0 or storeys[-1].slot else None
        allowed = dict(lengths) if k == 0 else _lengths_above(storeys[-1], shell)
        bands = distribute(groups, allowed, shell.depths, _reserved_bands(groups))
        for inside in bands.values():
            _put_in_order(inside, shell.at_end, rng)
        storeys.append(BandedStorey({band: bands.get(band, []) for band in lengths}, slot))
    return storeys


def _put_in_order(groups: list[BayGroup], stairs_at_end: bool, rng: np.random.Generator) -> None:
    """Put the groups of bays of a band into the order in which they stand along the band; the list is changed in place.

    The order is random, except that a garage comes first. `stairs_at_end` says that stairs stand at the spine's end, so that
    the last bay may have to reach past that end.
    """
    # The sorts are stable: they keep the random order of the groups that they do not tell apart.
    rng.shuffle(groups)
    if stairs_at_end:
        # `_widths` widens the last bay. A narrow room does not come last, because it would become many times too wide.
        groups.sort(key=lambda group: bay_width(group.bays[-1], 420) >= 300)
    # In most plans, the first place is at a corner of the building. A garage belongs there, not between two living rooms.
    groups.sort(key=lambda group: group.bays[0].labels[0] != "garage")
    if stairs_at_end and groups:
        # The last bay touches the spine with a part of its front only; that part must be the host's, for its door.
        groups[-1] = replace(groups[-1], bays=(*groups[-1].bays[:-1], groups[-1].bays[-1].with_front()))


def _lengths_above(storey: BandedStorey, shell: Shell) -> dict[Band, int]:
    """Return the bands (rows of rooms) that the storey above this one may have, with their lengths on this storey [cm].

    Short bands are left out: `measured` makes a band at least as long as the band above, so the small rooms of a short band
    would become too large. The south band always stays, because every storey needs one.
    """
    length = {band: sum(_widths(storey, band, shell)) for band in storey.bands}
    return {band: n for band, n in length.items() if n > _SHORTEST_BELOW or (band == "south" and n)}


def wrap_round(storeys: Sequence[BandedStorey], shell: Shell, rng: np.random.Generator) -> None:
    """Let a large room south of the spine (the corridor) bend round the spine's end, if a room is suitable.

    This changes the ground storey and the storeys that repeat it. The room moves to the end of its row. It must have no
    small rooms carved from it, because they would not fit the new shape, and no twin, because a twin has the same shape.
    About half of the room's area goes beyond the spine's end. Nothing changes if that part would be narrower than 1.8 m, or
    if the spine is wider than 2.8 m.
    """
    south = storeys[0].bands["south"]
    able = [group for group in south if group.bays[-1].form == "plain" and group.bays[-1].twin is None]
    able = [group for group in able if group.bays[-1].labels[0] in _WRAPPING_LABELS and sum(group.bays[-1].areas) >= 16.0]
    if not able or shell.depths.spine > 280:
        return
    area = able[0].bays[-1].areas[0]
    wrap = round(min(450.0, 1e4 * area * rng.uniform(0.45, 0.65) / (shell.depths.south + shell.depths.spine)))
    if wrap < 180:
        return
    south.remove(able[0])
    south.append(able[0])
    for storey in storeys:
        # Storeys that repeat the ground storey share its lists (see `assign`).
        storey.wrap = wrap if storey.bands["south"] is south else 0


def _reserved_bands(groups: Sequence[BayGroup]) -> dict[int, Band]:
    """Choose the group of bays that must go to the south band; return a mapping from its index to "south".

    Every storey needs rooms in the south, since gardens and most balconies lie there. The group with most living rooms,
    dining rooms and kitchens is chosen, because these rooms lead outside; among equal groups, the group with the largest
    first room.
    """
    garden = ("living room", "dining room", "kitchen")
    best = max(
        range(len(groups)), key=lambda i: (sum(b.labels[0] in garden for b in groups[i].bays), groups[i].bays[0].areas[0])
    )
    return {best: "south"}


def _take_slot(groups: list[BayGroup], shell: Shell) -> BayGroup | None:
    """Choose a group of bays for the space behind the stairs, remove it from `groups` and return it; None if no group fits.

    A group fits if it is a single room that has no small rooms carved from it and no twin (a room that must get exactly the
    same shape), and if the area chosen for the room is close to the area of the space. At least two groups must be left for
    the bands (rows of rooms).
    """
    slot = shell.slot()
    if slot is None or len(groups) < 3:
        return None
    area = area_m2([slot])
    fitting = [
        group for group in groups if len(group.bays) == 1 and group.bays[0].form == "plain" and group.bays[0].twin is None
    ]
    fitting = [group for group in fitting if 0.7 <= area / group.bays[0].areas[0] <= 1.5]
    if not fitting:
        return None
    groups.remove(fitting[0])
    return fitting[0]


def measured(shell: Shell, storeys: Sequence[BandedStorey]) -> Shell:
    """Return the shell with the length of every band; also set `lengths` of every storey.

    The shell is what all storeys share; a band is a row of rooms along a corridor, and the spine is the main corridor.

    1. Each band of the shell gets the greatest length that the band has on any storey.
    2. On a storey whose south band is too short to be stretched to the spine's end, no room bends round that end. This
       changes widths, so the shell is measured again.
    3. With stairs at the spine's end, the bands that reach past that end are found, from the top storey downwards. A band
       that does so on one storey also does so on all storeys below, which bear it. The last rooms of these bands get wider,
       so the shell is measured a third time.
    4. `Shell.flush` removes small steps between the ends of bands.
    5. `_stretch` stretches the bands of all storeys to their lengths in the shell.
    """
    shell = replace(shell, lengths=_longest(shell, storeys))
    for storey in storeys:
        if _STRETCH * sum(_widths(storey, "south", shell)) < shell.length:
            storey.wrap = 0  # the south band ends far before the spine, so there is nothing to bend round
    shell = replace(shell, lengths=_longest(shell, storeys))
    if shell.at_end:
        passed: set[Band] = set()
        for storey in reversed(storeys):
            passed |= {b for b in storey.bands if shell.reach(b, sum(_widths(storey, b, shell))) > shell.length}
            storey.past_spine = frozenset(passed)
        shell = replace(shell, lengths=_longest(shell, storeys))
    shell = shell.flush()
    _stretch(storeys, shell)
    return shell


def _stretch(storeys: Sequence[BandedStorey], shell: Shell) -> None:
    """Stretch the bands of all storeys to their lengths in the shell, but none by a factor above `_STRETCH`.

    The storeys are visited from the top downwards, because a band is at least as long as the band above, which stands on it.
    """
    above: dict[Band, int] = {}
    for storey in reversed(storeys):
        storey.lengths = {}
        for band in storey.bands:
            own = sum(_widths(storey, band, shell))
            whole = shell.lengths[band]
            if shell.at_end and band not in storey.past_spine:
                # The band ends with the spine rather than beside the stairs.
                whole -= max(0, shell.reach(band, whole) - shell.length)
            whole = whole if whole <= _STRETCH * own else 0
            if band == "south" and storey.wrap:
                whole = shell.length
            storey.lengths[band] = max(own, whole, above.get(band, 0)) if own else 0
        above = storey.lengths


def _longest(shell: Shell, storeys: Sequence[BandedStorey]) -> dict[Band, int]:
    """Return the greatest length that every band (row of rooms) has on any storey, before it is stretched [cm]."""
    return {b: max(sum(_widths(s, b, shell)) if b in s.bands else 0 for s in storeys) for b in BANDS}


def _widths(storey: BandedStorey, band: Band, shell: Shell) -> list[int]:
    """Return the preferred width of every bay of a band before the band is stretched [cm].

    A band is a row of rooms along a corridor. A bay is a slice of it: one main room with its small rooms.
    """
    widths = [bay_width(bay, shell.depths.of(band)) for bay in storey.bays(band)]
    if widths and storey.wrap and band == "south":
        # The area beyond the spine's end is taken from the room's width in the band, so that its total area stays.
        beyond = storey.wrap * (shell.depths.south + shell.depths.spine) // shell.depths.south
        widths[-1] = max(DOOR_FRONT + 40, widths[-1] - beyond)
    if widths and shell.stairs and band in storey.past_spine:
        # The last bay stands beside the stairs, past the spine's end; enough of it must touch the spine for a door.
        widths[-1] = max(widths[-1], shell.stairs.length + DOOR_FRONT)
    return widths


def placed_bays(storey: BandedStorey, shell: Shell) -> list[PlacedBay]:
    """Return the bays of a storey, with their positions in the bands and their widths.

    A bay is a main room with its small rooms; a band is a row of rooms. The bays of a band are widened in proportion until
    they fill the band, whose length `measured` must have set before.
    """
    out = []
    for band in storey.bands:
        bays, widths = storey.bays(band), _widths(storey, band, shell)
        start, joints = 0, _joints(storey.bands[band])
        filled = share_out(widths, bays, storey.lengths[band]) if bays else []
        # `share_out` may have given the last bay some centimetres more than its twins. Twins have exactly the same shape, so
        # that bay is no longer a twin.
        if len(bays) > 1 and filled[-1] != filled[-2] and bays[-1].twin == bays[-2].twin is not None:
            bays[-1] = bays[-1].apart(1)
        for bay, joint, width in zip(bays, joints, filled, strict=True):
            out.append(PlacedBay(band, bay, start, width, joint))
            start += width
        if band == "south" and storey.wrap and out:
            out[-1] = replace(out[-1], wrap=storey.wrap)
    return out


def _joints(groups: Sequence[BayGroup]) -> list[OpeningKind | None]:
    """Return the kind of the opening between each bay of `groups` and the bay before it; None for the first of a group."""
    return [group.joint if i else None for group in groups for i in range(len(group.bays))]
