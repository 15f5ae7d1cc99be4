"""Programmes: lists of the rooms of a storey, grouped into bays, before any room has a position.

The words used for floor plans:

- The spine is the corridor (or the hall or living room) on which the rooms of a storey open.
- A band is a row of rooms along one side of the spine.
- A bay is one slice of a band, from the spine to the outer wall. It belongs to one room, its host.
- The bays of a group stay side by side, such as a kitchen and its dining room. The joint of a group is the kind of
  opening between neighbouring bays in it.
- A programme lists the groups of a storey and says what its spine is, and whether it has a garden or a balcony.
- Twins are rooms of exactly the same shape.

Up to two small rooms may be carved from the host of a bay, which leaves the host L-, T- or U-shaped:

    plain      corner     corners    middle     inner (reached from the host only)
    +-----+    +-----+    +-----+    +-----+    +---+--+
    |     |    |     |    |     |    |     |    |   |  |
    |     |    +--+  |    +-+ +-+    | +-+ |    |   +--+   a second inner room: in the other corner
    |     |    |  |  |    | | | |    | | | |    |      |
    +-----+    +--+--+    +-+-+-+    +-+-+-+    +------+    corridor side
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from worlds.floor_plans.room_sizes import SIZES
from worlds.spec import OpeningKind

Form = Literal["plain", "corner", "corners", "middle", "inner"]
SMALL = ("toilet", "storage room", "pantry", "laundry room", "print room")
"""Labels of rooms that may be carved from a larger room."""
_PUBLIC = ("kitchen", "dining room", "living room", "lobby", "library", "open-plan office", "gym")
"""Labels of rooms that may be open to the corridor, without a door."""
_OPEN_CHAIN = ("kitchen", "dining room", "living room")
"""Labels of rooms that stand side by side, in this order or in reverse."""
_SEEDS = 2**31
_MOST_TWINS_IN_GROUP = 4
"""Greatest number of twins (rooms of exactly the same shape) that stand side by side."""
_OTHER_SEED = 1009
"""Number that is added to a seed to derive a different seed."""


@dataclass(frozen=True)
class Bay:
    """A slice of a band (a row of rooms along a corridor): a main room, the host, and the small rooms carved from it."""

    labels: tuple[str, ...]
    """Labels of the rooms in the bay: first the main room (the host), then the small rooms."""
    areas: tuple[float, ...]
    """Area chosen at random for each room, in the order of `labels` [m²]."""
    form: Form = "plain"
    """Arrangement of the small rooms; the module's docstring draws the forms."""
    flipped: bool = False
    """Whether the arrangement of the small rooms is mirrored, left for right as seen from the corridor."""
    entry: OpeningKind = "door"
    """Kind of the opening between the main room (the host) and the spine (the corridor)."""
    twin: int | None = None
    """Bays with the same twin number get exactly the same shape; None: the bay has no twin."""
    seed: int | None = None
    """Seed of the main room's furniture and finishes; the small rooms use the next numbers. None: the house's seed
    decides."""

    def apart(self, steps: int) -> "Bay":
        """Return the bay with a different seed and twin number for each value of `steps`.

        Bays with different twin numbers are no twins. With 0 `steps`, the bay does not change; a number of None stays None.
        """
        twin, seed = (None if value is None else value + _OTHER_SEED * steps for value in (self.twin, self.seed))
        return replace(self, twin=twin, seed=seed)

    def with_front(self) -> "Bay":
        """Return the bay with its small rooms carved from the back, so that the main room (the host) has the whole front."""
        return self if self.form == "plain" else replace(self, form="inner", flipped=True)


@dataclass(frozen=True)
class BayGroup:
    """A group of bays (main rooms with the small rooms carved from them) that stay side by side in a row of rooms."""

    bays: tuple[Bay, ...]
    joint: OpeningKind | None = None
    """Kind of the opening between the main rooms of neighbouring bays; None: no opening."""


