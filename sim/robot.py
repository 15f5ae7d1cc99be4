"""`drive`: a round robot goes through the waypoints of a plan, around what the map did not know of.

A kinematic body on the free space of the house; it has no momentum and its local planner sees everything near it.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from sim.errors import SimError
from worlds.house import House
from worlds.truth import NOWHERE, room_at
from worlds.walkable import Walkable, polyline_length

REACHED_M = 0.6
"""A waypoint counts as reached from this far: maps are wrong by some 0.3 m, and their points can lie in walls [m]."""
_DETOUR = 3.0
_DETOUR_M = 2.0
"""A leg may be this many times as long as it is straight, and this much longer."""
_MISS_COST = 2.0
"""Metres of way that a metre of missing the waypoint is worth: a near place behind a wall is the wrong one."""


@dataclass(frozen=True, eq=False)
class Drive:
    """How a drive went."""

    path: Float64[np.ndarray, "n 3"]
    """Driven corners on the walked surface, in W [m]."""
    room: str | None
    """Id of the room that the robot ended in."""
    length_m: float
    """Driven."""
    collisions: int
    """Legs without a free way; the first one ends the drive."""


def drive(house: House, walkable: Walkable, waypoints: Float64[np.ndarray, "k 3"], height_m: float = 0.0) -> Drive:
    """Drive from the first waypoint through all others; they are `height_m` above the walked surface.

    Raises `SimError` where there is no waypoint or one is not finite.
    """
    if len(waypoints) == 0 or not np.isfinite(waypoints).all():
        raise SimError(f"drive: waypoints must be at least one and finite; got {waypoints.tolist()}")
    targets = waypoints - [0.0, 0.0, height_m]
    nodes = _reached(walkable, targets)
    start = walkable.nodes[nodes[:1]] if nodes else targets[:1]
    path = np.concatenate([start, *(walkable.path(a, b)[1:] for a, b in pairwise(nodes))])
    room = int(room_at(house, path[-1:])[0])
    name = None if room == NOWHERE else house.rooms[room].id
    return Drive(path, name, polyline_length(path), collisions=int(len(nodes) < len(targets)))


def _reached(walkable: Walkable, targets: Float64[np.ndarray, "k 3"]) -> list[int]:
    """The places that stand for the waypoints, up to the first one that cannot be reached."""
    near = walkable.nodes_near(targets[0], REACHED_M)
    if len(near) == 0:
        return []
    nodes = [int(near[np.argmin(np.linalg.norm(walkable.nodes[near] - targets[0], axis=1))])]
    for target in targets[1:]:
        following = _following(walkable, nodes[-1], target)
        if following is None:
            break
        nodes.append(following)
    return nodes


def _following(walkable: Walkable, here: int, target: Float64[np.ndarray, "3"]) -> int | None:
    """The best place near a waypoint that a short enough way leads to."""
    near = walkable.nodes_near(target, REACHED_M)
    straight = float(np.linalg.norm(target - walkable.nodes[here]))
    way = walkable.distances_from(here, limit_m=_DETOUR * straight + _DETOUR_M)[near]
    if not np.isfinite(way).any():
        return None
    miss = np.linalg.norm(walkable.nodes[near] - target, axis=1)
    return int(near[np.argmin(way + _MISS_COST * miss)])
