"""Steps that make a scenario simpler: each takes a scenario and yields simpler ones. `STEPS` has all of them."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from sim.errors import SimError
from sim.harness.run_settings import listed_house
from sim.harness.scenario import NEEDS_PIXELS, Scenario
from sim.harness.shrinking import house_reductions as house_steps
from sim.harness.shrinking import wall_reductions as wall_steps
from sim.harness.shrinking.scenario_size import PLAIN_MOTION
from sim.harness.walk import shortest_walk_m
from sim.render.rig import RIGS, RigConfig
from worlds.errors import WorldsError

Step = Callable[[Scenario], Iterator[Scenario]]
_MIN_LENGTH_M = 4.0
_FIRST_LENGTHS_M = (10.0, 20.0, 40.0)
"""Lengths that `shorter_tour` tries for scenarios without a requested length [m]."""
_SMALL_PX = (240, 180)
_FEW_HZ = 4.0
"""Frame rate to which `fewer_frames` goes down [Hz]. LEXIS adds a keyframe every 0.7 s, and needs two frames for each."""


def with_features(scenario: Scenario) -> Scenario:
    """Return the scenario with fidelity "features", without the faults that only images can show."""
    faults = tuple(fault for fault in scenario.faults if not isinstance(fault, NEEDS_PIXELS))
    return replace(scenario, fidelity="features", faults=faults)


def _on_house(step: house_steps.HouseStep) -> Step:
    def apply(scenario: Scenario) -> Iterator[Scenario]:
        return (replace(scenario, house=spec) for spec in step(listed_house(scenario)))

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
    each = (replace(scenario, **{name: usual}) for name, usual in PLAIN_MOTION.items())
    yield from dict.fromkeys(other for other in (replace(scenario, **PLAIN_MOTION), *each) if other != scenario)


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
    "rectangular rooms": _on_house(wall_steps.rectangular),
    "smaller rooms": _on_house(wall_steps.cropped),
    "move walls together": _on_house(wall_steps.narrower),
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
