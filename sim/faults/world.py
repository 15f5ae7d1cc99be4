"""Faults of the world: furniture, doors and people change during a tour. The stream of observations is left alone."""

from abc import abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from sim.faults.closing_doors import ClosingDoors, all_leaves
from sim.faults.fault import Fault, setting
from sim.faults.moved_furniture import with_furniture_moved
from sim.faults.person import Person, draw_person
from sim.render.actor import Actor
from sim.tours.tour import Tour
from worlds.house import House


@dataclass(frozen=True, eq=False)
class WorldState:
    """State of the world: the static house and the actors (people and doors) that move in it."""

    house: House
    actors: tuple[Actor, ...] = ()


@dataclass(frozen=True)
class WorldFault(Fault):
    """A change of the world during the tour. While it lasts, the truth of all frames names it, in view or not."""

    at_s: float | None = setting(None, 0.0, kw_only=True)
    """Time after the start of the tour at which the change happens [s]. None stands for half of the tour's duration. In a
    tour of two laps, this is between the laps."""
    for_s: float = setting(np.inf, 0.0, kw_only=True)
    """Duration of the change [s]."""

    def span_s(self, tour: Tour) -> tuple[float, float]:
        """Return the times at which the change starts and ends, counted from the start of the tour [s]."""
        start = float(tour.stamps[-1]) / 2 if self.at_s is None else self.at_s
        return start, start + self.for_s

    @abstractmethod
    def change(self, state: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """Return the state of the world while the fault lasts; `state` is the state without this fault."""


@dataclass(frozen=True)
class MovedFurniture(WorldFault):
    """Furniture is moved within its room, with the objects on it. It keeps clear of the rest of the tour's path."""

    name = "moved-furniture"
    share: float = setting(0.3, 0.0, 1.0)
    """Share of the loose pieces on the floor that are moved. Pieces without free space to move stay in place."""
    within_m: float = setting(1.5, 0.0)
    """Largest shift of a piece [m]."""
    turn_rad: float = setting(0.5, 0.0, np.pi)
    """Largest rotation of a piece [rad]."""

    def change(self, state: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """Return the world with moved furniture."""
        later = tour.T_W_B[tour.stamps >= self.span_s(tour)[0], :3, 3]
        pieces = with_furniture_moved(state.house, later, self.share, self.within_m, self.turn_rad, rng)
        return replace(state, house=replace(state.house, furniture=pieces))


@dataclass(frozen=True)
class ClosedDoors(WorldFault):
    """Doors are closed. They open when the body comes near, and close behind the body. Doorways without a door get one."""

    name = "closed-doors"
    share: float = setting(1.0, 0.0, 1.0)
    """Share of the house's doorways whose doors are closed in this way."""

    def change(self, state: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """Return the world with a share of its doors replaced by doors that are open only near the body."""
        leaves = tuple(leaf for leaf in all_leaves(state.house) if rng.random() < self.share)
        closing = {leaf.id for leaf in leaves}
        standing = tuple(leaf for leaf in state.house.leaves if leaf.id not in closing)
        return WorldState(replace(state.house, leaves=standing), (*state.actors, ClosingDoors(leaves)))


@dataclass(frozen=True)
class Pedestrian(WorldFault):
    """A person walks along the tour's path, ahead of the camera and faster than the camera, through the view and away."""

    name = "person"
    pace: float = setting(1.35, 0.0, 5.0, kw_only=True)
    """Speed of the person, as a multiple of the tour's speed."""
    ahead_s: float = setting(2.0, 0.0, kw_only=True)
    """Time that the camera needs to reach the place where the person first appears [s]."""
    for_s: float = setting(20.0, 0.0, kw_only=True)
    """Duration for which the person is present [s]."""

    def change(self, state: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """Return the world with a person who walks in it."""
        start, _ = self.span_s(tour)
        person = Person(tour, start, self.ahead_s, self.pace, draw_person(rng))
        return replace(state, actors=(*state.actors, person))
