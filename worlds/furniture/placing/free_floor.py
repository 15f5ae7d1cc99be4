"""`FreeFloor`: the floor of a room that a walking body can reach, updated as furniture is added."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from jaxtyping import UInt8

from worlds.furniture.placing.room_shape import Point, RoomShape
from worlds.rectangles import Rectangle, grown
from worlds.walls import HALF_WALL_M

PLACING_RADIUS_M = 0.32
"""Radius of the body that has to pass [m].

The radius is larger than the 0.25 m of the body in `worlds.walkable`. The grid of `worlds.walkable` has 10 cm cells, too,
but may be shifted against the grid of `FreeFloor`. Thanks to the larger radius, a path on the grid of `FreeFloor` also
exists on the other grid.
"""
CELL_M = 0.1
_REACH = int(PLACING_RADIUS_M / CELL_M)
_RIM = 2 * _REACH
"""Number of blocked cells around the bounding box, so that a block of cells around any place stays inside the grid."""
_BODY = np.ones((2 * _REACH + 1,) * 2, np.uint8)
_Cells = UInt8[np.ndarray, "rows columns"]
_Cell = tuple[int, int]


class FreeFloor:
    """A grid over a room that marks the cells that the centre of a body can reach from the passages into the room."""

    def __init__(self, shape: RoomShape, entries: Sequence[Point], leaves: Sequence[Rectangle] = ()) -> None:
        """Begin with the room without furniture.

        `entries` are points in front of the passages. `leaves` are the footprints of open door leaves. A leaf is an obstacle
        unless it would disconnect the passages or leave less than half of the room's area to walk on.
        """
        self._area = shape.area_m2 / CELL_M**2
        self._box = width, depth = (math.ceil(shape.size[0] / CELL_M - 1e-6), math.ceil(shape.size[1] / CELL_M - 1e-6))
        bare = np.zeros((depth + 2 * _RIM, width + 2 * _RIM), np.uint8)
        bare[self._cells(grown((0.0, 0.0, *shape.size), -HALF_WALL_M - PLACING_RADIUS_M))] = 1
        for notch in shape.notches:
            bare[self._cells(grown(notch, HALF_WALL_M + PLACING_RADIUS_M))] = 0
        self._doors = _nearest_free(bare, entries)
        self._free, self._covered = _reached(bare, self._doors)
        for leaf in leaves:
            self.block(leaf, 0.5)

    def block(self, place: Rectangle, share: float) -> bool:
        """Block `place` if all passages stay connected and a body can still cover `share` of the room's area.

        Return True if both conditions hold. Otherwise, return False and leave the floor unchanged.
        """
        rows, columns = window = self._cells(grown(place, PLACING_RADIUS_M))
        if not self._free[window].any():
            return self._covered >= share * self._area
        if any(rows.start <= i < rows.stop and columns.start <= j < columns.stop for i, j in self._doors):
            return False
        if self._stays_in_one(rows, columns):
            covered = self._covered - self._lost(rows, columns)
            if covered >= share * self._area:
                self._free[window] = 0
                self._covered = covered
                return True
            return False
        trial = self._free.copy()
        trial[window] = 0
        free, covered = _reached(trial, self._doors)
        if covered < share * self._area:
            return False
        self._free, self._covered = free, covered
        return True

    def _stays_in_one(self, rows: slice, columns: slice) -> bool:
        """Return whether the free cells right around a window (a block of cells) are connected to each other.

        If so, blocking the window cuts nothing off. The cells are connected if, once around the window, they change from
        blocked to free at most once. This local test avoids a flood fill.
        """
        a = self._free[rows.start - 1 : rows.stop + 1, columns.start - 1 : columns.stop + 1]
        ring = a[0].tobytes() + a[1:-1, -1].tobytes() + a[-1, ::-1].tobytes() + a[-2:0:-1, 0].tobytes()
        return b"\1" in ring and (ring + ring[:1]).count(b"\0\1") <= 1

    def _lost(self, rows: slice, columns: slice) -> int:
        """Return how many cells a body can no longer cover if its centre must stay out of a window (a block of cells)."""
        around = self._free[rows.start - _RIM : rows.stop + _RIM, columns.start - _RIM : columns.stop + _RIM]
        without = around.copy()
        without[_RIM:-_RIM, _RIM:-_RIM] = 0
        inner = slice(_REACH, -_REACH)
        before, after = (cv2.dilate(cells, _BODY)[inner, inner] for cells in (around, without))
        return int(np.count_nonzero(before)) - int(np.count_nonzero(after))

    def _cells(self, r: Rectangle) -> tuple[slice, slice]:
        """Return the slices (rows, columns) of the cells of the room's bounding box whose centres lie in the rectangle."""
        (x0, y0, x1, y1), (width, depth) = r, self._box
        return _between(y0, y1, depth), _between(x0, x1, width)


def _between(low: float, high: float, count: int) -> slice:
    start = min(max(math.ceil(low / CELL_M - 0.5), 0), count)
    stop = max(min(math.floor(high / CELL_M - 0.5) + 1, count), start)
    return slice(start + _RIM, stop + _RIM)


def _nearest_free(free: _Cells, entries: Sequence[Point]) -> frozenset[_Cell]:
    cells = set()
    for x, y in entries:
        i, j = y / CELL_M - 0.5 + _RIM, x / CELL_M - 0.5 + _RIM
        if not free[round(i), round(j)]:
            rows, columns = np.nonzero(free)
            if not len(rows):
                break
            nearest = int(np.argmin((rows - i) ** 2 + (columns - j) ** 2))
            i, j = int(rows[nearest]), int(columns[nearest])
        cells.add((round(i), round(j)))
    return frozenset(cells)


def _reached(free: _Cells, doors: frozenset[_Cell]) -> tuple[_Cells, int]:
    """Return the free cells connected to all doors, and the number of cells that a body covers from these cells.

    Without doors, the largest connected region is taken. If the doors are not connected to each other, no cell is free and
    the number is 0.
    """
    region = _joined_to(free, *doors) if doors else _largest(free)
    return region, int(np.count_nonzero(cv2.dilate(region, _BODY)))


def _joined_to(free: _Cells, first: _Cell, *others: _Cell) -> _Cells:
    filled = free.copy()
    if filled[first]:
        cv2.floodFill(filled, None, first[::-1], 2)
    region = (filled == 2).astype(np.uint8)
    return region if all(region[other] for other in others) else np.zeros_like(free)


def _largest(free: _Cells) -> _Cells:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    sizes = stats[1:, cv2.CC_STAT_AREA]
    return (labels == 1 + int(np.argmax(sizes))).astype(np.uint8) if len(sizes) else np.zeros_like(free)
