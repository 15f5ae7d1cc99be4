"""`Walkable`: where an upright round body can go in a house, and the ways between places.

A grid per storey and the walking lines of the stairs make one sparse graph. The grid keeps enough distance that every
edge of the graph, not only its ends, keeps the body's radius from walls, solid furniture and the edges of stairs.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from worlds.checks.reachability import STAIRS_LINK_M
from worlds.errors import WorldsError
from worlds.free_space import CLEARANCE_CAP_M, FreeSpace, Obstacles, solid_obstacles, stair_wells, survey
from worlds.house import House
from worlds.truth import room_at

_CROWDING = 3.0
"""How much longer than its length a way feels right beside an obstacle, for `prefer_clearance_m`."""


class UnreachableError(WorldsError):
    """A place is not walkable, or there is no way to it."""


@dataclass(frozen=True, eq=False)
class Walkable:
    """The free places (nodes) of a house and the graph that joins them. Positions are on the walked surface, in W [m].

    Nodes are numbered storey by storey; those of stairs come last. Distances over the graph exceed the shortest way by at
    most 8 % (an 8-connected grid); `path` and `distance` shorten the way by lines of sight.
    Raises `WorldsError` for a radius or resolution that makes no sense.
    """

    house: House
    radius_m: float = 0.25
    resolution_m: float = 0.1

    def __post_init__(self) -> None:
        if not 0.0 < self.radius_m <= CLEARANCE_CAP_M / 2:
            raise WorldsError(f"radius_m is {self.radius_m}; valid: above 0, at most {CLEARANCE_CAP_M / 2}")
        if not 0.02 <= self.resolution_m <= 0.5:
            raise WorldsError(f"resolution_m is {self.resolution_m}; valid: 0.02 ... 0.5")

    @cached_property
    def free_space(self) -> FreeSpace:
        """Clearance and room of every grid point."""
        return survey(self.house, self.resolution_m)

    @cached_property
    def solids(self) -> Obstacles:
        """Walls and solid furniture."""
        return solid_obstacles(self.house)

    @cached_property
    def wells(self) -> Obstacles:
        """The cells of the stairs."""
        return stair_wells(self.house)

    @cached_property
    def _free(self) -> Bool[np.ndarray, "storeys nx ny"]:
        # Two points at least this far from an obstacle keep the radius all along a grid diagonal between them.
        margin = math.hypot(self.radius_m, self.resolution_m / math.sqrt(2.0))
        return (self.free_space.room >= 0) & (self.free_space.clearance >= margin)

    @cached_property
    def _level(self) -> Float64[np.ndarray, "level 3"]:
        storey, i, j = np.nonzero(self._free)
        return np.stack([self.free_space.x[i], self.free_space.y[j], self.free_space.floors[storey]], axis=-1)

    @cached_property
    def _flights(self) -> tuple[Float64[np.ndarray, "_ 3"], ...]:
        return tuple(_resample(stairs.walking_line, self.resolution_m) for stairs in self.house.stairs)

    @cached_property
    def nodes(self) -> Float64[np.ndarray, "n 3"]:
        """The free places."""
        return np.concatenate([self._level, *self._flights])

    @cached_property
    def node_room(self) -> Int[np.ndarray, "n"]:
        """Index in `house.rooms` of every node."""
        rooms = [self.free_space.room[self._free]]
        for stairs, line in zip(self.house.stairs, self._flights, strict=True):
            own, owner = self.house.rooms.index(self.house.room_by_id[stairs.room]), room_at(self.house, line)
            rooms.append(np.where(owner < 0, own, owner))  # where the way to the stairs lies in no room, no one gets there
        return np.concatenate(rooms)

    @cached_property
    def clearance(self) -> Float64[np.ndarray, "n"]:
        """Distance of every node to the nearest obstacle, up to 1 m; that of stairs is the body's radius [m]."""
        on_stairs = len(self.nodes) - len(self._level)
        return np.concatenate([self.free_space.clearance[self._free], np.full(on_stairs, self.radius_m)])

    @cached_property
    def graph(self) -> "csr_array[np.float64, tuple[int, int]]":
        """Lengths of the steps between neighbouring nodes, symmetric [m]."""
        number = np.full(self._free.shape, -1, dtype=np.int32)
        number[self._free] = np.arange(len(self._level))
        east, north = (number[:, :-1], number[:, 1:]), (number[:, :, :-1], number[:, :, 1:])
        rising = number[:, :-1, :-1], number[:, 1:, 1:]
        falling = number[:, :-1, 1:], number[:, 1:, :-1]
        pairs = [np.stack([a[both], b[both]]) for a, b in (east, north, rising, falling) for both in [(a >= 0) & (b >= 0)]]
        a, b = np.concatenate([*pairs, self._stairs_steps()], axis=1)
        length = np.linalg.norm(self.nodes[a] - self.nodes[b], axis=1)
        n = len(self.nodes)
        return csr_array(coo_array((np.tile(length, 2), (np.concatenate([a, b]), np.concatenate([b, a]))), shape=(n, n)))

    def _stairs_steps(self) -> Int[np.ndarray, "2 m"]:
        steps, first = [np.zeros((2, 0), dtype=np.int64)], len(self._level)
        for line in self._flights:
            last = first + len(line) - 1
            steps.append(np.stack([np.arange(first, last), np.arange(first + 1, last + 1)]))
            for end in (first, last):
                near = np.flatnonzero(np.linalg.norm(self._level - self.nodes[end], axis=1) <= STAIRS_LINK_M)
                ends = np.broadcast_to(self.nodes[end], (len(near), 3))
                near = near[self.solids.clear(ends, self._level[near], self.radius_m)]
                steps.append(np.stack([np.full(len(near), end), near]))
            first = last + 1
        return np.concatenate(steps, axis=1)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.nodes, balanced_tree=False, compact_nodes=False)

    def snap(self, point: Float64[np.ndarray, "3"], within_m: float = 0.5) -> int:
        """The node nearest to a point. Raises `UnreachableError` where none is within `within_m`."""
        if not np.isfinite(point).all():
            raise UnreachableError(f"nowhere to stand at {point.tolist()}; coordinates must be finite")
        distance, node = self._tree.query(point)
        if distance > within_m:
            place = ", ".join(f"{coordinate:.2f}" for coordinate in point)
            raise UnreachableError(
                f"nowhere to stand within {within_m:g} m of ({place}) m; the nearest free place is {distance:.2f} m away"
            )
        return int(node)

    def nodes_near(self, point: Float64[np.ndarray, "3"], within_m: float) -> Int[np.ndarray, "_"]:
        """All nodes within a distance of a point, ascending."""
        return np.array(sorted(self._tree.query_ball_point(point, within_m)), dtype=np.int64)

    def nodes_in(self, room: str) -> Int[np.ndarray, "_"]:
        """The nodes in a room. Raises `WorldsError` for a room that the house does not have."""
        by_id = self.house.room_by_id
        if room not in by_id:
            raise WorldsError(f"no room {room!r}; the rooms are {', '.join(by_id)}")
        return np.flatnonzero(np.equal(self.node_room, self.house.rooms.index(by_id[room])))

    def reachable_rooms(self) -> tuple[str, ...]:
        """Ids of the rooms that the largest connected part of the graph touches, in the house's order."""
        return tuple(self.house.rooms[k].id for k in np.unique(self.node_room[self.connected]))

    @cached_property
    def connected(self) -> Bool[np.ndarray, "n"]:
        """Which nodes belong to the largest connected part of the graph."""
        _, part = connected_components(self.graph, directed=False)
        return np.equal(part, np.argmax(np.bincount(part, minlength=1)))

    def distances_from(self, start: Float64[np.ndarray, "3"] | int, limit_m: float = np.inf) -> Float64[np.ndarray, "n"]:
        """Distance over the graph from a point or node to every node; infinite where there is no way (within the limit)."""
        node = start if isinstance(start, int) else self.snap(start)
        return np.ravel(dijkstra(self.graph, indices=[node], limit=limit_m))

    def distance(self, start: Float64[np.ndarray, "3"], goal: Float64[np.ndarray, "3"]) -> float:
        """Length of `path` [m]."""
        return polyline_length(self.path(start, goal))

    def path(
        self, start: Float64[np.ndarray, "3"] | int, goal: Float64[np.ndarray, "3"] | int, prefer_clearance_m: float = 0.0
    ) -> Float64[np.ndarray, "k 3"]:
        """The shortest way between two points (snapped) or nodes, as corners on the walked surface.

        With `prefer_clearance_m`, a way that keeps about so far from obstacles where there is room. Raises
        `UnreachableError`. The way back is the same way.
        """
        a, b = (place if isinstance(place, int) else self.snap(place) for place in (start, goal))
        if a > b:  # sight lines are drawn from one end on, so which end that is must not depend on the direction
            return self.path(b, a, prefer_clearance_m)[::-1].copy()
        predecessors = dijkstra(self._costs(prefer_clearance_m), indices=[a], return_predecessors=True)[1][0]
        nodes = _trace(predecessors, a, b)
        if not nodes:
            rooms = (self.house.rooms[self.node_room[k]].id for k in (a, b))
            raise UnreachableError("no way between {!r} and {!r} for a body of radius {:g} m".format(*rooms, self.radius_m))
        return self._shorten(np.array(nodes), prefer_clearance_m)

    def _costs(self, prefer_clearance_m: float) -> "csr_array[np.float64, tuple[int, int]]":
        if prefer_clearance_m <= 0.0:
            return self.graph
        lack = np.maximum(0.0, 1.0 - self.clearance / prefer_clearance_m)
        rows = np.repeat(np.arange(len(lack)), np.diff(self.graph.indptr))
        factor = 1.0 + _CROWDING * (lack[rows] + lack[self.graph.indices])
        return csr_array((self.graph.data * factor, self.graph.indices, self.graph.indptr), shape=self.graph.shape)

    def _shorten(self, nodes: Int[np.ndarray, "k"], prefer_clearance_m: float) -> Float64[np.ndarray, "j 3"]:
        """Pull the string: from each corner on to the last node in sight."""
        kept, here = [0], 0
        while here < len(nodes) - 1:
            low, high = here + 1, len(nodes) - 1
            while low < high:
                middle = (low + high + 1) // 2
                low, high = (middle, high) if self._sees(nodes[here : middle + 1], prefer_clearance_m) else (low, middle - 1)
            here = low
            kept.append(here)
        return np.take(self.nodes, nodes[kept], axis=0)

    def _sees(self, nodes: Int[np.ndarray, "k"], prefer_clearance_m: float) -> bool:
        """Whether the straight line replaces a way: free and level, and no nearer to obstacles than asked or than it was."""
        line = self.nodes[nodes[[0, -1]]]
        if nodes.max() >= len(self._level):
            off_line = np.cross(self.nodes[nodes] - line[0], line[1] - line[0])
            return bool(np.abs(off_line).max() <= 1e-6)
        keep = max(self.radius_m, min(prefer_clearance_m, self.clearance[nodes].min() - 0.5 * self.resolution_m))
        return all(bool(obstacles.clear(line[:1], line[1:], keep)[0]) for obstacles in (self.solids, self.wells))


def polyline_length(points: Float64[np.ndarray, "k 3"]) -> float:
    """Length of a line through points [m]."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _resample(line: Float64[np.ndarray, "k 3"], step_m: float) -> Float64[np.ndarray, "_ 3"]:
    """Points at most `step_m` apart, every corner kept."""
    pieces = [
        np.linspace(a, b, max(1, math.ceil(float(np.linalg.norm(b - a)) / step_m)), endpoint=False)
        for a, b in pairwise(line)
    ]
    return np.concatenate([*pieces, line[-1:]])


def _trace(predecessors: Int[np.ndarray, "n"], start: int, goal: int) -> list[int]:
    nodes = [goal]
    while nodes[-1] != start:
        nodes.append(int(predecessors[nodes[-1]]))
        if nodes[-1] < 0:
            return []
    return nodes[::-1]
