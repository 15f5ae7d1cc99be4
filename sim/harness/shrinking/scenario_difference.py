"""The differences of two scenarios, in words."""

from collections.abc import Iterator
from dataclasses import fields

from sim.faults import Fault, written
from sim.harness.run_settings import listed_house
from sim.harness.scenario import Scenario
from sim.render.rig import RigConfig
from worlds.spec import AppearanceSpec, HouseSpec, RoomSpec


def difference(before: Scenario, after: Scenario) -> str:
    """Describe in words how the second scenario differs from the first; "nothing" if they are equal."""
    said = [*_house_differences(listed_house(before), listed_house(after))]
    for each in fields(Scenario):
        old, new = getattr(before, each.name), getattr(after, each.name)
        if each.name == "faults" and old != new:
            said.append(f"faults: {_listed(old)} -> {_listed(new)}")
        elif each.name == "rig" and old != new:
            said.append(f"rig: {_described(old)} -> {_described(new)}")
        elif each.name != "house" and old != new:
            said.append(f"{each.name}: {old} -> {new}")
    return "; ".join(said) or "nothing"


def relabelled_rooms(before: Scenario, after: Scenario) -> tuple[str, ...]:
    """Return in words which rooms have another label in the second scenario: "'hall 0.1' has the label 'kitchen'"."""
    old, new = (_rooms_by_id(listed_house(scenario)) for scenario in (before, after))
    changed = {key: room.label for key, room in new.items() if key in old and old[key].label != room.label}
    return tuple(f"{key!r} has the label {label!r}" for key, label in changed.items())


def _rooms_by_id(spec: HouseSpec) -> dict[str, RoomSpec]:
    return {room.id: room for storey in spec.storeys for room in storey.rooms}


def _described(rig: RigConfig) -> str:
    displaced = ", displaced" if any(rig.lever_arm_m + rig.lever_arm_rpy_deg) else ""
    return f"{rig.name} {rig.width}x{rig.height}{displaced}"


def _listed(faults: tuple[Fault, ...]) -> str:
    return ", ".join(map(written, faults)) or "none"


def _house_differences(before: HouseSpec, after: HouseSpec) -> Iterator[str]:
    old, new = _rooms_by_id(before), _rooms_by_id(after)
    if gone := [f"{key!r}" for key in old if key not in new]:
        yield f"without {', '.join(gone)}"
    both = [key for key in old if key in new]
    if moved := [f"{key!r}" for key in both if old[key].polygon_m != new[key].polygon_m]:
        yield f"other shape of {', '.join(moved)}"
    yield from (f"{key!r}: {old[key].label} -> {new[key].label}" for key in both if old[key].label != new[key].label)
    yield from _opening_differences(before, after, set(both), bool(moved))
    for name in ("furniture", "windows"):
        counts = [sum(len(getattr(s, name) or ()) for s in spec.storeys) for spec in (before, after)]
        if counts[0] != counts[1]:
            yield f"{name}: {counts[0]} -> {counts[1]}"
    if before.appearance != after.appearance:
        yield f"appearance: {_look(before.appearance)} -> {_look(after.appearance)}"


def _opening_differences(before: HouseSpec, after: HouseSpec, rooms: set[str], moved: bool) -> Iterator[str]:
    """Yield, in words, the openings that only one house has, among the openings between rooms of both houses.

    If walls have `moved`, the positions of openings are not compared.
    """
    listed = []
    for spec in (before, after):
        openings = [o for storey in spec.storeys for o in storey.openings if set(o.rooms) <= rooms]
        listed.append({(o.rooms, o.kind, o.leaf is not None, () if moved else (o.start_m, o.end_m)) for o in openings})
    for sign, keys in (("without", listed[0] - listed[1]), ("with", listed[1] - listed[0])):
        for (a, b), kind, leaf, _ in sorted(keys):
            yield f"{sign} the opening {a!r} - {b!r} ({kind}{' with a leaf' if leaf else ''})"


def _look(appearance: AppearanceSpec) -> str:
    return f"{appearance.light}, {appearance.texture}"
