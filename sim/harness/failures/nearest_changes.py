"""`nearest`: of several changes of a scenario, those that contain no other one of them."""

import math
from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, fields

from sim.harness.run_settings import house_spec
from sim.harness.scenario import Scenario
from worlds.spec import HouseSpec

_BY_PARTS = ("house", "faults", "length_m")
"""Fields of a scenario that are compared part by part or by size."""


@dataclass(frozen=True)
class _Extent:
    """How far a scenario is from another one."""

    changed: frozenset[Hashable]
    length_m: float
    """Length of the tour after the change [m]."""

    def contains(self, other: "_Extent") -> bool:
        """Return whether everything that the other one changes is changed here, too, and at least as much."""
        return self.changed >= other.changed and self.length_m <= other.length_m


def nearest(scenario: Scenario, changed: Sequence[Scenario]) -> list[Scenario]:
    """Return the changed scenarios without those whose changes contain all changes of another one.

    If a scenario without one room is given, a scenario without this room and another one is left out. Beside a tour of 20 m,
    one of 4 m is left out. If several scenarios have the same changes, the first is kept. All scenarios list their whole
    houses.
    """
    extents = [_Extent(_changes(scenario, other), _length_m(other)) for other in changed]
    return [
        other
        for k, (other, extent) in enumerate(zip(changed, extents, strict=True))
        if not any(
            extent.contains(smaller) and (i < k or not smaller.contains(extent))
            for i, smaller in enumerate(extents)
            if i != k
        )
    ]


def _length_m(scenario: Scenario) -> float:
    return math.inf if scenario.length_m is None else scenario.length_m


def _changes(before: Scenario, after: Scenario) -> frozenset[Hashable]:
    """Return the parts that differ, each with its new value; None stands for a part that is gone."""
    old, new = _parts(before), _parts(after)
    return frozenset((part, new.get(part)) for part in old.keys() | new.keys() if old.get(part) != new.get(part))


def _parts(scenario: Scenario) -> dict[Hashable, Hashable]:
    """Return the values of all parts of a scenario. The length of the tour is left out."""
    settings = {each.name: getattr(scenario, each.name) for each in fields(scenario) if each.name not in _BY_PARTS}
    return settings | _numbered(("fault", fault) for fault in scenario.faults) | _house_parts(house_spec(scenario))


def _house_parts(spec: HouseSpec) -> dict[Hashable, Hashable]:
    """Return the values of the parts of a house. Positions of furniture, windows and openings are left out: walls move."""
    parts: dict[Hashable, Hashable] = {"appearance": spec.appearance}
    for level, storey in enumerate(spec.storeys):
        for room in storey.rooms:
            parts |= {("outline", room.id): room.polygon_m, ("label", room.id): room.label}
        parts |= _numbered(("piece", level, piece.id) for piece in storey.furniture or ())
        parts |= _numbered(("window", level, window.room) for window in storey.windows or ())
        passages = _numbered(("opening", level, opening.rooms) for opening in storey.openings)
        kinds = ((opening.kind, opening.leaf is not None) for opening in storey.openings)
        parts |= dict(zip(passages, kinds, strict=True))
    return parts


def _numbered(parts: Iterable[Hashable]) -> dict[Hashable, Hashable]:
    """Number the parts, so that equal ones count separately."""
    count: Counter[Hashable] = Counter()
    numbered: dict[Hashable, Hashable] = {}
    for part in parts:
        numbered[part, count[part]] = True
        count[part] += 1
    return numbered
