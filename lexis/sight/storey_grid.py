"""Finds the free and the occupied cells of a storey, by lines of sight to landmarks and by the path of the camera.

1. The space between a camera and a landmark is free, and there is an obstacle at the landmark. Only heights at which a robot
   could run into something count: neither the floor nor the ceiling is an obstacle (`_obstacle_heights`).
2. For every cell, count the views that look through it and the views that see a landmark in it; each camera of a keyframe
   is one view. The cell is occupied if, of all these views, at least the share `OCCUPIED_SHARE` sees a landmark in it.
   Otherwise it is free if at least `MIN_VIEWS` views look through it; fewer are not enough, because single landmarks may be
   behind walls.
3. All cells within `WALKED_M` of the camera's path are free.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.ndimage import distance_transform_edt

from lexis.errors import MapError
from lexis.floors import NO_FLOOR
from lexis.graph.components import component_of
from lexis.graph.walked_steps import walked_steps
from lexis.keyframes import MAX_STEP_M
from lexis.maths.se3 import transform
from lexis.sight.cells import (
    CELL_M,
    MAX_CELLS,
    WALKED_M,
    Cells,
    cells_at,
    count_view,
    grid_around,
    occupied,
    on_lines_of_sight,
)
from lexis.types import LexisMap

RANGE_M = 8.0
"""Largest distance of a landmark from the camera; farther landmarks are not accurate enough [m]."""
OCCUPIED_SHARE = 0.25
"""A cell is occupied if h / (h + p) is at least this share, where h views see a landmark in the cell and p views look
through the cell."""
MIN_VIEWS = 3
"""Least number of views that have to look through a cell before it counts as free. On a rendered home, 1 to 2 % of the free
cells were then outside of the true rooms; with one view, 6 to 12 % were."""
LOW_M = 0.8
"""Lines of sight above this height over the floor may pass over a table [m]. The floor is taken from the
lowest landmarks, so some landmarks must lie on it."""
_ON_FLOOR_M, _BELOW_M = 0.12, 0.3
"""Landmarks lie on the floor from `_BELOW_M` below it to `_ON_FLOOR_M` above it [m]."""
_FLOOR_M, _HEAD_M = 0.2, 0.5
"""A landmark is an obstacle only if it is more than `_FLOOR_M` above the floor, more than `_FLOOR_M` below the ceiling, and
less than `_HEAD_M` above the highest camera [m]."""
_MARGIN_M = 0.5
"""Width of the unknown border around everything that was seen [m]."""
_LOWEST, _HIGHEST = 2, 98
"""Percentiles of the heights of landmarks that are taken as the floor and the ceiling. Lower and higher landmarks are
probably wrong."""


@dataclass(frozen=True, eq=False)
class _StoreyPlan:
    """The place of a storey's cells of width `CELL_M`; row 0 is at the lowest y, column 0 at the lowest x."""

    origin: Float64[np.ndarray, "2"]
    """Lower left corner of the grid in W [m]."""
    heights: tuple[float, float]
    """Heights of the floor and the ceiling in W, as far as the landmarks and cameras show them [m]."""

    def cells(self, points: Float64[np.ndarray, "k d"]) -> Cells:
        """Return row and column of the cell that contains each point (x and y in W [m])."""
        return cells_at(self.origin, points)


@dataclass(frozen=True, eq=False)
class StoreyGrid(_StoreyPlan):
    """A plan of a storey: its free, occupied and unknown cells."""

    floor: int
    component: int
    """Component of the map, named as in `lexis.graph.components`."""
    free: Bool[np.ndarray, "rows columns"]
    occupied: Bool[np.ndarray, "rows columns"]
    """Occupied cells. Cells that are neither free nor occupied are unknown."""
    low: Bool[np.ndarray, "rows columns"]
    """Cells that a view looks through below `LOW_M` above the floor, and those of the camera's path. Free cells that are not
    among them may be over a table."""


@dataclass(frozen=True, eq=False)
class ViewCounts(_StoreyPlan):
    """How often the keyframes of a storey look through each cell, and see something in it."""

    passed: Int[np.ndarray, "rows columns"]
    """Number of camera views that look through the cell at the height of obstacles."""
    hit: Int[np.ndarray, "rows columns"]
    """Number of camera views that see a landmark in the cell at the height of obstacles."""
    low: Int[np.ndarray, "rows columns"]
    """Number of camera views that look through the cell below `LOW_M` above the floor, or see the floor in the cell."""
    walked: Bool[np.ndarray, "rows columns"]
    """Whether the cell is within `WALKED_M` of the camera's path."""

    def occupied(self, share: float) -> Bool[np.ndarray, "rows columns"]:
        """Return the cells in which at least this share of the views that reach a cell see a landmark."""
        return np.asarray(occupied(self.hit, self.passed, share) & ~self.walked)


def storeys(map: LexisMap) -> list[tuple[int, int]]:
    """Return the number and the component of each storey on which there are keyframes, ascending.

    Components count their floors each from their own lowest floor. Floors of one number in two components may thus be two
    storeys, with different heights.
    """
    pairs = zip(map.floors.tolist(), component_of(map).tolist(), strict=True)
    return sorted({(floor, component) for floor, component in pairs if floor != NO_FLOOR})


def on_storey(map: LexisMap, floor: int, component: int) -> Bool[np.ndarray, "n"]:
    """Return which keyframes are on a floor of a component."""
    return np.asarray((map.floors == floor) & (component_of(map) == component))