@dataclass(frozen=True)
class StoreyProgramme:
    """The rooms of a storey and how they are grouped."""

    groups: tuple[BayGroup, ...]
    spine: str = "corridor"
    """Label of the room along which the other rooms stand."""
    hall: str | None = None
    """Label of the hall that takes the place of the corridor's first stretch; None: no hall."""
    garden: bool = False
    balcony: bool = False
    seed: int | None = None
    """Seed of the corridor's furniture and finishes; storeys with equal plans share it. None: the house's seed decides."""


@dataclass(frozen=True)
class LayoutShares:
    """How often the buildings of a kind have certain features of layout, as shares in [0, 1]."""

    open_plan: float = 0.0
    """Share of storeys whose kitchen, dining room and living room have no walls between them."""
    twins: float = 0.0
    """Share of rooms that get exactly the same shape as the first room with their label."""


def programme_groups(labels: Sequence[str], shares: LayoutShares, rng: np.random.Generator) -> tuple[BayGroup, ...]:
    """Group the rooms of a storey into bays, and the bays into groups. Return these in random order.

    A bay is a main room, the host, with the small rooms carved from it. The bays of a group stay side by side in one band (a
    row of rooms along the corridor).

    1. Two or three of a kitchen, a dining room and a living room become one group, because people build them side by side.
    2. Small rooms are set aside, and so are about a third of the bathrooms. All other rooms get bays of their own. Some of
       these rooms become twins (rooms of exactly the same shape) of a room with the same label.
    3. Every room that was set aside is carved from a host, since in a bay of its own it would be deep and narrow. It gets a
       bay of its own only if no host is suitable.
    4. Twins are put into groups, because only in one band do they get the same shape. Any other bay is a group of one.
    """
    left = [labels[i] for i in rng.permutation(len(labels))]
    chain = _take_chain(left, shares, rng)
    small = [label for label in left if label in SMALL or (label == "bathroom" and rng.random() < 0.35)]
    for label in small:
        left.remove(label)
    joined = list(chain.bays) if chain else []
    singles = _twins([_bay(label, rng) for label in left], shares, rng)
    bays = _carve(joined + singles, len(joined), small, rng)
    groups = _twin_groups(bays[len(joined) :])
    if chain is not None:
        groups.append(replace(chain, bays=tuple(bays[: len(joined)])))
    return tuple(groups[i] for i in rng.permutation(len(groups)))


def seeded(groups: Sequence[BayGroup], rng: np.random.Generator) -> tuple[BayGroup, ...]:
    """Return the groups of bays with a seed for every bay that has none.

    Storeys with the same groups then have equal rooms, including the furniture.
    """
    return tuple(
        replace(
            group, bays=tuple(replace(b, seed=int(rng.integers(_SEEDS)) if b.seed is None else b.seed) for b in group.bays)
        )
        for group in groups
    )


def _bay(label: str, rng: np.random.Generator) -> Bay:
    """Return a bay of one room; its area and the kind of opening to the corridor are drawn at random."""
    entry: OpeningKind = "door"
    if label in _PUBLIC and rng.random() < 0.4:
        entry = ("cased", "arch", "open")[int(rng.integers(3))] if label != "gym" else "cased"
    return Bay((label,), (_draw_area(label, rng),), flipped=bool(rng.integers(2)), entry=entry)


def _draw_area(label: str, rng: np.random.Generator) -> float:
    usual = SIZES[label].usual
    return round(float(rng.uniform(*usual)), 2)


def _take_chain(left: list[str], shares: LayoutShares, rng: np.random.Generator) -> BayGroup | None:
    """Remove a kitchen, a dining room and a living room from `left`, as far as present, and make a group of them.

    If `left` has fewer than two of these labels, nothing is removed and the result is None.
    """
    chain = [label for label in _OPEN_CHAIN if label in left]
    if len(chain) < 2:
        return None
    for label in chain:
        left.remove(label)
    if rng.random() < 0.5:
        chain.reverse()
    others: tuple[OpeningKind, ...] = ("cased", "arch", "half wall", "counter", "door")
    joint: OpeningKind = "open" if rng.random() < shares.open_plan else others[int(rng.integers(len(others)))]
    return BayGroup(tuple(_bay(label, rng) for label in chain), joint)


