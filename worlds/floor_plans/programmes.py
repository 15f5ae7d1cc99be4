"""Programmes: what a storey is to hold before it has a shape - bays of rooms, in runs that stay together.

A bay is a slice of a band of rooms along a corridor. It belongs to one room, its host, from which up to two small rooms
may be carved; these leave the host L-, T- or U-shaped:

    plain      corner     corners    middle     inner (reached from the host only)
    +-----+    +-----+    +-----+    +-----+    +---+--+
    |     |    |     |    |     |    |     |    |   |  |
    |     |    +--+  |    +-+ +-+    | +-+ |    |   +--+   two inner ones stand in both corners
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
_PUBLIC = ("kitchen", "dining room", "living room", "lobby", "library", "open-plan office", "gym")
_OPEN_CHAIN = ("kitchen", "dining room", "living room")
_SEEDS = 2**31
_ROW = 4
_OTHER_SEED = 1009


@dataclass(frozen=True)
class Bay:
    """A host and the small rooms carved from its bay."""

    labels: tuple[str, ...]
    """The host's first."""
    areas: tuple[float, ...]
    """Wished for [m²]."""
    form: Form = "plain"
    flipped: bool = False
    entry: OpeningKind = "door"
    """Between the host and what it stands along."""
    twin: int | None = None
    """Bays of the same twin number get exactly the same shape."""
    seed: int | None = None
    """Of furniture and finishes; the small rooms have the following ones."""

    def apart(self, steps: int) -> "Bay":
        """The same with other looks, and no twin of this one; itself for 0 steps."""
        twin, seed = (None if value is None else value + _OTHER_SEED * steps for value in (self.twin, self.seed))
        return replace(self, twin=twin, seed=seed)

    def with_front(self) -> "Bay":
        """The same with nothing carved from the host's front."""
        return self if self.form == "plain" else replace(self, form="inner", flipped=True)


@dataclass(frozen=True)
class BayRun:
    """Bays that stay side by side; neighbours in it are joined."""

    bays: tuple[Bay, ...]
    joint: OpeningKind | None = None


@dataclass(frozen=True)
class StoreyProgramme:
    """What a storey holds."""

    runs: tuple[BayRun, ...]
    spine: str = "corridor"
    """Label of what the bays stand along."""
    hall: str | None = None
    """Label of the first stretch of the spine, where it has one of its own."""
    garden: bool = False
    balcony: bool = False
    seed: int | None = None
    """Of the spine, on floors that repeat."""


@dataclass(frozen=True)
class Habits:
    """How the buildings of a kind are laid out."""

    open_plan: float = 0.0
    """Share of kitchens, dining and living rooms without walls between them."""
    twins: float = 0.0
    """Share of equal rooms that are built alike."""


def programme_runs(labels: Sequence[str], habits: Habits, rng: np.random.Generator) -> tuple[BayRun, ...]:
    """Group the rooms of a storey into bays and runs, in random order."""
    left = [labels[i] for i in rng.permutation(len(labels))]
    chain = _take_chain(left, habits, rng)
    small = [label for label in left if label in SMALL or (label == "bathroom" and rng.random() < 0.35)]
    for label in small:
        left.remove(label)
    joined = list(chain.bays) if chain else []
    singles = _twins([_bay(label, rng) for label in left], habits, rng)
    bays = _carve(joined + singles, len(joined), small, rng)
    runs = _rows(bays[len(joined) :])
    if chain is not None:
        runs.append(replace(chain, bays=tuple(bays[: len(joined)])))
    return tuple(runs[i] for i in rng.permutation(len(runs)))


def seeded(runs: Sequence[BayRun], rng: np.random.Generator) -> tuple[BayRun, ...]:
    """The same runs with a seed for every bay: storeys that have them are twins, their rooms alike in every way."""
    return tuple(
        replace(run, bays=tuple(replace(b, seed=int(rng.integers(_SEEDS)) if b.seed is None else b.seed) for b in run.bays))
        for run in runs
    )


def _bay(label: str, rng: np.random.Generator) -> Bay:
    entry: OpeningKind = "door"
    if label in _PUBLIC and rng.random() < 0.4:
        entry = ("cased", "arch", "open")[int(rng.integers(3))] if label != "gym" else "cased"
    return Bay((label,), (_draw_area(label, rng),), flipped=bool(rng.integers(2)), entry=entry)


def _draw_area(label: str, rng: np.random.Generator) -> float:
    usual = SIZES[label].usual
    return round(float(rng.uniform(*usual)), 2)


def _take_chain(left: list[str], habits: Habits, rng: np.random.Generator) -> BayRun | None:
    """One kitchen, dining and living room each, where there are at least two of them."""
    chain = [label for label in _OPEN_CHAIN if label in left]
    if len(chain) < 2:
        return None
    for label in chain:
        left.remove(label)
    if rng.random() < 0.5:
        chain.reverse()
    others: tuple[OpeningKind, ...] = ("cased", "arch", "half wall", "counter", "door")
    joint: OpeningKind = "open" if rng.random() < habits.open_plan else others[int(rng.integers(len(others)))]
    return BayRun(tuple(_bay(label, rng) for label in chain), joint)


def _twins(bays: list[Bay], habits: Habits, rng: np.random.Generator) -> list[Bay]:
    """Make some of the bays with the same label alike in shape, most of these in looks, too."""
    first: dict[str, Bay] = {}
    out = []
    for bay in bays:
        label = bay.labels[0]
        if label in first and rng.random() < habits.twins:
            same_looks = rng.random() < 0.75
            out.append(replace(first[label], seed=first[label].seed if same_looks else int(rng.integers(_SEEDS))))
            continue
        if label not in first and [b.labels[0] for b in bays].count(label) > 1 and habits.twins > 0.0:
            bay = first[label] = replace(bay, twin=int(rng.integers(_SEEDS)), seed=int(rng.integers(_SEEDS)))
        out.append(bay)
    return out


def _rows(bays: Sequence[Bay]) -> list[BayRun]:
    """Twins stand side by side, at most `_ROW` of them: only in one band can they be alike to the centimetre."""
    runs = [BayRun((bay,)) for bay in bays if bay.twin is None]
    for twin in dict.fromkeys(bay.twin for bay in bays if bay.twin is not None):
        alike = [bay for bay in bays if bay.twin == twin]
        for i in range(0, len(alike), _ROW):
            runs.append(BayRun(tuple(bay.apart(i) for bay in alike[i : i + _ROW])))
    return runs


def _carve(bays: list[Bay], joined: int, small: Sequence[str], rng: np.random.Generator) -> list[Bay]:
    """Give every small room a host; those for whom there is none get bays of their own.

    The first `joined` bays stay joined: nothing is carved from behind, where it would part them.
    """
    out = list(bays)
    for label in small:
        area = _draw_area(label, rng)
        hosts = [i for i, bay in enumerate(out) if _takes(bay, label, area, i < joined)]
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


def _takes(bay: Bay, label: str, area: float, joined: bool) -> bool:
    if bay.labels[0] in (*SMALL, "bathroom") or label in bay.labels or bay.areas[0] < 2.2 * (area + sum(bay.areas[1:])):
        return False
    return bay.form == "plain" or (not joined and bay.form == "corner")


def _form(bay: Bay, label: str, rng: np.random.Generator) -> Form:
    if bay.form == "corner":
        return "corners"
    private = label in ("pantry", "storage room") or (label == "bathroom" and bay.labels[0] == "bedroom")
    if private and rng.random() < 0.5:
        return "inner"
    return "middle" if bay.areas[0] >= 22.0 and rng.random() < 0.4 else "corner"
