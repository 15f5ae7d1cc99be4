"""The area of every room, as cells of a storey.

A free cell belongs to the room of the keyframe from which the way to the cell is shortest. A way leads through free cells
only: through doors and never through walls. Cells that a room encloses, such as those under its furniture, belong to the
room too.
"""

from collections.abc import Iterator, Mapping

import numpy as np
import shapely
from jaxtyping import Bool, Int
from scipy.ndimage import binary_fill_holes
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from lexis.sight.cells import CELL_M
from lexis.sight.storey_grid import StoreyGrid, on_storey
from lexis.types import LexisMap

ROOM_REACH_M = 4.0
"""Longest way from a keyframe to a cell of its room [m]. Cells that are seen from afar through doors thus belong to no
room."""
NO_ROOM = -1
Rectangle = tuple[int, int, int, int]
"""First row, first column, the row after the last row, and the column after the last column."""


def room_masks(map: LexisMap, grid: StoreyGrid) -> Mapping[int, Bool[np.ndarray, "rows columns"]]:
    """Return which cells of a storey belong to each room, by the room's id. A cell belongs to at most one room."""
    owners = _owners(map, grid)
    masks = {}
    for room in map.rooms:
        own = owners == room.id
        if own.any():
            masks[room.id] = binary_fill_holes(own) & ((owners == room.id) | (owners == NO_ROOM))
            owners[masks[room.id]] = room.id
    return masks


def _owners(map: LexisMap, grid: StoreyGrid) -> Int[np.ndarray, "rows columns"]:
    """Return the id of every free cell's room; `NO_ROOM` for cells that are not free or not reached."""
    cameras = (map.T_W_B @ map.camera.T_B_C)[:, :3, 3]
    starts = np.flatnonzero(on_storey(map, grid.floor, grid.component) & (map.room_of >= 0))
    number = np.full(grid.free.shape, -1)
    number[grid.free] = np.arange(grid.free.sum())
    cells, first = np.unique(number[tuple(grid.cells(cameras[starts]).T)], return_index=True)
    owners = np.full(grid.free.shape, NO_ROOM)
    if not len(cells):
        return owners
    steps = dijkstra(
        _steps_between(number), indices=cells, min_only=True, return_predecessors=True, limit=ROOM_REACH_M / CELL_M
    )
    room_of_cell = np.full(len(steps[0]), NO_ROOM)
    room_of_cell[cells] = map.room_of[starts[first]]
    reached = np.isfinite(steps[0])
    owners[grid.free] = np.where(reached, room_of_cell[np.where(reached, steps[2], 0)], NO_ROOM)
    return owners


def _steps_between(number: Int[np.ndarray, "rows columns"]) -> csr_array:
    """Return the graph of steps from each free cell to the free cells beside it, as a symmetric matrix.

    `number` is the number of each free cell, and -1 for all other cells.
    """
    pairs = np.concatenate([
        np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1),
        np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1),
    ])  # fmt: skip
    a, b = pairs[(pairs >= 0).all(axis=1)].T
    size = int(number.max()) + 1
    return csr_array((np.ones(2 * len(a)), (np.concatenate([a, b]), np.concatenate([b, a]))), shape=(size, size))


def rectangles(mask: Bool[np.ndarray, "rows columns"]) -> list[Rectangle]:
    """Divide the marked cells into rectangles.

    A rectangle is a stretch of marked cells in one row, joined with the same stretches in the rows below it.
    """
    whole: list[Rectangle] = []
    growing: dict[tuple[int, int], int] = {}
    for row in range(len(mask) + 1):
        stretches = set(_stretches(mask[row])) if row < len(mask) else set()
        for ends in sorted(set(growing) - stretches):
            whole.append((growing.pop(ends), ends[0], row, ends[1]))
        for ends in stretches:
            growing.setdefault(ends, row)
    return whole


def _stretches(row: Bool[np.ndarray, "columns"]) -> Iterator[tuple[int, int]]:
    """Yield the first marked cell of every stretch of a row, and the cell after the last marked cell."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(np.int8)))
    yield from zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True)


def outline(mask: Bool[np.ndarray, "rows columns"], grid: StoreyGrid) -> shapely.MultiPolygon:
    """Return the marked cells as polygons in W [m]."""
    boxes = [shapely.box(c, r, c_end, r_end) for r, c, r_end, c_end in rectangles(mask)]
    cells = shapely.union_all(boxes)
    area = shapely.transform(cells, lambda corners: np.round(grid.origin + CELL_M * corners, 6))
    return shapely.MultiPolygon([part for part in shapely.get_parts(area) if isinstance(part, shapely.Polygon)])
