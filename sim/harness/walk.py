"""The part of a run that needs neither images nor a SLAM: the house, the tour through the house, and the odometry."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from sim.harness.run_settings import house_spec, odometry_config, tour_config
from sim.harness.scenario import Scenario
from sim.odometry.simulation import Odometry, tour_odometry
from sim.random_streams import RandomStream, random_generator
from sim.tours.tour import Tour, plan_tour, shortest_length
from worlds.furniture.kinds import Kind
from worlds.furniture.registry import own_kinds
from worlds.house import House
from worlds.validation import built_and_checked
from worlds.walkable import Walkable

_IRRELEVANT = ("fidelity", "encoder", "feature_model", "faults", "rig")
"""Settings of a scenario that do not affect its walk."""


@dataclass(frozen=True, eq=False)
class Walk:
    """A house, the tour through it and the odometry along the tour; nothing is rendered yet."""

    house: House
    walkable: Walkable
    tour: Tour
    odometry: Odometry


def shortest_walk_m(scenario: Scenario) -> float:
    """Return the length of the shortest tour of the scenario's kind through its house [m].

    Raises `WorldsError` for a house that is not valid, and `SimError` where no walk is possible.
    """
    house = built_and_checked(house_spec(scenario))
    return shortest_length(house, Walkable(house), random_generator(scenario.seed, RandomStream.TOUR), tour_config(scenario))


def with_walk_m(scenario: Scenario, length_m: float) -> Scenario:
    """Return the scenario with a tour of `length_m` [m], or with the shortest possible tour if that is longer.

    Raises `WorldsError` for a house that is not valid, and `SimError` where no walk is possible.
    """
    return replace(scenario, length_m=max(length_m, float(math.ceil(shortest_walk_m(scenario)))))


def walk(scenario: Scenario) -> Walk:
    """Build and validate the house, plan the tour, and draw the odometry. Raises `WorldsError` or `SimError`.

    The eight walks that were used last are remembered, because scenarios that are run one after the other often differ only
    in faults, cameras or the SLAM, and because the houses of a group of scenarios, such as five values of openness, are
    sampled together before they are run.
    """
    usual = Scenario()
    return _walk(replace(scenario, **{name: getattr(usual, name) for name in _IRRELEVANT}), own_kinds())


@lru_cache(maxsize=8)
def _walk(scenario: Scenario, kinds: tuple[Kind, ...]) -> Walk:
    """Make the walk of a scenario, whose house may have furniture of the given `kinds` of the user."""
    tour_rng, odometry_rng, frame_rng = (
        random_generator(scenario.seed, stream)
        for stream in (RandomStream.TOUR, RandomStream.ODOMETRY, RandomStream.ODOMETRY_FRAME)
    )
    house = built_and_checked(house_spec(scenario))
    walkable = Walkable(house)
    tour = plan_tour(house, walkable, tour_rng, tour_config(scenario))
    odometry = tour_odometry(tour, odometry_config(scenario), odometry_rng)
    return Walk(house, walkable, tour, odometry.in_random_frame(frame_rng))
