"""Square cells of a plan, and how often views look through them or see something in them."""

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.maths.ties import rounded

CELL_M = 0.1
"""Width of a cell [m]."""
MAX_CELLS = 20_000_000
"""Largest number of cells in a grid; a square of as many cells is 447 m wide."""
_LAST = 0.1
"""This share of a line of sight, and at least the width of a cell, is left out before the landmark, because the landmark may
really be nearer."""
WALKED_M = 0.2
"""Space within this distance of the path is free [m], because the robot itself has passed there."""

Cells = Int[np.ndarray, "k 2"]
Counts = Int[np.ndarray, "rows columns"]


def grid_around(
    low: Float64[np.ndarray, "2"], high: Float64[np.ndarray, "2"]
) -> tuple[Float64[np.ndarray, "2"], tuple[int, int] | None]:
    """Return the origin of a grid that covers a rectangle, and its rows and columns; None if they exceed `MAX_CELLS`.

    The origin is the corner of the lowest x and y [m], at multiples of the cells' width.
    """
    columns, rows = np.ceil(rounded((high - low) / CELL_M)) + 2
    origin = np.floor(rounded(low / CELL_M)) * CELL_M
    return origin, None if rows * columns > MAX_CELLS else (int(rows), int(columns))


def cells_at(origin: Float64[np.ndarray, "2"], points: Float64[np.ndarray, "k d"]) -> Cells:
    """Return row and column of the cell that contains each point, whose first coordinates are x and y [m]."""
    # Rounded, because a point on the border of two cells must not change its cell with the last bit.
    return np.asarray(np.floor(rounded((points[:, 1::-1] - origin[::-1]) / CELL_M)).astype(np.int64))


def on_lines_of_sight(
    camera: Float64[np.ndarray, "d"], landmarks: Float64[np.ndarray, "k d"], range_m: float
) -> Float64[np.ndarray, "m d"]:
    """Return positions on the lines from a camera to its landmarks, half a cell apart.

    The last part before each landmark is left out, and so is everything more than `range_m` [m] away from the camera.
    """
    rays = landmarks - camera
    lengths = np.linalg.norm(rays, axis=1)
    distances = np.arange(0.0, range_m, CELL_M / 2)
    ray, step = np.nonzero(distances <= np.minimum(lengths - CELL_M, (1.0 - _LAST) * lengths)[:, None])
    return np.asarray(camera + rays[ray] * (distances[step] / lengths[ray])[:, None])


def count_view(counts: Counts, cells: Cells) -> None:
    """Add 1 to the count of every cell that one view reaches, however often it reaches it."""
    rows, columns = cells.T
    counts.flat[np.unique(rows * counts.shape[1] + columns)] += 1


def occupied(hit: Counts, passed: Counts, share: float) -> Bool[np.ndarray, "rows columns"]:
    """Return the cells in which at least this share of the views that reach the cell see a landmark.

    `hit` counts the views that see a landmark in the cell, `passed` those that look through the cell.
    """
    return np.asarray((hit > 0) & (hit >= share * (hit + passed)))