def _twins(bays: list[Bay], shares: LayoutShares, rng: np.random.Generator) -> list[Bay]:
    """Turn some bays with the same label into twins (equal shapes); three quarters of them get the same furniture, too."""
    first: dict[str, Bay] = {}
    out = []
    for bay in bays:
        label = bay.labels[0]
        if label in first and rng.random() < shares.twins:
            same_looks = rng.random() < 0.75
            out.append(replace(first[label], seed=first[label].seed if same_looks else int(rng.integers(_SEEDS))))
            continue
        if label not in first and [b.labels[0] for b in bays].count(label) > 1 and shares.twins > 0.0:
            bay = first[label] = replace(bay, twin=int(rng.integers(_SEEDS)), seed=int(rng.integers(_SEEDS)))
        out.append(bay)
    return out


def _twin_groups(bays: Sequence[Bay]) -> list[BayGroup]:
    """Put twins (bays of the same shape) into groups of at most `_MOST_TWINS_IN_GROUP`; other bays are groups of one.

    The twins of a group stand side by side in one band (row of rooms), because only there can they be equal to the
    centimetre. A longer group would not fit into a band. Twins that are left over form further groups, which may stand in
    other bands. Therefore, the bays of each further group get another twin number: only bays with the same number have the
    same shape.
    """
    groups = [BayGroup((bay,)) for bay in bays if bay.twin is None]
    for twin in dict.fromkeys(bay.twin for bay in bays if bay.twin is not None):
        alike = [bay for bay in bays if bay.twin == twin]
        for i in range(0, len(alike), _MOST_TWINS_IN_GROUP):
            groups.append(BayGroup(tuple(bay.apart(i) for bay in alike[i : i + _MOST_TWINS_IN_GROUP])))
    return groups


def _carve(bays: list[Bay], joined: int, small: Sequence[str], rng: np.random.Generator) -> list[Bay]:
    """Carve every small room from a host, the main room of a bay, or give it a bay of its own if no host is suitable.

    The first `joined` bays form a group with openings between neighbouring hosts. From each of these hosts, at most one room
    is carved, in a corner at the corridor, so that neighbouring hosts still share the wall behind the carved room. A room
    carved from the back could separate them.
    """
    out = list(bays)
    for label in small:
        area = _draw_area(label, rng)
        hosts = [i for i, bay in enumerate(out) if _can_host(bay, label, area, i < joined)]
        likely = [i for i in hosts if out[i].labels[0] in SIZES[label].beside]
        if not hosts:
            out.append(_bay(label, rng))
            continue
        choice = likely or hosts
        i = choice[int(rng.integers(len(choice)))]
        bay = out[i]
        form: Form = "corner" if i < joined else _form(bay, label, rng)
        out[i] = replace(bay, labels=(*bay.labels, label), areas=(*bay.areas, area), form=form, twin=None, seed=None)
    return out


def _can_host(bay: Bay, label: str, area: float, joined: bool) -> bool:
    """Return whether a small room of this area [m²] can be carved from the main room of a bay.

    The main room must not be a bathroom or one of the `SMALL` rooms, and it must be at least 2.2 times as large as all small
    rooms of the bay together. The bay must not have a room with the same label. A second small room can be carved only if
    the first is in a corner, and if the main room has no opening to a neighbouring main room (`joined`).
    """
    if bay.labels[0] in (*SMALL, "bathroom") or label in bay.labels or bay.areas[0] < 2.2 * (area + sum(bay.areas[1:])):
        return False
    return bay.form == "plain" or (not joined and bay.form == "corner")


def _form(bay: Bay, label: str, rng: np.random.Generator) -> Form:
    """Return the arrangement of a bay's small rooms after another one, with this label, is carved from the main room."""
    if bay.form == "corner":
        return "corners"
    private = label in ("pantry", "storage room") or (label == "bathroom" and bay.labels[0] == "bedroom")
    if private and rng.random() < 0.5:
        return "inner"
    return "middle" if bay.areas[0] >= 22.0 and rng.random() < 0.4 else "corner"
