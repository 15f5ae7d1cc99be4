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
    least_dilation_m: float = 0.55
    """Least dilation [m]: the better of 0.45 m, the value of Hydra, and 0.55 m, tuned on homes 900 to 906
    at openness 0 to 0.9."""
    most_dilation_m: float = 0.8
    """Largest dilation [m]: the best of 0.8 to 1.6 m on the tuning homes. Hydra has 1.2 m, which closes too many rooms."""
    steps: int = 16
    """Number of dilations that are tried."""
    least_area_m2: float = 0.6
    """Least area of the places of a component that counts as a room [m²]: the best of 0.6 to 3 m² on the tuning homes."""

    def segments(self, free: Free, resolution_m: float) -> Segments:
        """Divide the free cells of a storey into rooms."""
        stride = max(1, round(self.spacing_m / resolution_m))
        at = np.argwhere(free[::stride, ::stride])
        if not len(at):
            return grown(np.zeros(free.shape, np.int32), free)
        distances_m = np.minimum(clearance(free, resolution_m), self.truncation_m)[::stride, ::stride][tuple(at.T)]
        graph = _graph(at, free[::stride, ::stride].shape)
        rooms = self._rooms(graph, distances_m, self.least_area_m2 / (stride * resolution_m) ** 2)
        seeds = np.zeros(free.shape, np.int32)
        seeds[tuple((at * stride).T)] = _joined(graph, rooms)
        return grown(seeds, free)

    def _rooms(self, graph: csr_array, distances_m: Float32[np.ndarray, "n"], least_places: float) -> Int[np.ndarray, "n"]:
        """Room of every place, from 1, under the chosen dilation; 0: none."""
        dilations_m = np.linspace(self.least_dilation_m, self.most_dilation_m, self.steps)
        found = [_components(graph, distances_m > dilation_m, least_places) for dilation_m in dilations_m]
        counts = [int(rooms.max()) for rooms in found]
        return found[_longest_plateau(counts)]


def _graph(at: Int[np.ndarray, "n 2"], shape: tuple[int, ...]) -> csr_array:
    """Edges between places that are neighbours on the grid, with their lengths in grid steps."""
    number = np.full((shape[0] + 2, shape[1] + 2), -1)
    number[at[:, 0] + 1, at[:, 1] + 1] = np.arange(len(at))
    starts, ends, lengths = [], [], []
    for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
        other = number[at[:, 0] + 1 + di, at[:, 1] + 1 + dj]
        start = np.flatnonzero(other >= 0)
        starts.append(start)
        ends.append(other[start])
        lengths.append(np.full(len(start), np.hypot(di, dj)))
    one_way = csr_array((np.concatenate(lengths), (np.concatenate(starts), np.concatenate(ends))), (len(at), len(at)))
    return csr_array(one_way + one_way.T)


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
    """Let every place without a room join the closest room along the graph; without any room, all places stay without."""
    seeds = np.flatnonzero(rooms)
    if not len(seeds):
        return rooms
    distances, _, sources = dijkstra(graph, directed=False, indices=seeds, return_predecessors=True, min_only=True)
    return np.where(np.isfinite(distances), rooms[sources], 0)
