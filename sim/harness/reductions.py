"""Steps that make a scenario simpler, the size by which scenarios are compared, and the differences of two scenarios."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from types import MappingProxyType
from typing import Any, NamedTuple

from shapely.geometry import Polygon

from sim.errors import SimError
from sim.harness import house_reductions as house_steps
from sim.harness.parts import house_spec, in_house
from sim.harness.scenario import NEEDS_PIXELS, Scenario
from sim.harness.walk import shortest_walk_m
from sim.render.rig import RIGS, RigConfig
from sim.wording import counted
from worlds.errors import WorldsError
from worlds.labels import ROOM_LABELS
from worlds.spec import AppearanceSpec, HouseSpec, RoomSpec
from worlds.variant import explicit

Step = Callable[[Scenario], Iterator[Scenario]]
_MIN_LENGTH_M = 4.0
_FIRST_LENGTHS_M = (10.0, 20.0, 40.0)
"""Lengths that `shorter_tour` tries for scenarios without a requested length [m]."""
_SMALL_PX = (240, 180)
_FEW_HZ = 4.0
"""Frame rate to which `fewer_frames` goes down [Hz]. LEXIS adds a keyframe every 0.7 s, and needs two frames for each."""
_PLAIN_MOTION: Mapping[str, Any] = MappingProxyType(
    {"sway": "none", "start_manoeuvre": False, "tour_kind": "rooms", "reverse": False}
)
"""The simplest motion, as fields of a scenario."""


class ScenarioSize(NamedTuple):
    """The size of a scenario. Sizes are compared as tuples, so the first entry is the most important one."""

    storeys: int
    rooms: int
    openings: int
    furniture: int
    windows: int
    faults: int
    drift: int
    """Number of kinds of odometry error, 0 to 2: poses that drift, and covariances that are too small."""
    motion: int
    """Number of complications of the motion: sway, start manoeuvre, a reversed tour, a kind of tour other than "rooms"."""
    length_m: float
    """Requested length of the tour [m]; infinite if the kind of tour decides."""
    corners: int
    area_m2: float
    opening_ranks: int
    """Sum of `opening_rank` over all openings: 0 if all openings are doorways without door leaves."""
    labels: int
    """Sum of the rooms' label indices in `ROOM_LABELS`, where simple labels come first."""
    appearance: int
    """Number of unusual looks: lighting other than daylight, and textures that are not rich."""
    frame_rate_hz: float
    rig: tuple[int, int, int]
    """Index of the rig in `RIGS`, 1 if the rig is displaced on the body (else 0), and number of pixels of an image."""

    def __str__(self) -> str:
        walk = f"{self.length_m:g} m" if math.isfinite(self.length_m) else "whole tour"
        return f"{counted(self.rooms, 'room')}, {walk}"


def size(scenario: Scenario) -> ScenarioSize:
    """Compute the size of a scenario. Raises `SimError` unless it lists its whole house; see `with_listed_house`."""
    spec = _listed(scenario)
    rooms = [room for storey in spec.storeys for room in storey.rooms]
    openings = [opening for storey in spec.storeys for opening in storey.openings]
    rig = scenario.rig
    return ScenarioSize(
        storeys=len(spec.storeys),
        rooms=len(rooms),
        openings=len(openings),
        furniture=sum(len(storey.furniture or ()) for storey in spec.storeys),
        windows=sum(len(storey.windows or ()) for storey in spec.storeys),
        faults=len(scenario.faults),
        drift=(scenario.odometry != "perfect") + (scenario.overconfidence > 1.0),
        motion=sum(getattr(scenario, name) != usual for name, usual in _PLAIN_MOTION.items()),
        length_m=math.inf if scenario.length_m is None else scenario.length_m,
        corners=sum(len(room.polygon_m) for room in rooms),
        area_m2=round(sum(Polygon(room.polygon_m).area for room in rooms), 6),
        opening_ranks=sum(map(house_steps.opening_rank, openings)),
        labels=sum(ROOM_LABELS.index(room.label) for room in rooms),
        appearance=(spec.appearance.light != "day") + (spec.appearance.texture != "rich"),
        frame_rate_hz=scenario.frame_rate_hz,
        rig=(list(RIGS).index(rig.name), int(any(rig.lever_arm_m + rig.lever_arm_rpy_deg)), rig.width * rig.height),
    )


