"""Rectangles and rectilinear polygons of a plan: overlap, growth, sides, and the rectangles that make up a polygon."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Int
from shapely.geometry import Polygon

Rectangle = tuple[float, float, float, float]
"""A rectangle of the plan, as x0, y0, x1, y1 [m]."""
Corner = tuple[float, float]
"""A point of the plan, as x, y [m]."""
_Whole = tuple[int, int, int, int]


def overlap(a: Rectangle | _Whole, b: Rectangle | _Whole) -> bool:
    """Whether two rectangles in the same unit have an area in common; rectangles that only touch do not overlap."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def grown(r: Rectangle, by: float) -> Rectangle:
    """Return the rectangle, larger by `by` [m] on every side."""
    return r[0] - by, r[1] - by, r[2] + by, r[3] + by


def polygon_sides(corners: Sequence[Corner]) -> Iterator[tuple[Corner, Corner]]:
    """Return both ends of every side of a polygon, in the order of its `corners`."""
    return pairwise((*corners, corners[0]))


def cells_inside(i: Int[np.ndarray, "n"], j: Int[np.ndarray, "n"], size: tuple[int, int]) -> Bool[np.ndarray, "nx ny"]:
    """Return which of the `size` cells of a grid are inside a rectilinear polygon, whose corners are the grid points (i, j).

    A cell is inside if the polygon's winding number around it is not 0.
    """
    turns = np.zeros(size, np.int8)
    for a, b, b_next in zip(i.tolist(), j.tolist(), np.roll(j, -1).tolist(), strict=True):
        # A side along y changes the winding number of all cells beside it at larger x by one.
        if b != b_next:
            turns[a:, min(b, b_next) : max(b, b_next)] += 1 if b_next < b else -1
    return np.asarray(turns != 0)


def tiles(polygon: Polygon) -> list[Rectangle]:
    """Return rectangles that tile a rectilinear polygon [m]."""
    return _divided([(x, y) for x, y in polygon.exterior.coords[:-1]], inside=True)


def notches(corners: Sequence[Corner]) -> list[Rectangle]:
    """Return rectangles that tile the part of a rectilinear polygon's bounding box that is outside the polygon [m]."""
    return _divided(corners, inside=False)


def _divided(corners: Sequence[Corner], inside: bool) -> list[Rectangle]:
    """Divide the bounding box of a polygon along all sides, and return the rectangles that are inside it, or the others."""
    x, y = (sorted(set(values)) for values in zip(*corners, strict=True))
    if len(corners) == 4:
        return [(x[0], y[0], x[1], y[1])] if inside else []
    i, j = (np.searchsorted(lines, values) for lines, values in zip((x, y), zip(*corners, strict=True), strict=True))
    wanted = (cells_inside(i, j, (len(x) - 1, len(y) - 1)) == inside).ravel().tolist()
    cells = [(x0, y0, x1, y1) for x0, x1 in pairwise(x) for y0, y1 in pairwise(y)]
    return [cell for cell, is_wanted in zip(cells, wanted, strict=True) if is_wanted]
