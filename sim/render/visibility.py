"""Determines which parts of a house a camera may see, by the method of cells and portals.

Cells are the indoor rooms, and one cell for everything outdoors. Portals are the openings between cells.

1. Start in each cell that contains the camera, with the camera's view as a range of azimuths and slopes.
2. Clip the view at each opening of the cell. If part of the view remains, enter the cell behind the opening with this part.
3. Repeat step 2 in all cells that are entered, until no part of the view remains at any opening.

The result contains every visible cell, and possibly others: door leaves and furniture are ignored, and openings count as
boxes that are slightly larger than the openings.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lexis.types import Intrinsics, Pose
from worlds.house import House
from worlds.rectangles import tiles
from worlds.walls import HALF_WALL_M

Cells = frozenset[int]
"""A set of visibility cells, as indices into `House.rooms`. The index `len(House.rooms)` is the cell of the outdoors."""
_MARGIN_M = 0.1
"""Margin by which openings are enlarged [m]."""
_TOLERANCE_M = 0.01
"""Least depth to which an object must reach into a cell to count as inside that cell [m]."""


@dataclass(frozen=True)
class _Box:
    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float

    def holds(self, x: float, y: float, z: float) -> bool:
        return self.x0 <= x <= self.x1 and self.y0 <= y <= self.y1 and self.z0 <= z <= self.z1


@dataclass(frozen=True)
class _View:
    """A range of azimuths [rad] and a range of slopes (height over horizontal distance), as seen from one point."""

    left: float
    right: float
    down: float
    up: float

    def through(self, box: _Box, x: float, y: float, z: float) -> "_View | None":
        """Return the part of the view from the point (x, y, z) through the opening `box`; None if the box is out of view."""
        across, along = max(box.x0 - x, x - box.x1, 0.0), max(box.y0 - y, y - box.y1, 0.0)
        nearest = math.hypot(across, along)
        if nearest == 0.0:
            return self
        middle = math.atan2((box.y0 + box.y1) / 2 - y, (box.x0 + box.x1) / 2 - x)
        corners = [(cx - x, cy - y) for cx in (box.x0, box.x1) for cy in (box.y0, box.y1)]
        turns = [math.remainder(math.atan2(dy, dx) - middle, math.tau) for dx, dy in corners]
        farthest = max(math.hypot(dx, dy) for dx, dy in corners)
        middle += math.tau * round(((self.left + self.right) / 2 - middle) / math.tau)
        left, right = max(self.left, middle + min(turns)), min(self.right, middle + max(turns))
        rise, fall = box.z1 - z, box.z0 - z
        up = min(self.up, rise / (nearest if rise > 0 else farthest))
        down = max(self.down, fall / (nearest if fall < 0 else farthest))
        return _View(left, right, down, up) if left < right and down < up else None


_ALL_AROUND = _View(-10.0, 10.0, -math.inf, math.inf)


class Visibility:
    """Finds the cells of a house that a camera may see. Cells are the indoor rooms, and one cell for everything outdoors."""

    def __init__(self, house: House) -> None:
        self.outdoors = len(house.rooms)
        self.all: Cells = frozenset(range(self.outdoors + 1))
        self._cell_of_room = {room.id: self.outdoors if room.outdoor else i for i, room in enumerate(house.rooms)}
        slab = house.spec.slab_m
        self._boxes = [
            (
                self._cell_of_room[room.id],
                _Box(x0, y0, room.floor_m, x1, y1, math.inf if room.outdoor else room.ceiling_m + slab),
            )
            for room in house.rooms
            for x0, y0, x1, y1 in tiles(room.polygon)
        ]
        self._openings: dict[int, list[tuple[_Box, int]]] = defaultdict(list)
        for box, a, b in self._gaps(house):
            self._openings[a].append((box, b))
            self._openings[b].append((box, a))

    def cell_of_room(self, room: str) -> int:
        """Return the index of a room's cell; the cell of the outdoors for outdoor rooms and for ids of no room."""
        return self._cell_of_room.get(room, self.outdoors)

    def cells_of(self, points: Float64[np.ndarray, "*n 3"]) -> Cells:
        """Return the cells into which the bounding box of points in W [m] reaches; if it is in none, the outdoor cell."""
        x0, y0, z0 = (points.reshape(-1, 3).min(axis=0) + _TOLERANCE_M).tolist()
        x1, y1, z1 = (points.reshape(-1, 3).max(axis=0) - _TOLERANCE_M).tolist()
        reached = (
            c for c, b in self._boxes if b.x0 < x1 and x0 < b.x1 and b.y0 < y1 and y0 < b.y1 and b.z0 < z1 and z0 < b.z1
        )
        return frozenset(reached) or frozenset([self.outdoors])

    def seen(self, T_W_C: Pose, intrinsics: Intrinsics) -> Cells:
        """Return all cells that a camera sees, and possibly others; all cells if the camera is in no room."""
        x, y, z = T_W_C[:3, 3].tolist()
        own = {cell for cell, box in self._boxes if box.holds(x, y, z)}
        if not own:
            return self.all
        view = _horizontal(T_W_C, intrinsics)
        seen: set[int] = set()
        # Cells on the current path are not entered again: the view that is left is part of the view at their first visit.
        todo = [(cell, view, frozenset([cell])) for cell in own]
        while todo:
            cell, view, path = todo.pop()
            seen.add(cell)
            for box, other in self._openings[cell]:
                if other not in path and (rest := view.through(box, x, y, z)) is not None:
                    todo.append((other, rest, path | {other}))
        return frozenset(seen)

    def _gaps(self, house: House) -> Iterator[tuple[_Box, int, int]]:
        for level, pieces in enumerate(house.boundaries):
            floor, around = house.storeys[level].floor_m, HALF_WALL_M + _MARGIN_M
            for boundary, opening in pieces:
                if opening is None:
                    continue
                a, b = (self._cell_of_room[house.room_by_id[room].id] if room else self.outdoors for room in boundary.rooms)
                height = house.wall_height(level, boundary)
                low, high = opening.gap_m(height)
                (x0, y0), (x1, y1) = boundary.point(boundary.low), boundary.point(boundary.high)
                lower, upper = floor + low - _MARGIN_M, floor + min(high, height) + _MARGIN_M
                if a != b:
                    yield _Box(x0 - around, y0 - around, lower, x1 + around, y1 + around, upper), a, b


def _horizontal(T_W_C: Pose, intrinsics: Intrinsics) -> _View:
    """Return a view of the azimuths in the image; of all azimuths if straight up or straight down is in the image."""
    k = intrinsics
    x0, x1 = (-0.5 - k.cx) / k.fx, (k.width - 0.5 - k.cx) / k.fx
    y0, y1 = (-0.5 - k.cy) / k.fy, (k.height - 0.5 - k.cy) / k.fy
    a, b, c = T_W_C[2, :3].tolist()
    if abs(c) > 0.0 and x0 <= a / c <= x1 and y0 <= b / c <= y1:
        return _ALL_AROUND
    rays = [(T_W_C[:2, :3] @ (x, y, 1.0)).tolist() for x in (x0, x1) for y in (y0, y1)]
    ahead = math.atan2(T_W_C[1, 2], T_W_C[0, 2])
    turns = [math.remainder(math.atan2(dy, dx) - ahead, math.tau) for dx, dy in rays]
    return _View(ahead + min(turns), ahead + max(turns), -math.inf, math.inf)
