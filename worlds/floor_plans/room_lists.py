"""Room lists: which rooms a building of a given kind has, and on which storeys they are.

The result is a programme for each storey (see `programmes`): its rooms in groups, without positions.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from worlds.floor_plans.building_kinds import BuildingKind
from worlds.floor_plans.floor_plan import PlanStyle
from worlds.floor_plans.programmes import SMALL, LayoutShares, StoreyProgramme, programme_groups, seeded
from worlds.floor_plans.room_sizes import SIZES
from worlds.labels import OUTDOOR_LABELS
from worlds.spec import OpeningKind

_BELOW = ("living room", "kitchen", "dining room", "garage", "pantry", "lobby", "entrance hall")
"""Labels of rooms that belong on the ground storey of a building with several storeys."""
_ONCE = ("living room", "kitchen", "dining room", "garage", "garden", "pantry", "lobby")
"""Labels that are drawn at most once for a building."""
_SEEDS = 2**31


def draw_programmes(
    kind: BuildingKind, rooms: int, storeys: int, rng: np.random.Generator
) -> tuple[tuple[StoreyProgramme, ...], PlanStyle]:
    """Return the programme of every storey of a building, lowest first, and the style in which it is laid out.

    `rooms` counts the rooms of the whole building, without corridors, halls and stairs; it is at least `storeys`.

    1. Draw the labels of the rooms.
    2. A building of several storeys may repeat its upper storeys (`BuildingKind.repeats`).
    3. A home of one storey with few rooms, but not with a living room alone, may have it in place of the corridor.
    4. In all other cases `by_storey` shares the rooms among the storeys, and `programmes_of` groups them on each storey.
    """
    labels = _labels(kind, rooms, storeys, rng)
    hall = kind.halls[int(rng.integers(len(kind.halls)))]
    if storeys > 1 and rooms >= 3 * storeys and rng.random() < kind.repeats:
        same = _repeating(labels, storeys, hall, kind, rng)
        if same is not None:
            return same, kind.style
    indoors = [label for label in labels if label not in OUTDOOR_LABELS]
    small = storeys == 1 and rooms <= 6 and "living room" in labels and len(indoors) > 1
    if small and rng.random() < (0.5 if rooms > 3 else 1.0):
        return _around_a_living_room(labels, kind, rng)
    return programmes_of(by_storey(labels, storeys, kind.upstairs, rng), kind.shares, hall, rng), kind.style


def programmes_of(
    labels: Sequence[Sequence[str]], shares: LayoutShares, hall: str | None, rng: np.random.Generator
) -> tuple[StoreyProgramme, ...]:
    """Return the programme of every storey, lowest first, for the labels of its rooms.

    Only the ground storey gets `hall`.
    """
    return tuple(_storey(own, shares, rng, None if level else hall) for level, own in enumerate(labels))


def by_storey(labels: Sequence[str], storeys: int, upstairs: Sequence[str], rng: np.random.Generator) -> list[list[str]]:
    """Share rooms among storeys. Return the labels on every storey, lowest first; every storey gets an indoor room.

    `labels` must have at least one indoor room and at most one balcony per storey.

    1. Labels in `_BELOW` go to the ground storey. Labels in `upstairs` go to the upper storey that has the least area so
       far, and all others to the storey with the least area so far. In this comparison the ground storey counts as 10 m²
       smaller than it is, so that it becomes larger: it has to bear the others. Small rooms are assigned late, to even out
       the areas.
    2. Every empty storey takes a room from the storey with most rooms.
    3. The storeys are sorted by area, since every storey stands on the storey below; a storey with labels in `_BELOW` comes
       first. `_settle` then makes sure that no upper storey is much larger than the ground storey.
    4. The garden goes to the ground storey. Balconies go to storeys drawn at random, at most one to each.
    """
    out: list[list[str]] = [[] for _ in range(storeys)]
    area = [0.0] * storeys
    indoors = [label for label in labels if label not in OUTDOOR_LABELS]
    for label in sorted(indoors, key=lambda label: (label not in _BELOW, label in SMALL, label in upstairs)):
        wanted = [k for k in range(storeys) if k > 0 or label not in upstairs] if storeys > 1 else [0]
        if label in _BELOW:
            wanted = [0]
        level = min(wanted, key=lambda k: area[k] - 10.0 * (k == 0))
        out[level].append(label)
        area[level] += _area([label])
    _fill_empty(out)
    out.sort(key=lambda own: (not set(own) & set(_BELOW), -_area(own)))
    _settle(out)
    out[0] += [label for label in labels if label == "garden"]
    # A storey has at most one balcony, and the storey with the garden is the last to get a balcony.
    levels = sorted(rng.permutation(storeys).tolist(), key=lambda k: k == 0 and "garden" in labels)
    for level in levels[: labels.count("balcony")]:
        out[level].append("balcony")
    return out


def _area(labels: Sequence[str]) -> float:
    """Return the sum of the usual areas of the indoor rooms among `labels` [m²]."""
    return sum(sum(SIZES[label].usual) / 2 for label in labels if label not in OUTDOOR_LABELS)


def _settle(storeys: list[list[str]]) -> None:
    """Exchange rooms so that no upper storey is much larger than the ground storey, and sort the upper storeys by area.

    If an upper storey is more than 15 % larger, all its rooms are exchanged with those rooms of the ground storey that are
    not in `_BELOW`. The largest upper storey comes first.
    """
    for level in range(1, len(storeys)):
        fixed, free = ([label for label in storeys[0] if (label in _BELOW) == below] for below in (True, False))
        if free and _area(storeys[level]) > 1.15 * _area(storeys[0]):
            storeys[0], storeys[level] = fixed + storeys[level], free
    storeys[1:] = sorted(storeys[1:], key=_area, reverse=True)


def _fill_empty(storeys: list[list[str]]) -> None:
    for own in storeys:
        if not own:
            richest = max(storeys, key=len)
            own.append(richest.pop())


def _labels(kind: BuildingKind, rooms: int, storeys: int, rng: np.random.Generator) -> list[str]:
    """Draw the labels of a building's rooms, with at least as many indoor rooms as storeys.

    The labels in the kind's `first` are taken first, slightly shuffled for some kinds; further labels are drawn from `more`.
    """
    order = list(kind.first)
    if kind.shuffled:
        keys = np.arange(len(order)) + rng.uniform(0, kind.shuffled, len(order))
        order = [order[i] for i in np.argsort(keys)]
    pool: list[str] = []
    while len(order) < rooms:
        # Every label of the list is drawn once before any is drawn again.
        pool = pool or [kind.more[i] for i in rng.permutation(len(kind.more))]
        label = pool.pop()
        most = storeys if label == "balcony" else 1 if label in _ONCE else rooms
        if order.count(label) < most:
            order.append(label)
    drawn = order[:rooms]
    while sum(label not in OUTDOOR_LABELS for label in drawn) < storeys:
        drawn[next(i for i, label in enumerate(drawn) if label in OUTDOOR_LABELS)] = "storage room"
    return drawn


def _repeating(
    labels: Sequence[str], storeys: int, hall: str | None, kind: BuildingKind, rng: np.random.Generator
) -> tuple[StoreyProgramme, ...] | None:
    """Return the programmes of a building whose upper storeys are all equal.

    The ground storey is equal to the upper storeys, too, apart from its `hall`, if the rooms divide evenly among the storeys
    and there is no garden. The result is None if the upper storeys would have no indoor room, if the ground storey would be
    smaller than the upper storeys, which stand on it, if a storey would have two balconies, or an upper storey a garage.
    """
    share = len(labels) // storeys
    equal = len(labels) == share * storeys and "garden" not in labels
    inside = [label for label in labels if label != "garden"]
    above = inside[:share] if equal else inside[len(inside) - share :]
    ground = [*inside[: len(inside) - share * (storeys - 1)], *["garden"] * (len(labels) - len(inside))]
    if max(above.count("balcony"), ground.count("balcony")) > 1 or "garage" in above:
        return None
    if not 0.0 < _area(above) <= _area(above if equal else ground):
        return None
    upper = _storey(above, kind.shares, rng, None)
    upper = replace(upper, seed=int(rng.integers(_SEEDS)), groups=seeded(upper.groups, rng))
    first = replace(upper, hall=hall) if equal else _storey(ground, kind.shares, rng, hall)
    return (first, *[upper] * (storeys - 1))


def _around_a_living_room(
    labels: Sequence[str], kind: BuildingKind, rng: np.random.Generator
) -> tuple[tuple[StoreyProgramme, ...], PlanStyle]:
    """Return the programme and style of a small home whose rooms stand along the living room, not a corridor."""
    others = list(labels)
    others.remove("living room")
    storey = _storey(others, kind.shares, rng, None)
    opens: tuple[OpeningKind, ...] = ("open", "cased", "arch", "half wall")
    groups = []
    for group in storey.groups:
        public = group.bays[0].labels[0] in ("kitchen", "dining room") and rng.random() < max(kind.shares.open_plan, 0.5)
        entry = opens[int(rng.integers(len(opens)))] if public else "door"
        groups.append(replace(group, bays=tuple(replace(bay, entry=entry) for bay in group.bays)))
    style = replace(kind.style, spine_m=(3.5, 4.6), one_sided_m=(5.0, 8.0), wings=0.0, spine_m2=16.0)
    return (replace(storey, groups=tuple(groups), spine="living room"),), style


def _storey(labels: Sequence[str], shares: LayoutShares, rng: np.random.Generator, hall: str | None) -> StoreyProgramme:
    inside = [label for label in labels if label not in OUTDOOR_LABELS]
    groups = programme_groups(inside, shares, rng)
    return StoreyProgramme(groups, hall=hall, garden="garden" in labels, balcony="balcony" in labels)
