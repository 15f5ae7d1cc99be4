"""`Planner`: plans the sequence of graph nodes that each kind of tour visits.

A tour has a first part, whose nodes are always visited, and a part that is repeated to reach a requested length. The path
back to the start is always added. If the tour is then still shorter than requested, a detour is added.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import cycle, islice, pairwise

import numpy as np
from jaxtyping import Bool, Float64
from scipy.sparse.csgraph import dijkstra

from sim.errors import SimError
from sim.tours.config import TourConfig
from sim.tours.lanes import lanes_through
from sim.tours.order import first_lap, short_cycle, shortened_by_moving_stops, thinned, walked
from sim.tours.paths import KnownPaths
from sim.tours.stops import COMFORT_M, Stops
from worlds.house import House
from worlds.labels import STAIRS
from worlds.walkable import Walkable, polyline_length

SMOOTHED = 0.95
"""Typical length of a smoothed path, divided by the length of the same path along the walkable graph."""
_SCATTER_M = 0.25
"""Largest distance of a repeated visit from the stop that it repeats [m], so that revisits have new viewpoints."""
_CIRCUIT_M = 40.0
"""Default length of one lap of a `loop` tour [m]."""
_PLACES = 48
"""Number of places that a random tour draws from."""
_WIDER = 1.25
"""Factor by which the lanes of a lawn-mower tour are moved apart, again and again, until the tour is short enough."""
_WIDEST_M = 6.0
_SHORTEST_LAP_M = 2.0
"""Least length of a lap that is repeated [m]. To repeat a shorter lap would mean to walk on the spot."""
_NEAR_ENOUGH_M = 0.15
"""A detour counts as equally good as the best detour if its length is worse by at most this distance [m]."""
_DRAWN = 0.3
"""In the choice of a detour, to be one metre nearer to the next stop of the tour is worth this much clearance [m]."""


@dataclass(frozen=True, eq=False)
class Itinerary:
    """Nodes of the walkable graph that a tour visits, in order. The return to the first node at the end is not included."""

    first: Sequence[int]
    """Nodes that are always visited."""
    again: Sequence[int]
    """Nodes that are visited after `first`, in a cycle, until the tour has the requested length."""
    default_repeats: int
    """Number of nodes that are visited after `first` if no length is requested. They are taken from `again` in a cycle."""
    distance: Callable[[int, int], float]
    """Function that returns the walking distance from one node to another [m]."""


@dataclass(frozen=True, eq=False)
class Planner:
    """Plans tours of the kind in `config`. Lengths are measured along the walkable graph, before the path is smoothed."""

    house: House
    walkable: Walkable
    config: TourConfig
    stops: Stops
    paths: KnownPaths
    seed: int
    """Seed of the random numbers. Every call of `nodes` draws the same numbers, for any requested length."""

    @staticmethod
    def of(house: House, walkable: Walkable, config: TourConfig, rng: np.random.Generator) -> "Planner":
        """Make the planner of a house. Raises `SimError` if the house has fewer than two places to stop at."""
        ways = KnownPaths(walkable, config.prefer_clearance_m, straight=config.kind == "lawn-mower")
        return Planner(house, walkable, config, Stops.of(house, walkable), ways, int(rng.integers(2**63)))

    def nodes(self, length_m: float | None) -> list[int]:
        """Return the nodes to visit in order. The last node equals the first one.

        The tour is about `length_m` long, or longer if no tour of this kind is that short. If `length_m` is None, the tour
        has the usual length of tours of this kind in this house.
        """
        rng = np.random.default_rng(self.seed)
        kinds = {
            "rooms": self._rooms,
            "both ways": self._both_ways,
            "loop": self._loop,
            "random": self._random,
            "lawn-mower": self._lawn_mower,
        }
        plan = kinds[self.config.kind](np.inf if length_m is None else length_m, rng)
        if length_m is not None:
            return self._filled(plan, length_m, rng)
        again = [self._scatter(node, rng) for node in islice(cycle(plan.again), plan.default_repeats)]
        return [*plan.first, *again, plan.first[0]]

    def _rooms(self, most_m: float, rng: np.random.Generator) -> Itinerary:
        stops, lap, base = self._lap(most_m, rng, there_and_back=False)
        return _itinerary(stops, lap, base if len(base) > 1 else lap, len(base))

    def _both_ways(self, most_m: float, rng: np.random.Generator) -> Itinerary:
        stops, lap, _ = self._lap(most_m, rng, there_and_back=True)
        there_and_back = [*lap, *lap[-2::-1]]
        return _itinerary(stops, there_and_back, there_and_back[1:] or lap)

    def _lap(self, most_m: float, rng: np.random.Generator, there_and_back: bool) -> tuple[Stops, list[int], list[int]]:
        """Return the stops, a lap through all rooms as a list of stops, and the stops of the lap on the lowest storey.

        The lap is no longer than `most_m` [m] if possible. To achieve this, stops are left out; if that is not enough, every
        room keeps one stop, and these stops are moved closer together.
        """
        stops = self.stops
        whole, base = first_lap(self.house, stops, rng)
        lap = thinned(stops, whole, most_m, there_and_back)
        if walked(stops, lap, there_and_back) <= most_m:
            return stops, lap, [stop for stop in lap if stop in base]
        stops, lap = shortened_by_moving_stops(self.house, self.walkable, stops, whole)
        lowest = min(self.house.room_by_id[room].storey for room in stops.of_room)
        return stops, lap, [k for room, (k,) in stops.of_room.items() if self.house.room_by_id[room].storey == lowest]

    def _loop(self, _: float, rng: np.random.Generator) -> Itinerary:
        """Plan a circuit through as many stops as the length of a lap allows.

        Stops are added in the order of their distance from the first stop. A detour fills the remaining length.
        """
        base = first_lap(self.house, self.stops, rng)[1]
        home, circuit = base[0], base[:1]
        length_m = (self.config.circuit_m or _CIRCUIT_M) / SMOOTHED
        for stop in map(int, np.argsort(self.stops.between[home], kind="stable")):
            wider: list[int] = [home, *short_cycle(self.stops.between, home, [*circuit[1:], stop])]
            if stop != home and self.stops.length([*wider, home]) <= length_m:
                circuit = wider
        nodes: list[int] = self.stops.nodes[circuit].tolist()
        to_home = self.walkable.distances_from(nodes[0])
        nodes += self._detour(nodes[-1], to_home, length_m - self.stops.length(circuit), nodes[-1])
        around = polyline_length(self.paths.line([*nodes, nodes[0]]))
        if self.config.circuit_m is not None and around < 0.8 * self.config.circuit_m:
            raise SimError(f"tour: circuit_m is {self.config.circuit_m:g}; valid: up to {around:.0f} in this house")
        return Itinerary(nodes, nodes, (self.config.laps - 1) * len(nodes), self.paths.length)

    def _random(self, _: float, rng: np.random.Generator) -> Itinerary:
        comfortable = self.walkable.connected & (self.walkable.clearance >= COMFORT_M) & ~self._on_stairs()
        free = np.flatnonzero(comfortable if comfortable.sum() >= _PLACES else self.walkable.connected)
        places = rng.choice(free, min(_PLACES, len(free)), replace=False)
        stops = Stops(places, dijkstra(self.walkable.graph, indices=places)[:, places], {})
        order = np.concatenate([rng.permutation(len(places)) for _ in range(8)])
        order = order[np.append(True, np.diff(order) != 0)].tolist()
        return _itinerary(stops, order[:1], order[1:])

    def _lawn_mower(self, most_m: float, rng: np.random.Generator) -> Itinerary:
        centres = Stops(self.stops.nodes, self.stops.between, {room: own[:1] for room, own in self.stops.of_room.items()})
        room_of = {own[0]: room for room, own in centres.of_room.items()}
        rooms = [room_of[stop] for stop in first_lap(self.house, centres, rng)[0]]
        lane_m = self.config.lane_m
        while True:
            lanes = lanes_through(self.walkable, rooms, lane_m)
            if lane_m > _WIDEST_M or sum(self.paths.length(a, b) for a, b in pairwise([*lanes, lanes[0]])) <= most_m:
                return Itinerary(lanes, lanes, 0, self.paths.length)
            lane_m *= _WIDER

    def _filled(self, plan: Itinerary, length_m: float, rng: np.random.Generator) -> list[int]:
        """Return the nodes of a tour of the length `length_m`.

        The tour visits `plan.first`, then nodes of `plan.again` as long as enough length is left for the way back to the
        start. A detour on the way back uses up the remaining length.
        """
        home, here, nodes = plan.first[0], plan.first[-1], list(plan.first)
        to_home = self.walkable.distances_from(home)
        left = length_m - sum(plan.distance(a, b) for a, b in pairwise(plan.first))
        lap = sum(plan.distance(a, b) for a, b in pairwise([*plan.again, plan.again[0]]))
        following = iter(cycle(plan.again)) if lap > _SHORTEST_LAP_M else iter(())
        towards = here
        for towards in following:
            if (way := plan.distance(here, towards)) + to_home[towards] > left:
                break
            left -= way
            here = towards
            nodes.append(self._scatter(here, rng))
        return [*nodes, *self._detour(nodes[-1], to_home, left, towards), home]

    def _detour(self, here: int, to_home: Float64[np.ndarray, "n"], length_m: float, towards: int) -> list[int]:
        """Return a list of one node, via which the path from `here` to the first node has the length `length_m`.

        `to_home` holds the length of the path from each node to the first one [m]. The list is empty if the direct path is
        already longer. Nodes that have much clearance and are close to the node `towards` are preferred.
        """
        way = self.walkable.distances_from(here) + to_home
        if not way[here] < length_m < np.inf:
            return []
        off = np.where(self._on_stairs(), np.inf, np.abs(way - length_m))
        near = np.flatnonzero(off <= off.min() + _NEAR_ENOUGH_M)
        gap = np.linalg.norm(self.walkable.nodes[near] - self.walkable.nodes[towards], axis=1)
        return [int(near[np.argmax(np.minimum(self.walkable.clearance[near], 2 * COMFORT_M) - _DRAWN * gap)])]

    def _on_stairs(self) -> Bool[np.ndarray, "n"]:
        stairs = np.array([room.label == STAIRS for room in self.house.rooms])
        return np.take(stairs, self.walkable.node_room)

    def _scatter(self, node: int, rng: np.random.Generator) -> int:
        """Draw a place near a node, with a free straight path to the node."""
        near = self.walkable.nodes_near(self.walkable.nodes[node], _SCATTER_M)
        centre = np.broadcast_to(self.walkable.nodes[node], (len(near), 3))
        return int(rng.choice(near[self.walkable.solids.clear(centre, self.walkable.nodes[near], self.walkable.radius_m)]))


def _itinerary(stops: Stops, first: Sequence[int], again: Sequence[int], default_repeats: int = 0) -> Itinerary:
    nodes = stops.nodes.tolist()
    number = {node: k for k, node in enumerate(nodes)}
    return Itinerary(
        [nodes[k] for k in first],
        [nodes[k] for k in again],
        default_repeats,
        lambda a, b: float(stops.between[number[a], number[b]]),
    )
