"""`TrueMap`: the true occupancy of every storey of a house, as a grid of cells."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.ndimage import distance_transform_edt

from sim.baselines.rooms.cells import Free, Segments
from worlds.free_space import survey
from worlds.house import House
from worlds.labels import STAIRS
from worlds.truth import floor_at, room_at

RESOLUTION_M = 0.05
"""Size of a cell [m], as in the survey by Bormann et al."""
_TOUCHES_M = 1e-6
"""Cells whose centre is this close to a wall [m] are occupied. Their distance is 0 except for rounding."""


@dataclass(frozen=True, eq=False)
class TrueMap:
    """The free cells of all storeys: the cells of all rooms except walls and stairs. Furniture and door leaves are ignored.

    Bormann et al. segment maps with and without furniture. The baselines get maps without furniture, which are easier.
    """

    house: House
    x: Float64[np.ndarray, "nx"]
    """x coordinates of the cells' centres in W [m]."""
    y: Float64[np.ndarray, "ny"]
    """y coordinates of the cells' centres in W [m]."""
    free: Bool[np.ndarray, "storeys nx ny"]
    """Whether each cell is free."""

    @staticmethod
    def of(house: House) -> "TrueMap":
        """Rasterise the walls of a house."""
        space = survey(replace(house, furniture=(), leaves=()), RESOLUTION_M)
        return TrueMap(house, space.x, space.y, (space.room >= 0) & (space.clearance > _TOUCHES_M))

    def segmented(self, segment: Callable[[Free, float], Segments]) -> Int[np.ndarray, "storeys nx ny"]:
        """Segment every storey. Segments are numbered from 1, with different numbers on different storeys."""
        levels: list[Segments] = []
        below = 0
        for free in self.free:
            found = segment(free, RESOLUTION_M)
            levels.append(np.where(found > 0, found + below, 0).astype(np.int32))
            below += int(found.max(initial=0))
        return np.stack(levels)

    def floors_at(self, points: Float64[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
        """Return the number of the floor of every point (in W [m]); -1 on stairs.

        The storeys on which there are points are numbered from 0 for the lowest.
        """
        on_stairs, storeys = self._stairs_at(points) >= 0, floor_at(self.house, points)
        return np.where(on_stairs, -1, np.searchsorted(np.unique(storeys[~on_stairs]), storeys))

    def rooms_at(
        self, segments: Int[np.ndarray, "storeys nx ny"], points: Float64[np.ndarray, "n 3"]
    ) -> Int[np.ndarray, "n"]:
        """Return the segment of the free cell closest to every point (in W [m]).

        Every staircase of the house is a further segment, to which the points on the staircase belong.
        """
        level = floor_at(self.house, points)
        i, j = (np.rint((points[:, k] - axis[0]) / RESOLUTION_M).astype(int) for k, axis in enumerate((self.x, self.y)))
        i, j = np.clip(i, 0, len(self.x) - 1), np.clip(j, 0, len(self.y) - 1)
        closest = np.stack([_spread(each)[i, j] for each in segments])
        stairs = self._stairs_at(points)
        return np.asarray(np.where(stairs >= 0, segments.max() + 1 + stairs, closest[level, np.arange(len(points))]))

    def _stairs_at(self, points: Float64[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
        """Return the index in `house.rooms` of the staircase at every point; -1 for points outside of staircases."""
        rooms = room_at(self.house, points)
        stairs = [k for k, room in enumerate(self.house.rooms) if room.label == STAIRS]
        return np.where(np.isin(rooms, stairs), rooms, -1)


def _spread(segments: Segments) -> Segments:
    """Assign every cell without a segment to the segment of the closest cell that has a segment."""
    if not segments.any():
        return segments
    nearest = distance_transform_edt(segments == 0, return_distances=False, return_indices=True)
    return np.asarray(segments[tuple(nearest)])
