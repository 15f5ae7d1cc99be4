"""`Walkable`: where an upright cylindrical body can walk in a house, and the shortest paths between two places.

1. On every storey, the points of a grid are free where the body has space. Free points are a little farther from obstacles
   than the body's radius, so that the straight step between two neighbouring free points is free as well.
2. The walking line of every flight of stairs is divided into points. Both ends of the line are joined to the free grid
   points near them.
3. All these points are the nodes of one sparse graph, whose edges are the steps between neighbours. Dijkstra's algorithm
   finds the shortest path in this graph.
4. Paths on a grid have needless corners. `path` removes these corners: from each corner of the path, it goes straight to the
   last node of the path that can be reached in a straight line.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from worlds.errors import WorldsError
from worlds.free_space import (
    CLEARANCE_CAP_M,
    STAIRS_LINK_M,
    FreeSpace,
    Obstacles,
    free_clearance,
    solid_obstacles,
    stair_wells,
    survey,
)
from worlds.house import House
from worlds.truth import room_at

Node = int | np.integer[Any]
"""Number of a node, as Python or numpy write whole numbers."""
_SNAP_M = 0.5
"""Largest distance of a point from the node that stands for it [m]."""
_CROWDING = 3.0
"""Weight of missing clearance in the cost of a step, for paths with `prefer_clearance_m`; see `Walkable._costs`."""


class UnreachableError(WorldsError):
    """A point is not walkable, or there is no path to it."""


@dataclass(frozen=True, eq=False)
class Walkable:
    """The free points (nodes) of a house and the graph that joins them. Positions are on the walked surface, in W [m].

    Nodes are numbered storey by storey; nodes on stairs come last. The graph is an 8-connected grid, so distances along the
    graph are up to about 8 % longer than the shortest path; `path` and `distance` straighten the path and are more precise.
    Raises `WorldsError` for a radius or resolution out of its range.
    """

    house: House
    radius_m: float = 0.25
    """Radius of the body [m]."""
    resolution_m: float = 0.1
    """Spacing of the grid [m]."""
    _known_costs: "dict[float, csr_array[np.float64, tuple[int, int]]]" = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        if not 0.0 < self.radius_m <= CLEARANCE_CAP_M / 2:
            raise WorldsError(f"radius_m is {self.radius_m}; valid: above 0, at most {CLEARANCE_CAP_M / 2}")
        if not 0.02 <= self.resolution_m <= 0.5:
            raise WorldsError(f"resolution_m is {self.resolution_m}; valid: 0.02 ... 0.5")

    @cached_property
    def free_space(self) -> FreeSpace:
        """The distance to obstacles (clearance) and the room of every grid point."""
        return survey(self.house, self.resolution_m)

    @cached_property
    def solids(self) -> Obstacles:
        """Walls, fences, solid furniture and door leaves."""
        return solid_obstacles(self.house)

    @cached_property
    def wells(self) -> Obstacles:
        """The stairwells, as upright boxes in which a storey has no floor to walk on."""
        return stair_wells(self.house)

    @cached_property
    def barriers(self) -> Obstacles:
        """All that a walk on a floor has to keep away from: solid objects and stairwells."""
        return self.solids.and_also(self.wells)

    @cached_property
    def _free(self) -> Bool[np.ndarray, "storeys nx ny"]:
        margin = free_clearance(self.radius_m, self.resolution_m)
        return (self.free_space.room >= 0) & (self.free_space.clearance >= margin)

    @cached_property
    def _level(self) -> Float64[np.ndarray, "level 3"]:
        """Positions of the nodes on the floors of the storeys, in W [m]."""
        storey, i, j = np.nonzero(self._free)
        return np.stack([self.free_space.x[i], self.free_space.y[j], self.free_space.floors[storey]], axis=-1)

    @cached_property
    def _flights(self) -> tuple[Float64[np.ndarray, "_ 3"], ...]:
        """Positions of the nodes of each flight of stairs, from its foot to its head, in W [m]."""
        return tuple(_resample(stairs.walking_line, self.resolution_m) for stairs in self.house.stairs)

    @cached_property
    def nodes(self) -> Float64[np.ndarray, "n 3"]:
        """Positions of the nodes in W [m]."""
        return np.concatenate([self._level, *self._flights])

    @cached_property
    def node_room(self) -> Int[np.ndarray, "n"]:
        """Room of every node, as an index into `house.rooms`."""
        rooms = [self.free_space.room[self._free]]
        for stairs, line in zip(self.house.stairs, self._flights, strict=True):
            own, owner = self.house.rooms.index(self.house.room_by_id[stairs.room]), room_at(self.house, line)
            rooms.append(np.where(owner < 0, own, owner))  # a node of the line outside of all rooms counts as stairs
        return np.concatenate(rooms)

    @cached_property
    def clearance(self) -> Float64[np.ndarray, "n"]:
        """Distance from every node to the nearest obstacle, at most 1 m; for nodes on stairs, the body's radius [m]."""
        on_stairs = len(self.nodes) - len(self._level)
        return np.concatenate([self.free_space.clearance[self._free], np.full(on_stairs, self.radius_m)])

    @cached_property
    def graph(self) -> "csr_array[np.float64, tuple[int, int]]":
        """Symmetric sparse matrix of the lengths of the steps between neighbouring nodes [m]."""
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
        """Return the steps on and to stairs, each as the numbers of the two nodes that it joins.

        These are the neighbours along each flight, and each end of a flight with the free grid points near it.
        """
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

    def snap(self, point: Float64[np.ndarray, "3"]) -> int:
        """Return the number of the node nearest to a point in W [m].

        Raises `UnreachableError` if no node is within 0.5 m of the point.
        """
        if not np.isfinite(point).all():
            raise UnreachableError(f"the point {point.tolist()} has no free place near it; valid: finite coordinates")
        distance, node = self._tree.query(point)
        if distance > _SNAP_M:
            place = ", ".join(f"{coordinate:.2f}" for coordinate in point)
            raise UnreachableError(
                f"no free place within {_SNAP_M:g} m of ({place}) m; the nearest free place is {distance:.2f} m away"
            )
        return int(node)

    def nodes_near(self, point: Float64[np.ndarray, "3"], within_m: float) -> Int[np.ndarray, "_"]:
        """Return the numbers of all nodes within `within_m` [m] of a point in W, in ascending order."""
        return np.array(sorted(self._tree.query_ball_point(point, within_m)), dtype=np.int64)

    def nodes_in(self, room: str) -> Int[np.ndarray, "_"]:
        """Return the numbers of the nodes in the room with this id. Raises `WorldsError` if no room has this id."""
        by_id = self.house.room_by_id
        if room not in by_id:
            raise WorldsError(f"no room {room!r}; valid: {', '.join(by_id)}")
        return np.flatnonzero(np.equal(self.node_room, self.house.rooms.index(by_id[room])))

    def reachable_rooms(self) -> tuple[str, ...]:
        """Return the ids of the rooms that can be reached on foot, in the order of `house.rooms`.

        These are the rooms in which the largest connected part of the graph has nodes.
        """
        return tuple(self.house.rooms[k].id for k in np.unique(self.node_room[self.connected]))

    @cached_property
    def connected(self) -> Bool[np.ndarray, "n"]:
        """Whether each node belongs to the largest connected part of the graph."""
        _, part = connected_components(self.graph, directed=False)
        return np.equal(part, np.argmax(np.bincount(part, minlength=1)))

    def distances_from(self, start: Float64[np.ndarray, "3"] | Node) -> Float64[np.ndarray, "n"]:
        """Return the length of the shortest path along the graph from `start` to every node [m].

        `start` is a point in W [m] or the number of a node. The length is infinite for nodes to which there is no path.
        """
        node = self._node(start)
        return np.ravel(dijkstra(self.graph, indices=[node]))

    def distance(self, start: Float64[np.ndarray, "3"], goal: Float64[np.ndarray, "3"]) -> float:
        """Return the length of the `path` between two points in W [m]. Raises `UnreachableError` where `path` does."""
        return polyline_length(self.path(start, goal))

    def path(
        self, start: Float64[np.ndarray, "3"] | Node, goal: Float64[np.ndarray, "3"] | Node, prefer_clearance_m: float = 0.0
    ) -> Float64[np.ndarray, "k 3"]:
        """Return the shortest path between two points or nodes, as its corners on the walked surface in W [m].

        Points are replaced by the nearest nodes. With `prefer_clearance_m` > 0, the path keeps about this distance from
        obstacles [m] if there is enough space. The path from `goal` to `start` is the same path reversed. Raises
        `UnreachableError` if there is no path, or a point is not walkable.
        """
        a, b = self._node(start), self._node(goal)
        if a > b:  # straightening depends on the end from which it starts, so it always starts from the smaller number
            return self.path(b, a, prefer_clearance_m)[::-1].copy()
        nodes = self._route(a, b, prefer_clearance_m)
        if not nodes:
            rooms = (self.house.rooms[self.node_room[k]].id for k in (a, b))
            raise UnreachableError("no path between {!r} and {!r} for a body of radius {:g} m".format(*rooms, self.radius_m))
        return self._shorten(np.array(nodes), prefer_clearance_m)

    def _node(self, place: Float64[np.ndarray, "3"] | Node) -> int:
        """Return the number of a node that is given by its number or by a point in W [m]."""
        return int(place) if np.ndim(place) == 0 else self.snap(np.asarray(place))

    def _route(self, a: int, b: int, prefer_clearance_m: float) -> list[int]:
        """Return the nodes of the cheapest path from node `a` to node `b`; an empty list if there is no path.

        Most paths are short in comparison with the house, so the search is at first limited to costs not far above that of
        the straight line.
        """
        costs, straight_m = self._costs(prefer_clearance_m), float(np.linalg.norm(self.nodes[a] - self.nodes[b]))
        for limit in (2.0 * straight_m + 1.0, 6.0 * straight_m + 3.0, np.inf):
            reached, predecessors = dijkstra(costs, indices=[a], return_predecessors=True, limit=limit)
            if np.isfinite(reached[0, b]):
                return _trace(predecessors[0], a, b)
        return []

    def _costs(self, prefer_clearance_m: float) -> "csr_array[np.float64, tuple[int, int]]":
        """Return the graph with the length of each step multiplied by a factor that is larger near obstacles.

        The factor is 1 if both ends of the step have a clearance of at least `prefer_clearance_m` [m]. It grows linearly
        with the clearance that the ends lack.
        """
        if prefer_clearance_m <= 0.0:
            return self.graph
        if prefer_clearance_m not in self._known_costs:
            self._known_costs[prefer_clearance_m] = self._crowded(prefer_clearance_m)
        return self._known_costs[prefer_clearance_m]

    def _crowded(self, prefer_clearance_m: float) -> "csr_array[np.float64, tuple[int, int]]":
        lack = np.maximum(0.0, 1.0 - self.clearance / prefer_clearance_m)
        rows = np.repeat(np.arange(len(lack)), np.diff(self.graph.indptr))
        factor = 1.0 + _CROWDING * (lack[rows] + lack[self.graph.indices])
        return csr_array((self.graph.data * factor, self.graph.indices, self.graph.indptr), shape=self.graph.shape)

    def _shorten(self, nodes: Int[np.ndarray, "k"], prefer_clearance_m: float) -> Float64[np.ndarray, "j 3"]:
        """Straighten a path: from each corner, go to the last node that can be reached in a straight line.

        Bisection finds this node quickly. The bisection assumes that there is one last node: all nodes of the path before it
        can be reached in a straight line, and no node after it.
        """
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
        """Return whether the straight line from the first to the last of `nodes`, a piece of a path, can replace the piece.

        If the piece has nodes on stairs, it must be straight already. Otherwise the line must keep `prefer_clearance_m` [m]
        from obstacles. If the piece itself comes nearer to an obstacle, the line may come about as near as the piece, but
        never nearer than the body's radius.
        """
        line = self.nodes[nodes[[0, -1]]]
        if nodes.max() >= len(self._level):
            off_line = np.cross(self.nodes[nodes] - line[0], line[1] - line[0])
            return bool(np.abs(off_line).max() <= 1e-6)
        keep = max(self.radius_m, min(prefer_clearance_m, self.clearance[nodes].min() - 0.5 * self.resolution_m))
        return bool(self.barriers.clear(line[:1], line[1:], keep)[0])


def polyline_length(points: Float64[np.ndarray, "k 3"]) -> float:
    """Return the length of a polyline [m]."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _resample(line: Float64[np.ndarray, "k 3"], step_m: float) -> Float64[np.ndarray, "_ 3"]:
    """Return the points of a polyline with further points in between, so that neighbours are at most `step_m` apart [m]."""
    pieces = [
        np.linspace(a, b, max(1, math.ceil(float(np.linalg.norm(b - a)) / step_m)), endpoint=False)
        for a, b in pairwise(line)
    ]
    return np.concatenate([*pieces, line[-1:]])


def _trace(predecessors: Int[np.ndarray, "n"], start: int, goal: int) -> list[int]:
    """Return the nodes from start to goal, given each node's predecessor on the path from start."""
    nodes = [goal]
    while nodes[-1] != start:
        nodes.append(int(predecessors[nodes[-1]]))
    return nodes[::-1]