def storey_grid(map: LexisMap, floor: int, component: int = 0) -> StoreyGrid:
    """Find the free and the occupied cells of a storey. Raises MapError if the storey is larger than `MAX_CELLS`."""
    views = count_views(map, floor, component)
    filled = views.occupied(OCCUPIED_SHARE)
    free = ((views.passed >= MIN_VIEWS) & ~filled) | views.walked
    low = (views.low > 0) | views.walked
    return StoreyGrid(views.origin, views.heights, floor, component, free, filled, low)


def count_views(map: LexisMap, floor: int, component: int = 0) -> ViewCounts:
    """Count the camera views that pass through the cells of a storey. Raises MapError if it is larger than `MAX_CELLS`."""
    here = on_storey(map, floor, component)
    members = np.flatnonzero(here)
    cameras = (map.T_W_B[members] @ map.camera.T_B_C)[:, :3, 3]
    sights = [sight for i in members.tolist() for sight in _sights(map, i)]
    seen = np.concatenate([cameras, *(points for _, points in sights)])
    heights = _heights(cameras, seen)
    robots = np.concatenate([map.T_W_B[members, :3, 3], *(camera[None] for camera, _ in sights)])
    views = _no_views(floor, seen, robots, heights)
    band, bottom = _obstacle_heights(cameras, heights), heights[0] - _BELOW_M
    for camera, points in sights:
        samples = on_lines_of_sight(camera, points, RANGE_M)
        on_floor = _within(points, (bottom, heights[0] + _ON_FLOOR_M))
        count_view(views.passed, views.cells(_within(samples, band)))
        count_view(views.hit, views.cells(_within(points, band)))
        count_view(views.low, views.cells(np.concatenate([_within(samples, (bottom, heights[0] + LOW_M)), on_floor])))
    return replace(views, walked=_walked(map, here, views))


def _sights(map: LexisMap, i: int) -> Iterator[tuple[Float64[np.ndarray, "3"], Float64[np.ndarray, "k 3"]]]:
    """Yield, for each camera of a keyframe, its position and those of its landmarks within `RANGE_M`, in W [m]."""
    for camera, view in zip(map.camera.rig, map.keyframes[i].views, strict=True):
        position = (map.T_W_B[i] @ camera.T_B_C)[:3, 3]
        points = transform(map.T_W_B[i], view.landmarks.points)
        yield position, np.asarray(points[np.linalg.norm(points - position, axis=1) <= RANGE_M])


def _heights(cameras: Float64[np.ndarray, "n 3"], seen: Float64[np.ndarray, "k 3"]) -> tuple[float, float]:
    """Return the heights of the floor and the ceiling. All cameras are between them [m]."""
    low, high = np.percentile(seen[:, 2], (_LOWEST, _HIGHEST))
    return float(min(low, cameras[:, 2].min())), float(max(high, cameras[:, 2].max()))


def _obstacle_heights(cameras: Float64[np.ndarray, "n 3"], heights: tuple[float, float]) -> tuple[float, float]:
    """Return the range of heights at which a landmark is an obstacle, which includes the heights of the cameras [m]."""
    lowest, highest = float(cameras[:, 2].min()), float(cameras[:, 2].max())
    return min(heights[0] + _FLOOR_M, lowest), max(min(highest + _HEAD_M, heights[1] - _FLOOR_M), highest)


def _no_views(
    floor: int,
    seen: Float64[np.ndarray, "k 3"],
    robots: Float64[np.ndarray, "n 3"],
    heights: tuple[float, float],
) -> ViewCounts:
    """Return a grid around the first cameras and all landmarks, `seen`, in which nothing is counted yet.

    The grid is larger where a body or a further camera of a rig, in `robots`, lies outside of it. Its corner is at multiples
    of the cells' width. Raises MapError if the grid is too large.
    """
    low, high = seen[:, :2].min(axis=0) - _MARGIN_M, seen[:, :2].max(axis=0) + _MARGIN_M
    low, high = np.minimum(low, robots[:, :2].min(axis=0)), np.maximum(high, robots[:, :2].max(axis=0))
    origin, size = grid_around(low, high)
    if size is None:
        wide, long = high - low
        raise MapError(f"floor {floor} is {wide:.0f} m by {long:.0f} m large; valid: up to {MAX_CELLS * CELL_M**2:.0f} m²")
    passed, hit, below = (np.zeros(size, np.int32) for _ in range(3))
    return ViewCounts(origin, heights, passed, hit, below, np.zeros(size, bool))


def _within(points: Float64[np.ndarray, "k 3"], band: tuple[float, float]) -> Float64[np.ndarray, "m 3"]:
    return points[(points[:, 2] >= band[0]) & (points[:, 2] <= band[1])]


def _walked(map: LexisMap, here: Bool[np.ndarray, "n"], views: ViewCounts) -> Bool[np.ndarray, "rows columns"]:
    """Return which cells are within `WALKED_M` of the camera's path past the keyframes `here`."""
    walk = np.zeros_like(views.walked)
    walk[tuple(views.cells(np.concatenate(list(_steps(map, here)))).T)] = True
    return np.asarray(distance_transform_edt(~walk) * CELL_M <= WALKED_M)


def _steps(map: LexisMap, here: Bool[np.ndarray, "n"]) -> Iterator[Float64[np.ndarray, "k 2"]]:
    """Yield positions (x and y in W) along the camera's path past the keyframes `here` [m].

    They are less than a cell apart, except at gaps.
    """
    cameras = (map.T_W_B @ map.camera.T_B_C)[:, :2, 3]
    yield cameras[here]
    steps = walked_steps(map)
    for first, second in steps[here[steps].all(axis=1)].tolist():
        yield np.linspace(cameras[first], cameras[second], int(MAX_STEP_M / CELL_M) * 2)
