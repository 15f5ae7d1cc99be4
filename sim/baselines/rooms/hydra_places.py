"""Rooms as in Hydra (Hughes et al., RSS 2022; IJRR 2024): components of a graph of places under dilation of the obstacles.

Hydra's places are vertices of a Voronoi graph of the free space. Here they are the free cells of a coarse grid, whose graph
has the same components under dilation.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from sim.baselines.rooms.cells import Free, Segments, clearance, grown


@dataclass(frozen=True)
class HydraPlaces:
    """Dilates the obstacles step by step, and takes the rooms of the number of components that stays for the most steps.

    The remaining places join the room that is closest along the graph.
    """

    spacing_m: float = 0.2
    """Distance between places [m]."""
    truncation_m: float = 3.0
    """Largest distance to obstacles that is known [m]."""
    least_dilation_m: float = 0.5
    """Least dilation [m]: the best of 0.35 to 0.65 m, tuned on homes 900 to 906 at openness 0 to 0.9. Hydra has 0.45 m."""
    most_dilation_m: float = 0.8
    """Largest dilation [m]: the best of 0.6 to 1.6 m on the tuning homes. Hydra has 1.2 m, which closes too many rooms."""
    steps: int = 16
    """Number of dilations that are tried."""
    least_area_m2: float = 0.6
    """Least area of the places of a component that counts as a room [m²]: the best of 0.2 to 2.5 m² on the tuning homes."""

    def segments(self, free: Free, resolution_m: float) -> Segments:
        """Divide the free cells of a storey into rooms."""
        stride = max(1, round(self.spacing_m / resolution_m))
        places = np.argwhere(free[::stride, ::stride]) * stride
        seeds = np.zeros(free.shape, np.int32)
        if len(places):
            distances_m = np.minimum(clearance(free, resolution_m)[tuple(places.T)], self.truncation_m)
            graph = _graph(places, free, stride)
            rooms = self._rooms(graph, distances_m, self.least_area_m2 / (stride * resolution_m) ** 2)
            seeds[tuple(places.T)] = _joined(graph, rooms)
        return grown(seeds, free)

    def _rooms(self, graph: csr_array, distances_m: Float32[np.ndarray, "n"], least_places: float) -> Int[np.ndarray, "n"]:
        """Return the room of every place, from 1, under the chosen dilation; 0: none."""
        dilations_m = np.linspace(self.least_dilation_m, self.most_dilation_m, self.steps)
        found = [_components(graph, distances_m > dilation_m, least_places) for dilation_m in dilations_m]
        counts = [int(rooms.max()) for rooms in found]
        return found[_longest_plateau(counts)]


def _graph(places: Int[np.ndarray, "n 2"], free: Free, stride: int) -> csr_array:
    """Return the edges between places that are neighbours on the grid and have free cells between them.

    Their lengths are in grid steps.
    """
    count = len(places)
    number = np.full(np.add(free.shape, 2 * stride), -1)
    number[tuple((places + stride).T)] = np.arange(count)
    passable = np.pad(free, stride)
    graph = csr_array((count, count))
    for direction in ((1, 0), (0, 1), (1, 1), (1, -1)):
        cells = [tuple((places + stride + np.multiply(direction, step)).T) for step in range(1, stride + 1)]
        start = np.flatnonzero(np.all([passable[cell] for cell in cells], axis=0))
        end = number[cells[-1]][start]
        graph = csr_array(graph + csr_array((np.full(len(start), np.hypot(*direction)), (start, end)), (count, count)))
    return csr_array(graph + graph.T)


def _components(graph: csr_array, kept: Bool[np.ndarray, "n"], least_places: float) -> Int[np.ndarray, "n"]:
    """Number the large components of the kept places from 1; all other places get 0."""
    rooms = np.zeros(len(kept), int)
    places = np.flatnonzero(kept)
    if len(places):
        component = connected_components(graph[places][:, places], directed=False)[1]
        is_large = np.bincount(component) >= least_places
        rooms[places] = (np.cumsum(is_large) * is_large)[component]
    return rooms


def _longest_plateau(counts: list[int]) -> int:
    """Return the index of the first dilation of the longest series of dilations that give the same number of rooms.

    `counts` holds the number of rooms for each dilation. Dilations without rooms do not form a series. If series
    are equally long, the one with the most rooms is taken.
    """
    best, best_key, first = 0, (0, 0), 0
    for k in range(1, len(counts) + 1):
        if k == len(counts) or counts[k] != counts[first]:
            key = (k - first if counts[first] else 0, counts[first])
            if key > best_key:
                best, best_key = first, key
            first = k
    return best


def _joined(graph: csr_array, rooms: Int[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
    """Let every place without a room join the closest room along the graph; a place that reaches no room stays without."""
    seeds = np.flatnonzero(rooms)
    if not len(seeds):
        return rooms
    distances, _, sources = dijkstra(graph, directed=False, indices=seeds, return_predecessors=True, min_only=True)
    joined, reached = np.zeros_like(rooms), np.isfinite(distances)
    joined[reached] = rooms[sources[reached]]
    return joined
