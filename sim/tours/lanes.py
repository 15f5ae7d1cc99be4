"""Parallel lanes that cover a room, for lawn-mower tours."""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float64, Int

from worlds.walkable import Walkable

_SHORTEST_M = 0.4
"""Least length of a free stretch of a lane [m]; shorter stretches are left out."""


def lanes_through(walkable: Walkable, rooms: Sequence[str], lane_m: float) -> list[int]:
    """Return graph nodes to visit in order: room by room and lane by lane, both ends of each free stretch of the lane.

    `lane_m` is the distance between lanes [m]. Each room is entered at the corner that is nearest to the last node of the
    previous room.
    """
    route: list[int] = []
    for room in rooms:
        inside = walkable.nodes_in(room)
        inside = inside[walkable.connected[inside]]
        runs = _runs(walkable.nodes[inside, :2], lane_m, walkable.resolution_m)
        ways = [inside[order].tolist() for order in _orders(runs)]
        route += ways[int(np.argmin([_gap(walkable.nodes, route, way[0]) for way in ways]))]
    return route


def _gap(nodes: Float64[np.ndarray, "n 3"], route: Sequence[int], start: int) -> float:
    return float(np.linalg.norm(nodes[start] - nodes[route[-1]])) if route else 0.0


def _orders(lanes: list[list[tuple[int, int]]]) -> Iterator[list[int]]:
    """Yield the four orders in which to walk the lanes, as the ends of the free stretches.

    The first lane is at one side of the room or at the other, and is walked in one direction or in the other. Directions
    alternate from lane to lane.
    """
    for side in (1, -1):
        for first in (0, 1):
            order: list[int] = []
            for k, lane in enumerate(lanes[::side]):
                forwards = (k + first) % 2 == 0
                stretches = lane if forwards else [(end, start) for start, end in lane[::-1]]
                order += [end for stretch in stretches for end in stretch]
            yield order


def _runs(points: Float64[np.ndarray, "n 2"], lane_m: float, step_m: float) -> list[list[tuple[int, int]]]:
    """Return the lanes along the room's longer side, each as its free stretches: indices of their first and last points."""
    along = int(np.argmax(np.ptp(points, axis=0)))
    across = points[:, 1 - along]
    count = max(1, round(float(np.ptp(across)) / lane_m))
    centres = across.min() + (np.arange(count) + 0.5) * np.ptp(across) / count
    lines = across[np.argmin(np.abs(across - centres[:, None]), axis=1)]
    lanes = [_stretches(points, np.flatnonzero(np.abs(across - line) < 0.1 * step_m), along, step_m) for line in lines]
    return [lane for lane in lanes if lane] or [[(middle := int(np.argmin(np.abs(across - centres[0]))), middle)]]


def _stretches(
    points: Float64[np.ndarray, "n 2"], own: Int[np.ndarray, "k"], along: int, step_m: float
) -> list[tuple[int, int]]:
    own = own[np.argsort(points[own, along], kind="stable")]
    pieces = np.split(own, np.flatnonzero(np.diff(points[own, along]) > 1.5 * step_m) + 1)
    return [(int(p[0]), int(p[-1])) for p in pieces if points[p[-1], along] - points[p[0], along] >= _SHORTEST_M]
