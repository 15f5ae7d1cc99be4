"""`PlanGrid`: the floor plans of a house as an exact grid of cells.

The plan is cut along every x and y at which a room has a side, so each cell lies entirely inside or entirely outside every
room, and questions about rooms become operations on arrays.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int

from worlds.rectangles import cells_inside
from worlds.spec import HouseSpec, RoomSpec

NO_ROOM = -1
_DECIMALS = 6


@dataclass(frozen=True, eq=False)
class PlanGrid:
    """A grid of cells over every storey's plan, with the room that covers each cell.

    Rooms are numbered in the order of the spec, storey by storey.
    """

    x: Float64[np.ndarray, "columns"]
    """The x coordinates of all lines between cells, and of the two outer sides of the grid, ascending [m]."""
    y: Float64[np.ndarray, "rows"]
    """The y coordinates of all lines between cells, and of the two outer sides of the grid, ascending [m]."""
    rooms: tuple[RoomSpec, ...]
    level_of_room: tuple[int, ...]
    """Index of every room's storey."""
    owner: Int[np.ndarray, "storeys nx ny"]
    """Number of the room that covers each cell; `NO_ROOM` if there is none, and the last room's number if rooms overlap."""
    clashes: tuple[tuple[int, int, float], ...]
    """For each pair of overlapping rooms on one storey: the numbers of both rooms, and the area of the overlap [m²]."""

    @staticmethod
    def of(spec: HouseSpec) -> "PlanGrid":
        """Build the grid of a house. The house may be invalid."""
        rooms = [(level, room) for level, storey in enumerate(spec.storeys) for room in storey.rooms]
        corners = [np.round(room.polygon_m, _DECIMALS) for _, room in rooms]
        x, y = (np.unique(np.concatenate([c[:, k] for c in corners])) for k in (0, 1))
        area = np.outer(np.diff(x), np.diff(y))
        owner = np.full((len(spec.storeys), len(x) - 1, len(y) - 1), NO_ROOM)
        clashes = []
        for index, ((level, _), ring) in enumerate(zip(rooms, corners, strict=True)):
            i, j = np.searchsorted(x, ring[:, 0]), np.searchsorted(y, ring[:, 1])
            window = np.s_[i.min() : i.max(), j.min() : j.max()]
            inside = cells_inside(i - i.min(), j - j.min(), area[window].shape)
            here = owner[level][window]
            taken = np.unique(here[inside & (here != NO_ROOM)])
            clashes += [(int(other), index, float(area[window][inside & (here == other)].sum())) for other in taken]
            here[inside] = index
        return PlanGrid(x, y, tuple(r for _, r in rooms), tuple(level for level, _ in rooms), owner, tuple(clashes))

    @property
    def area(self) -> Float64[np.ndarray, "nx ny"]:
        """Area of every cell [m²]."""
        return np.outer(np.diff(self.x), np.diff(self.y))

    def owner_at(self, level: Int[np.ndarray, "n"], points: Float64[np.ndarray, "n 2"]) -> Int[np.ndarray, "n"]:
        """Return the number of the room at each point (x, y) [m] of a storey `level`; `NO_ROOM` outside of all rooms."""
        return np.asarray(self._padded[level, self._index(self.x, points[:, 0]), self._index(self.y, points[:, 1])])

    def lattice(self, x: Float64[np.ndarray, "n"], y: Float64[np.ndarray, "m"]) -> Int[np.ndarray, "storeys n m"]:
        """Return the number of the room at each point (x[i], y[j]) [m] of every storey; `NO_ROOM` outside of all rooms."""
        return np.asarray(self._padded[:, self._index(self.x, x)[:, None], self._index(self.y, y)])

    @cached_property
    def _padded(self) -> Int[np.ndarray, "storeys nx ny"]:
        """Return `owner` (the room number of each cell) with a border one cell wide, for points outside of the grid.

        Cells of the border belong to no room (`NO_ROOM`).
        """
        return np.pad(self.owner, ((0, 0), (1, 1), (1, 1)), constant_values=NO_ROOM)

    @staticmethod
    def _index(lines: Float64[np.ndarray, "k"], at: Float64[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
        return np.searchsorted(lines, at, side="right")
