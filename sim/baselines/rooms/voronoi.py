"""Voronoi segmentation: the free space is cut where the generalised Voronoi graph passes a narrow place.

The method is that of Thrun as described by Bormann et al. (2016, Sec. III-C): critical points are local minima of the
distance to walls along the graph, and a cut joins each critical point with its two closest walls.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, Int
from scipy.ndimage import distance_transform_edt

from sim.baselines.rooms.cells import Free, Segments, clearance, components, grown


@dataclass(frozen=True)
class Voronoi:
    """Cuts the free space into parts at the critical points of its Voronoi graph, and then merges some parts.

    Small parts, and parts with a long common border, are merged with their neighbours.
    """

    least_turn: float = 0.9
    """Least value of (1 - cosine) / 2 at a critical point, for the angle between the directions to its two closest walls; 1
    means that the walls are on opposite sides. The best of 0.5 to 0.99 on the tuning homes."""
    least_width_m: float = 0.4
    """Least width of a passage between rooms [m]. Narrower places are only corners of rooms or rough edges of walls."""
    contrast: float = 1.5
    """Near a critical point, the largest distance of the graph from walls has to be at least this factor times the distance
    at the point: the best of 1.1 to 3, tuned on homes 900 to 906 at openness 0 to 0.9."""
    least_area_m2: float = 1.5
    """Parts smaller than this are merged with the neighbour that has the longest common border [m²]: the best of 0.3 to 6 m²
    on the tuning homes."""
    most_border: float = 0.35
    """Two parts merge if their common border is more than this share of the circumference of one part; 0.2 is as good on the
    tuning homes."""

    def segments(self, free: Free, resolution_m: float) -> Segments:
        """Divide the free cells of a storey into rooms."""
        distances = clearance(free, 1.0)
        cut = np.ones(free.shape, np.uint8)
        for first, point, second in self._cuts(free, distances, resolution_m):
            for end in (first, second):
                cv2.line(cut, tuple(map(int, point[::-1])), tuple(map(int, end[::-1])), 0, 1, cv2.LINE_4)
        parts = grown(components(free & (cut > 0)), free)
        return merged(parts, self.least_area_m2 / resolution_m**2, self.most_border)

    def _cuts(
        self, free: Free, distances: Float32[np.ndarray, "nx ny"], resolution_m: float
    ) -> Iterator[tuple[Int[np.ndarray, "2"], Int[np.ndarray, "2"], Int[np.ndarray, "2"]]]:
        """Yield each critical point between its two closest occupied cells, the narrowest place first."""
        graph, graph_walls = _graph(free)
        graph_widths = distances[tuple(graph.T)]
        passes = _opposite(graph, graph_walls) >= self.least_turn  # leaves out the branches that end in corners of rooms
        passes &= 2 * graph_widths * resolution_m >= self.least_width_m
        points, walls, widths = graph[passes], graph_walls[passes], graph_widths[passes]
        taken = np.zeros(len(points), bool)
        for k in np.argsort(widths, kind="stable"):
            beside = np.linalg.norm(points - points[k], axis=1) <= 2 * widths[k]
            around = np.linalg.norm(graph - points[k], axis=1) <= 2 * widths[k]
            is_minimum = (widths[beside] >= widths[k]).all() and graph_widths[around].max() >= self.contrast * widths[k]
            if is_minimum and not taken[beside].any():
                taken[k] = True
                yield walls[k, 0], points[k], walls[k, 1]


def _graph(free: Free) -> tuple[Int[np.ndarray, "n 2"], Int[np.ndarray, "n 2 2"]]:
    """Return the cells of the Voronoi graph, each with two occupied cells that are closest to it and far from each other."""
    padded = np.pad(free, 1)
    nearest = np.moveaxis(distance_transform_edt(padded, return_distances=False, return_indices=True), 0, -1) - 1
    points, walls = [], []
    for di, dj in ((1, 0), (0, 1)):
        ni, nj = padded.shape
        here, beside = nearest[: ni - di, : nj - dj], nearest[di:, dj:]
        own = np.stack(np.meshgrid(np.arange(ni - di), np.arange(nj - dj), indexing="ij"), axis=-1) - 1
        width = np.linalg.norm(here - own, axis=-1)
        apart = np.linalg.norm(here - beside, axis=-1)
        is_ridge = padded[: ni - di, : nj - dj] & padded[di:, dj:] & (apart > np.maximum(width, 3.0))
        points.append(own[is_ridge])
        walls.append(np.stack([here[is_ridge], beside[is_ridge]], axis=1))
    return np.concatenate(points), np.concatenate(walls)


def _opposite(points: Int[np.ndarray, "n 2"], walls: Int[np.ndarray, "n 2 2"]) -> Float64[np.ndarray, "n"]:
    """Return (1 - cosine) / 2 for the angle at each point between its two walls: 1 if the walls lie on opposite sides."""
    towards = walls - points[:, None]
    towards = towards / np.maximum(np.linalg.norm(towards, axis=2, keepdims=True), 1e-9)
    return np.asarray((1.0 - (towards[:, 0] * towards[:, 1]).sum(axis=1)) / 2)


def merged(parts: Segments, least_cells: float, most_border: float) -> Segments:
    """Merge parts, the smallest first, until all parts are large and no two parts have a long common border.

    For the limits see `Voronoi.least_area_m2` (here in cells) and `Voronoi.most_border`.
    """
    sizes, borders, around = _borders(parts)
    owner = np.arange(len(sizes))
    alive = sizes > 0
    alive[0] = False
    while (pair := _next_merge(sizes, borders, around, alive, least_cells, most_border)) is not None:
        gone, into = pair
        owner[owner == gone] = into
        alive[gone] = False
        around[into] += around[gone] - 2 * borders[gone, into]
        sizes[into] += sizes[gone]
        borders[into] += borders[gone]
        borders[:, into] += borders[:, gone]
        borders[into, into] = 0
        borders[gone] = borders[:, gone] = 0
    return np.asarray(owner[parts], np.int32)


def _next_merge(
    sizes: Int[np.ndarray, "n"],
    borders: Int[np.ndarray, "n n"],
    around: Int[np.ndarray, "n"],
    alive: Bool[np.ndarray, "n"],
    least_cells: float,
    most_border: float,
) -> tuple[int, int] | None:
    """Return the smallest part that has to be merged, and the neighbour with the longest common border.

    Returns None if no part has to be merged.
    """
    for k in sorted(np.flatnonzero(alive).tolist(), key=lambda k: int(sizes[k])):
        into = int(np.argmax(borders[k]))
        longest = borders[k, into]
        if longest > 0 and (sizes[k] < least_cells or longest > most_border * around[k]):
            return k, into
    return None


def _borders(parts: Segments) -> tuple[Int[np.ndarray, "n"], Int[np.ndarray, "n n"], Int[np.ndarray, "n"]]:
    """Return the number of cells of each part, the border length of each two parts, and the circumference of each part.

    Lengths are in cells.
    """
    count = int(parts.max()) + 1
    borders = np.zeros((count, count), int)
    padded = np.pad(parts, 1)
    for a, b in ((padded[1:], padded[:-1]), (padded[:, 1:], padded[:, :-1])):
        differ = a != b
        np.add.at(borders, (a[differ], b[differ]), 1)
        np.add.at(borders, (b[differ], a[differ]), 1)
    around = borders.sum(axis=1)
    borders[0] = borders[:, 0] = 0
    return np.bincount(parts.ravel(), minlength=count), borders, around
