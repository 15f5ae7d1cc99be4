"""What a run and a recording of it share: the house, the way through it, and the odometry along that way."""

from dataclasses import dataclass

from sim.harness.config import RunConfig
from sim.harness.parts import house_spec, odometry_config, random_streams, tour_config
from sim.odometry.simulation import Odometry, tour_odometry
from sim.tours.tour import Tour, plan_tour
from worlds.house import House
from worlds.validation import built_and_checked
from worlds.walkable import Walkable


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk through a house before anything is seen on it."""

    house: House
    walkable: Walkable
    tour: Tour
    odometry: Odometry


def walk(config: RunConfig) -> Walk:
    """The walk that `config` describes. Raises `WorldsError` or `SimError` where it asks for what cannot be."""
    streams = random_streams(config)
    house = built_and_checked(house_spec(config))
    walkable = Walkable(house)
    tour = plan_tour(house, walkable, streams["tour"], tour_config(config))
    odometry = tour_odometry(tour, odometry_config(config), streams["odometry"])
    return Walk(house, walkable, tour, odometry)
