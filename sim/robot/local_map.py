"""`LocalMap`: the obstacle points around the robot, and local paths that avoid these points.

The points are those of recent scans, and, on stairs, those places where the robot has been on another level.

A local path is the cheapest path on a grid around the robot (Dijkstra). Cells cost more if they are close to obstacles or
far from the route. The path may end before the route ends, if the rest would cost more than to miss the route's end.
"""

from collections import deque
from functools import cache

import numpy as np
from jaxtyping import Float64, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from lexis.maths.ties import rounded

CELL_M, FINE_CELL_M = 0.08, 0.04
"""Side lengths of a cell of the ordinary and of the fine grid on which local paths are planned [m]. A gap that is hardly
wider than the robot may lie between the cells of the ordinary grid. The fine grid reaches half as far."""
_PARTS = 4
"""Number of parts into which a cell's side is divided. Obstacle points are rounded to the corners of these parts."""
_HALF = 22
"""Number of cells on either side of the robot's cell."""
_N = 2 * _HALF + 1
_SCANS = 24
"""Number of recent scans that are kept."""
_EVERY = 2
"""The latest scan and every second one before it are used, because successive scans are much alike."""
_SAME_M = 0.4
"""Largest difference in height between a scan that is used and the latest scan [m]. On stairs, scans from other heights show
other obstacles."""
_TRAIL_POSES = 300
"""Number of recent poses of the robot that are kept: those of about 30 s."""
_OTHER_LEVEL_M = 1.0
"""Largest difference in height between the robot and an earlier pose that counts as an obstacle [m]. On the flight above,
the robot is straight above poses on the flight below."""
_PREFERRED_M = 0.25
"""Preferred clearance in addition to the least distance from obstacles [m]; more clearance lowers the cost no further."""
_BLOCKED = 1000.0
"""Cost of a metre of path that is closer to obstacles than the least distance. The cost is finite, so that a path is always
found, but any path that keeps the least distance is preferred."""
_CROWDING = 5.0
"""Additional cost of a metre of path at the least distance from obstacles."""
_MISS_COST = 30.0
"""Cost of each metre between the end of the local path and the end of the route. It exceeds the cost of a metre of path at
the least distance from obstacles, so that the robot prefers to go on."""
_STRAYED_M = 0.3
"""Distance from the route up to which a path costs no more [m], because drift can cause this distance."""
_STRAYING = 20.0
"""Additional cost of a metre of path, for every metre by which the path is farther from the route than `_STRAYED_M`. The
route is preferred because it was walked before, and is therefore free of obstacles."""


