"""`PlanGrid`: the plan of a house cut along every line that a room has a side on; rooms are sets of cells, exactly."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64, Int

from worlds.spec import HouseSpec, RoomSpec

NO_ROOM = -1
_DECIMALS = 6


@dataclass(frozen=True, eq=False)
class PlanGrid:
    """Which rooms cover which cells of every storey. Rooms are numbered in the order of the spec, storey by storey."""

    x: Float64[np.ndarray, "columns"]
    """Where the cells begin and end, one more than there are cells [m]."""
    y: Float64[np.ndarray, "rows"]
    rooms: tuple[RoomSpec, ...]
    level_of_room: tuple[int, ...]
    owner: Int[np.ndarray, "storeys nx ny"]
    """Room that covers a cell (of several, the last), `NO_ROOM` where none does."""
    clashes: tuple[tuple[int, int, float], ...]
    """Rooms of a storey that cover the same cells, and the area that they share [m²]."""

    @staticmethod
    def of(spec: HouseSpec) -> "PlanGrid":
        """The grid of a house, which need not stand."""
        rooms = [(level, room) for level, storey in enumerate(spec.storeys) for room in storey.rooms]
        corners = [np.round(room.polygon_m, _DECIMALS) for _, room in rooms]
        x, y = (np.unique(np.concatenate([c[:, k] for c in corners])) for k in (0, 1))
        area = np.outer(np.diff(x), np.diff(y))
        owner = np.full((len(spec.storeys), len(x) - 1, len(y) - 1), NO_ROOM)
        clashes = []
        for index, ((level, _), ring) in enumerate(zip(rooms, corners, strict=True)):
            (i0, j0), inside = _cells(np.searchsorted(x, ring[:, 0]), np.searchsorted(y, ring[:, 1]))
            window = np.s_[i0 : i0 + inside.shape[0], j0 : j0 + inside.shape[1]]
            here = owner[level][window]
            taken = np.unique(here[inside & (here != NO_ROOM)])
            clashes += [(int(other), index, float(area[window][inside & (here == other)].sum())) for other in taken]
            here[inside] = index
        return PlanGrid(x, y, tuple(r for _, r in rooms), tuple(level for level, _ in rooms), owner, tuple(clashes))

    @property
    def area(self) -> Float64[np.ndarray, "nx ny"]:
        """Of every cell [m²]."""
        return np.outer(np.diff(self.x), np.diff(self.y))

    def owner_at(self, level: Int[np.ndarray, "n"], points: Float64[np.ndarray, "n 2"]) -> Int[np.ndarray, "n"]:
        """The room at each point of a storey, `NO_ROOM` outside of all."""
        return np.asarray(self._framed[level, self._place(self.x, points[:, 0]), self._place(self.y, points[:, 1])])

    def lattice(self, x: Float64[np.ndarray, "n"], y: Float64[np.ndarray, "m"]) -> Int[np.ndarray, "storeys n m"]:
        """The room at each point of a lattice, `NO_ROOM` outside of all."""
        return np.asarray(self._framed[:, self._place(self.x, x)[:, None], self._place(self.y, y)])

    @cached_property
    def _framed(self) -> Int[np.ndarray, "storeys nx ny"]:
        return np.pad(self.owner, ((0, 0), (1, 1), (1, 1)), constant_values=NO_ROOM)

    @staticmethod
    def _place(lines: Float64[np.ndarray, "k"], at: Float64[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
        return np.searchsorted(lines, at, side="right")


def _cells(i: Int[np.ndarray, "n"], j: Int[np.ndarray, "n"]) -> tuple[tuple[int, int], Bool[np.ndarray, "a b"]]:
    """The cells inside a rectilinear ring of grid points, and the first row and column of them: by its winding number."""
    i0, j0 = int(i.min()), int(j.min())
    turns = np.zeros((int(i.max()) - i0, int(j.max()) - j0), np.int8)
    for a, b, b_next in zip((i - i0).tolist(), (j - j0).tolist(), np.roll(j - j0, -1).tolist(), strict=True):
        # A side that runs along y turns the winding number of all cells beyond it.
        if b != b_next:
            turns[a:, min(b, b_next) : max(b, b_next)] += 1 if b_next < b else -1
    return (i0, j0), turns != 0
