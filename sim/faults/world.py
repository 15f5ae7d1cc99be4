"""Faults of the world: it is not any more as it was seen before. They change the stage, not the stream."""

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
    """What there is to see: what stands, and what moves."""

    house: House
    actors: tuple[Actor, ...] = ()


@dataclass(frozen=True)
class WorldFault(Fault):
    """A change of the world at some time of the tour; it is recorded in all frames of its span, seen or not."""

    at_s: float | None = setting(None, 0.0, kw_only=True)
    """When it happens, after the start of the tour [s]; None: halfway, so between two laps."""
    for_s: float = setting(np.inf, 0.0, kw_only=True)
    """How long it lasts [s]."""

    def span_s(self, tour: Tour) -> tuple[float, float]:
        """Its begin and end [s]."""
        start = float(tour.stamps[-1]) / 2 if self.at_s is None else self.at_s
        return start, start + self.for_s

    @abstractmethod
    def change(self, stage: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """The stage while the fault lasts."""


@dataclass(frozen=True)
class MovedFurniture(WorldFault):
    """Between two passes, furniture is pushed about in its room, with what stands on it, clear of the rest of the tour."""

    name = "moved-furniture"
    share: float = setting(0.3, 0.0, 1.0)
    """Of the pieces on the floor that are moved, as far as there is room."""
    within_m: float = setting(1.5, 0.0)
    """Largest shift [m]."""
    turn_rad: float = setting(0.5, 0.0, np.pi)
    """Largest turn [rad]."""

    def change(self, stage: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """The stage with furniture in other places."""
        later = tour.T_W_B[tour.stamps >= self.span_s(tour)[0], :3, 3]
        pieces = with_furniture_moved(stage.house, later, self.share, self.within_m, self.turn_rad, rng)
        return replace(stage, house=replace(stage.house, furniture=pieces))


@dataclass(frozen=True)
class ClosedDoors(WorldFault):
    """Doors are closed, those without a leaf get one; each opens when the body comes near, and closes behind it."""

    name = "closed-doors"
    share: float = setting(1.0, 0.0, 1.0)
    """Of all doors."""

    def change(self, stage: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """The stage with doors that close."""
        leaves = tuple(leaf for leaf in all_leaves(stage.house) if rng.random() < self.share)
        closing = {leaf.id for leaf in leaves}
        standing = tuple(leaf for leaf in stage.house.leaves if leaf.id not in closing)
        return WorldState(replace(stage.house, leaves=standing), (*stage.actors, ClosingDoors(leaves)))


@dataclass(frozen=True)
class Pedestrian(WorldFault):
    """Somebody walks the tour a little ahead of the camera and faster than it, through its view and away."""

    name = "person"
    pace: float = setting(1.35, 0.0, 5.0, kw_only=True)
    """Of the tour's speed."""
    ahead_s: float = setting(2.0, 0.0, kw_only=True)
    """By how much of the tour the person is ahead at first [s]."""
    for_s: float = setting(20.0, 0.0, kw_only=True)
    """How long the person is there [s]."""

    def change(self, stage: WorldState, tour: Tour, rng: np.random.Generator) -> WorldState:
        """The stage with a person."""
        start, _ = self.span_s(tour)
        person = Person(tour, start, self.ahead_s, self.pace, draw_person(rng))
        return replace(stage, actors=(*stage.actors, person))