def with_listed_house(scenario: Scenario) -> Scenario:
    """Return a scenario of the same run that lists all rooms, furniture and windows, and the length of the tour.

    Raises `WorldsError` for a house that cannot be built.
    """
    return in_house(scenario, explicit(house_spec(scenario)))


def with_features(scenario: Scenario) -> Scenario:
    """Return the scenario with fidelity "features", without the faults that only images can show."""
    faults = tuple(fault for fault in scenario.faults if not isinstance(fault, NEEDS_PIXELS))
    return replace(scenario, fidelity="features", faults=faults)


def _listed(scenario: Scenario) -> HouseSpec:
    spec = scenario.house
    if spec is None or any(storey.furniture is None or storey.windows is None for storey in spec.storeys):
        raise SimError("scenario: its house does not list everything; valid: the result of with_listed_house()")
    return spec


def _on_house(step: house_steps.HouseStep) -> Step:
    def apply(scenario: Scenario) -> Iterator[Scenario]:
        return (replace(scenario, house=spec) for spec in step(_listed(scenario)))

    return apply


def fewer_faults(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with fewer faults.

    All faults are left out first, then each half of the faults, each quarter, and so on down to each single fault.
    """
    return (replace(scenario, faults=tuple(left)) for left in house_steps.without_parts(scenario.faults))


def no_drift(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with simpler errors of the odometry.

    First the odometry is perfect and its covariances match its errors, then each of these changes is made alone.
    """
    if scenario.odometry != "perfect":
        yield replace(scenario, odometry="perfect", overconfidence=1.0)
        yield replace(scenario, odometry="perfect")
    if scenario.overconfidence > 1.0:
        yield replace(scenario, overconfidence=1.0)


def plain_motion(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with the simplest motion, then with each part of the simplest motion alone.

    The simplest motion is a tour of the rooms, not in reverse, without sway and without a start manoeuvre.
    """
    each = (replace(scenario, **{name: usual}) for name, usual in _PLAIN_MOTION.items())
    yield from dict.fromkeys(other for other in (replace(scenario, **_PLAIN_MOTION), *each) if other != scenario)


def shorter_tour(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with the shortest possible tour, then with shorter requested lengths, the shortest first.

    The lengths are an eighth, a quarter, a half, ... of the requested length or, if none is requested, 10, 20 and 40 m.
    """
    least_m = _least_length_m(scenario)
    yield from _if_shorter(scenario, least_m)
    if scenario.length_m is None:
        yield from (replace(scenario, length_m=length_m) for length_m in _FIRST_LENGTHS_M)
        return
    for share in (0.125, 0.25, 0.5, 0.75, 0.9):
        length_m = float(math.floor(scenario.length_m * share))
        if length_m > least_m:
            yield replace(scenario, length_m=length_m)


def smaller_rig(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with a single wide camera in the middle of the body, then with smaller images of all cameras."""
    rig = scenario.rig
    plain = RigConfig(next(iter(RIGS)), rig.width, rig.height, rig.hfov_deg)
    if plain != rig:
        yield replace(scenario, rig=plain)
    if (small := _with_small_images(rig)) != rig:
        yield replace(scenario, rig=small)


def _with_small_images(rig: RigConfig) -> RigConfig:
    """Return the rig with images of size `_SMALL_PX`, or unchanged if its images have no more pixels than that."""
    width, height = _SMALL_PX
    return replace(rig, width=width, height=height) if rig.width * rig.height > width * height else rig


def fewer_frames(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with four frames per second, if it has more."""
    if scenario.frame_rate_hz > _FEW_HZ:
        yield replace(scenario, frame_rate_hz=_FEW_HZ)


def quicker_to_render(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with fewer and smaller images: first on the shortest possible tour, then on the present tour."""
    quick = replace(scenario, rig=_with_small_images(scenario.rig), frame_rate_hz=min(scenario.frame_rate_hz, _FEW_HZ))
    yield from _walking_least(quick)
    if quick != scenario:
        yield quick


def _walking_least(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario with the shortest possible tour, if there is one and it is shorter than the present tour."""
    return _if_shorter(scenario, _least_length_m(scenario))


def _if_shorter(scenario: Scenario, length_m: float) -> Iterator[Scenario]:
    if length_m < (scenario.length_m or math.inf):
        yield replace(scenario, length_m=length_m)


def _least_length_m(scenario: Scenario) -> float:
    """Return the length of the shortest possible tour [m], rounded up.

    It is at least `_MIN_LENGTH_M`, and infinite if no tour is possible.
    """
    try:
        return max(_MIN_LENGTH_M, float(math.ceil(shortest_walk_m(scenario))))
    except (SimError, WorldsError):
        return math.inf


def _also_walking_least(step: Step) -> Step:
    """Extend a step: if a scenario has the shortest possible tour, its candidates first get their own shortest tours.

    Then, and for all other scenarios, the candidates keep the requested length of the scenario.
    """

    def apply(scenario: Scenario) -> Iterator[Scenario]:
        if scenario.length_m == _least_length_m(scenario):
            yield from (least for candidate in step(scenario) for least in _walking_least(candidate))
        yield from step(scenario)

    return apply


STEPS: dict[str, Step] = {
    "drop storeys": _on_house(house_steps.fewer_storeys),
    "drop rooms": _on_house(house_steps.fewer_rooms),
    "drop faults": fewer_faults,
    "drop drift": no_drift,
    "plain motion": plain_motion,
    "shorten the tour": shorter_tour,
    "drop furniture": _on_house(house_steps.less_furniture),
    "close openings": _on_house(house_steps.fewer_openings),
    "drop windows": _on_house(house_steps.fewer_windows),
    "rectangular rooms": _on_house(house_steps.rectangular),
    "smaller rooms": _on_house(house_steps.cropped),
    "move walls together": _on_house(house_steps.narrower),
    "simpler openings": _on_house(house_steps.simpler_openings),
    "simplest labels": _on_house(house_steps.simpler_labels),
    "daylight": _on_house(house_steps.plain_appearance),
    "fewer frames": fewer_frames,
    "smaller rig": smaller_rig,
}
"""All steps by name, in the order in which the reducer tries them: the steps that remove the most come first."""
_LEAST_RENDERED = ("drop storeys", "drop rooms")
"""Steps whose candidates are first tried with their shortest tours in a search on images."""
_COSTLY_FIRST = ("fewer frames", "smaller rig", "shorten the tour")
"""Steps that come first in a search on images, because every later candidate is then quicker to render."""


def for_images(steps: Mapping[str, Step]) -> dict[str, Step]:
    """Return the steps for a search in which every candidate is rendered: the steps that save rendering come first."""
    quick = {"fewer frames and shortest tour": quicker_to_render} if set(_COSTLY_FIRST) <= steps.keys() else {}
    first = {name: steps[name] for name in _COSTLY_FIRST if name in steps}
    short = {name: _also_walking_least(steps[name]) for name in _LEAST_RENDERED if name in steps and quick}
    return quick | first | dict(steps) | short


def difference(before: Scenario, after: Scenario) -> str:
    """Describe in words how the second scenario differs from the first; "nothing" if they are equal."""
    said = [*_house_differences(_listed(before), _listed(after))]
    for each in fields(Scenario):
        old, new = getattr(before, each.name), getattr(after, each.name)
        if each.name == "faults" and old != new:
            said.append(f"faults: {_names(old)} -> {_names(new)}")
        elif each.name == "rig" and old != new:
            said.append(f"rig: {old.name} {old.width}x{old.height} -> {new.name} {new.width}x{new.height}")
        elif each.name != "house" and old != new:
            said.append(f"{each.name}: {old} -> {new}")
    return "; ".join(said) or "nothing"


def relabelled_rooms(before: Scenario, after: Scenario) -> tuple[str, ...]:
    """Return in words which rooms of the first scenario have another label in the second: "'hall 0.1' is a kitchen"."""
    old, new = (_rooms_by_id(_listed(scenario)) for scenario in (before, after))
    return tuple(f"{key!r} is a {room.label}" for key, room in new.items() if key in old and old[key].label != room.label)


def _rooms_by_id(spec: HouseSpec) -> dict[str, RoomSpec]:
    return {room.id: room for storey in spec.storeys for room in storey.rooms}


def _names(faults: tuple[object, ...]) -> str:
    return ", ".join(getattr(fault, "name", "") for fault in faults) or "none"


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
