"""`Stops`: the places in each room that a tour visits, and the walking distances between them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from jaxtyping import Float64, Int
from scipy.sparse.csgraph import dijkstra

from sim.errors import SimError
from sim.wording import counted
from worlds.house import House, Room
from worlds.labels import STAIRS
from worlds.walkable import Walkable

COMFORT_M = 0.35
"""Clearance that a stop keeps from obstacles if the room is large enough [m]. Twice as much is preferred, but no more."""
_INSIDE_M = 0.5
"""Distance of a stop from its room's boundary if the room is large enough [m], because a doorway is a poor viewpoint."""
_AREA_PER_STOP_M2 = 7.0
_MAX_STOPS = 3
_STOP_SPACING_M = 0.7
"""A room gets a further stop only if some place in the room is farther than this from all previous stops of the room [m]."""


@dataclass(frozen=True, eq=False)
class Stops:
    """The places that a tour visits, numbered from 0, with the walking distances between them."""

    nodes: Int[np.ndarray, "m"]
    """Node of the walkable graph at each stop."""
    between: Float64[np.ndarray, "m m"]
    """Walking distances between stops along the walkable graph [m]."""
    of_room: dict[str, list[int]]
    """Stops of each room, the most central first."""

    @staticmethod
    def of(house: House, walkable: Walkable) -> "Stops":
        """Choose up to three stops in each reachable room. Raises `SimError` if the house has fewer than two stops."""
        reachable = set(walkable.reachable_rooms())
        nodes: list[int] = []
        of_room = {}
        for room in house.rooms:
            if room.label != STAIRS and room.id in reachable:
                own = _stops_in(walkable, room)
                of_room[room.id] = list(range(len(nodes), len(nodes) + len(own)))
                nodes += own
        if len(nodes) < 2:
            raise SimError(
                f"house {house.spec.name!r}: a body of radius {walkable.radius_m:g} m can stop at "
                f"{counted(len(nodes), 'place')}; valid: a house with two places or more"
            )
        return Stops(np.array(nodes), dijkstra(walkable.graph, indices=nodes)[:, nodes], of_room)

    def length(self, stops: Sequence[int]) -> float:
        """Return the length of the path that visits the stops in this order [m]."""
        return float(self.between[stops[:-1], stops[1:]].sum())


def _stops_in(walkable: Walkable, room: Room) -> list[int]:
    """Choose free places that together show a room: first the most central one, then places far from all earlier ones."""
    count = min(_MAX_STOPS, 2 + round(len(_free(walkable, room)) * walkable.resolution_m**2 / _AREA_PER_STOP_M2))
    inside = comfortable(walkable, room)
    points, comfort = walkable.nodes[inside, :2], np.minimum(walkable.clearance[inside], 2 * COMFORT_M)
    chosen = [int(np.argmax(comfort - np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    nearest = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count and nearest.max() > _STOP_SPACING_M:
        chosen.append(int(np.argmax(nearest + comfort)))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return [int(inside[k]) for k in chosen]


def comfortable(walkable: Walkable, room: Room) -> Int[np.ndarray, "_"]:
    """Return the nodes of a room that are good stops: inside the room, away from doorways, and far from obstacles."""
    inside = _free(walkable, room)
    depth = shapely.distance(room.polygon.exterior, shapely.points(walkable.nodes[inside, :2]))
    inside = inside[depth >= min(_INSIDE_M, 0.8 * depth.max())]
    clearance = walkable.clearance[inside]
    return np.asarray(inside[clearance >= min(COMFORT_M, 0.8 * clearance.max())])


def _free(walkable: Walkable, room: Room) -> Int[np.ndarray, "_"]:
    inside = walkable.nodes_in(room.id)
    return np.asarray(inside[walkable.connected[inside]])
