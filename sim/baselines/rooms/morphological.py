"""Morphological segmentation: erosion divides the free space into parts, the rooms (Bormann et al. 2016, Sec. III-A)."""

from dataclasses import dataclass

import numpy as np

from sim.baselines.rooms.cells import Free, Segments, clearance, grown, large_components


@dataclass(frozen=True)
class Morphological:
    """Erodes the free space by one cell at a time. A part that is cut off becomes a room if it has the area of a room.

    Rooms are not eroded further. At the end, they grow until they cover the rest of the free space.
    """

    least_area_m2: float = 0.8
    """Least area of an eroded room [m²]: the best of 0.2 to 2 m² on the tuning homes, and the value of Bormann's survey."""
    most_area_m2: float = 16.0
    """Largest area of an eroded room [m²]: the best of 6 to 47 m², tuned on homes 900 to 906 at openness 0 to 0.9. The
    value of Bormann's survey is 47 m²."""

    def segments(self, free: Free, resolution_m: float) -> Segments:
        """Divide the free cells of a storey into rooms."""
        distances_m = clearance(free, resolution_m)
        limits = self.least_area_m2 / resolution_m**2, self.most_area_m2 / resolution_m**2
        rooms = np.zeros(free.shape, np.int32)
        rest = free.copy()
        for depth_m in np.arange(0.0, float(distances_m.max()), resolution_m):
            rest &= distances_m > depth_m
            found = large_components(rest, *limits)
            rooms[found > 0] = found[found > 0] + rooms.max()
            rest &= found == 0
        return grown(rooms, free)