class LocalMap:
    """The obstacle points around the robot, in the frame of its estimated pose.

    `least_m` is the least distance that the robot's centre keeps from each point [m].
    """

    def __init__(self, least_m: float) -> None:
        self._least_m = least_m
        self._scans: deque[tuple[float, Float64[np.ndarray, "_ 2"]]] = deque(maxlen=_SCANS)
        self._trail: deque[tuple[float, float, float]] = deque(maxlen=_TRAIL_POSES)
        self._points = np.zeros((0, 2))

    def add(self, hits: Float64[np.ndarray, "hits 2"], x: float, y: float, yaw: float, climbed_m: float) -> None:
        """Add a scan that was made at the estimated pose (x, y, yaw) and at a height of `climbed_m` above the start.

        `hits` are the scanned points in the body frame [m]. Earlier scans from other heights are ignored while the robot is
        at this height. Places where the robot has been on another level of the stairs count as obstacles: no plan leads back
        up a flight, but drift may put the route of the next flight onto the flight that the robot came down.
        """
        cos, sin = np.cos(yaw), np.sin(yaw)
        self._scans.append((climbed_m, hits @ np.array([[cos, sin], [-sin, cos]]) + (x, y)))
        used = list(self._scans)[::-_EVERY]
        seen = [points for height, points in used if abs(height - climbed_m) <= _SAME_M]
        self._trail.append((x, y, climbed_m))
        self._points = np.concatenate([*seen, self._on_another_level()])

    def _on_another_level(self) -> Float64[np.ndarray, "_ 2"]:
        """Return where the robot has been on another level of the stairs that it is on."""
        trail = np.array(self._trail)
        apart_m = np.abs(trail[:, 2] - trail[-1, 2])
        return np.asarray(trail[(apart_m > _SAME_M) & (apart_m <= _OTHER_LEVEL_M), :2])

    def clearance(self, start: Float64[np.ndarray, "2"], end: Float64[np.ndarray, "2"]) -> float:
        """Return the distance from a line segment to the nearest obstacle point [m]; infinite if there are no points."""
        if not len(self._points):
            return np.inf
        along, to = end - start, self._points - start
        share = np.clip(to @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        return float(np.sqrt(((to - share[:, None] * along) ** 2).sum(axis=1).min()))

    def plan_path(
        self, start: Float64[np.ndarray, "2"], route: Float64[np.ndarray, "k 2"], cell_m: float = CELL_M
    ) -> Float64[np.ndarray, "j 2"]:
        """Plan the cheapest path from `start` along `route` on a grid with cells of side `cell_m`, and return its points.

        A path is cheap if it is short, clear of obstacles and close to the route, and ends close to the end of the route.
        """
        cells = start + _cells() * cell_m
        strayed = cdist(cells, route).min(axis=1)
        distance = self._distances(start, cell_m)
        lack = np.clip(1.0 - (distance - self._least_m) / _PREFERRED_M, 0.0, 1.0)
        cost = np.where(distance < self._least_m, _BLOCKED, 1.0 + _CROWDING * lack**2).ravel()
        cost += _STRAYING * np.maximum(strayed - _STRAYED_M, 0.0)
        a, b, length, indptr = _grid()
        graph = csr_array((cell_m * length * (cost[a] + cost[b]) / 2, b, indptr), shape=(_N * _N, _N * _N))
        costs, before = (rows[0] for rows in dijkstra(graph, indices=[_HALF * _N + _HALF], return_predecessors=True))
        path = [int(np.argmin(rounded(costs + _MISS_COST * np.linalg.norm(cells - route[-1], axis=1))))]
        while before[path[-1]] >= 0:
            path.append(int(before[path[-1]]))
        return cells[path[::-1]]

    def _distances(self, centre: Float64[np.ndarray, "2"], cell_m: float) -> Float64[np.ndarray, "n n"]:
        """Return the distance from each cell to the nearest obstacle point [m]; infinite if there are no points.

        Points are rounded to a grid finer than the cells, so that equal distances are equal to the last bit.
        """
        points = np.rint((self._points - centre) * (_PARTS / cell_m))
        points = points[(np.abs(points) <= _PARTS * _HALF).all(axis=1)]
        if not len(points):
            return np.full((_N, _N), np.inf)
        distances = np.asarray(cKDTree(points).query(_PARTS * _cells())[0])
        return distances.reshape(_N, _N) * (cell_m / _PARTS)


@cache
def _cells() -> Int[np.ndarray, "cells 2"]:
    """Return the coordinates of each cell, as numbers of cells from the robot's cell."""
    cell = np.arange(_N * _N)
    return np.stack([cell % _N, cell // _N], axis=1) - _HALF


@cache
def _grid() -> tuple[Int[np.ndarray, "e"], Int[np.ndarray, "e"], Float64[np.ndarray, "e"], Int[np.ndarray, "m"]]:
    """Return the edges from each cell to its eight neighbours in CSR order: starts, ends, lengths, row pointers.

    The lengths are in cells.
    """
    cell = np.arange(_N * _N)
    x, y = cell % _N, cell // _N
    moves = [(i, j) for j in (-1, 0, 1) for i in (-1, 0, 1) if (i, j) != (0, 0)]
    ends = np.stack([np.where((x + i >= 0) & (x + i < _N) & (y + j >= 0) & (y + j < _N), cell + j * _N + i, -1)
                     for i, j in moves], axis=1)  # fmt: skip
    lengths = np.broadcast_to([np.hypot(i, j) for i, j in moves], ends.shape)
    inside = ends >= 0
    starts = np.broadcast_to(cell[:, None], ends.shape)
    indptr = np.append(0, np.cumsum(inside.sum(axis=1))).astype(np.int32)
    return starts[inside], ends[inside].astype(np.int32), lengths[inside].astype(float), indptr
