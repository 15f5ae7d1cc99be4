"""Shortcuts: straight steps between two keyframes of one floor, through space that is known to be free.

Space is free where the camera itself has walked, and where a line of sight to a landmark passes below the height of table
tops. A line of sight above a table does not count, because the robot could not follow it. Cells with an obstacle are not
free: there, at least the share `BLOCKED_SHARE` of the camera views that reach the cell see a landmark. This share is lower
than in `lexis.sight.storey_grid`, because most lines of sight pass above low furniture. Key points are sparse, so a few
cells of an open floor are on no line of sight; such gaps in free space count as free (`_filled`).

A shortcut must have free space on both sides, as wide as the robot. Its ends are at most `sight_m` apart: longer shortcuts
hardly shorten a path further. Space above or below stairs looks free, but has no floor to drive on, so a shortcut also keeps
`STAIRWELL_M` away from the camera's path on stairs, as seen from above.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Float64
from scipy.ndimage import binary_closing, distance_transform_edt
from scipy.spatial import cKDTree

from lexis.config import PlannerConfig
from lexis.errors import MapError
from lexis.floors import NO_FLOOR
from lexis.maths.ties import rounded
from lexis.planning.close_pairs import close_pairs
from lexis.sight.cells import CELL_M
from lexis.sight.storey_grid import ViewCounts, count_views, on_storey, storeys
from lexis.types import LexisMap, Pairs

BLOCKED_SHARE = 0.15
"""A cell is occupied if at least this share of the camera views that reach the cell see a landmark there."""
STAIRWELL_M = 0.8
"""Least distance of a shortcut from the keyframes on stairs, as seen from above [m]: half the width of stairs, and the
radius of a robot."""
SPACING_M = CELL_M / 2
"""Largest distance between the points of a shortcut at which the space is checked [m]."""
_CHUNK = 3_000_000
"""Largest number of points that are checked at a time, so that memory stays bounded."""


def shortcuts(map: LexisMap, config: PlannerConfig) -> Pairs:
    """Return the pairs of keyframes of one floor that are joined by a straight shortcut, with the smaller id first.

    A floor that is too large for a grid has no shortcuts.
    """
    if config.sight_m == 0.0:
        return np.zeros((0, 2), int)
    return np.concatenate([np.zeros((0, 2), int), *(_shortcuts_of_storey(map, *storey, config) for storey in storeys(map))])


def points_between(positions: Float64[np.ndarray, "n d"], pairs: Pairs, metres: float) -> Float64[np.ndarray, "m points d"]:
    """Return evenly spaced points on the straight steps between pairs of positions, both ends included.

    All steps get as many points as a step of length `metres` needs, so that no two are farther apart than `SPACING_M`.
    """
    share = np.linspace(0.0, 1.0, _point_count(metres))[:, None]
    first, second = positions[pairs[:, :1]], positions[pairs[:, 1:]]
    return np.asarray((1.0 - share) * first + share * second)


def chunks(pairs: Pairs, metres: float) -> Iterator[Pairs]:
    """Yield the pairs in parts, whose `points_between` for the same length `metres` fit into memory."""
    count = max(1, _CHUNK // _point_count(metres))
    for start in range(0, len(pairs), count):
        yield pairs[start : start + count]


def _point_count(metres: float) -> int:
    return int(np.ceil(metres / SPACING_M)) + 1


def _shortcuts_of_storey(map: LexisMap, floor: int, component: int, config: PlannerConfig) -> Pairs:
    positions = map.T_W_B[:, :3, 3]
    try:
        clearance = _Clearance(count_views(map, floor, component), positions[map.floors == NO_FLOOR, :2])
    except MapError:
        return np.zeros((0, 2), int)
    pairs = np.sort(close_pairs(map, on_storey(map, floor, component), config.sight_m), axis=1)
    parts = chunks(pairs, config.sight_m)
    kept = [clearance.allows(points_between(positions[:, :2], part, config.sight_m), config) for part in parts]
    return np.asarray(pairs[np.concatenate([np.zeros(0, bool), *kept])])


class _Clearance:
    """Distance from every cell of a floor to the nearest cell that is not free."""

    def __init__(self, views: ViewCounts, stairs: Float64[np.ndarray, "k 2"]) -> None:
        self._views, self._stairs = views, cKDTree(stairs) if len(stairs) else None
        blocked = views.occupied(BLOCKED_SHARE)
        free = ((views.low > 0) & ~blocked) | views.walked
        self._metres = rounded(distance_transform_edt(_filled(free) & ~blocked) * CELL_M)

    def allows(self, points: Float64[np.ndarray, "m points 2"], config: PlannerConfig) -> Bool[np.ndarray, "m"]:
        """Return which shortcuts are free for the robot, given the points on each shortcut."""
        rows, columns = self._views.cells(points.reshape(-1, 2)).T
        free = (self._metres[rows, columns] >= config.radius_m).reshape(points.shape[:2]).all(axis=1)
        if self._stairs is not None:
            near = np.isfinite(self._stairs.query(points[free].reshape(-1, 2), distance_upper_bound=STAIRWELL_M)[0])
            free[free] = ~near.reshape(-1, points.shape[1]).any(axis=1)
        return np.asarray(free)


def _filled(free: Bool[np.ndarray, "rows columns"]) -> Bool[np.ndarray, "rows columns"]:
    """Return the free cells, and those in gaps between free cells that are at most two cells wide."""
    padded = np.pad(free, 1)
    return np.asarray(binary_closing(padded, np.ones((3, 3), bool))[1:-1, 1:-1])
