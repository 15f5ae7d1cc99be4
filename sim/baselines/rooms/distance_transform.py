"""Segmentation by the distance transform: rooms are peaks of the distance to walls (Bormann et al. 2016, Sec. III-B)."""

from dataclasses import dataclass

import numpy as np

from sim.baselines.rooms.cells import Free, Segments, clearance, grown, large_components


@dataclass(frozen=True)
class DistanceTransform:
    """Keeps the cells farther from walls than a threshold. The threshold is the one that leaves the most separate parts.

    Every part is the centre of a room. The centres then grow until they cover the rest of the free space.
    """

    least_area_m2: float = 0.35
    """Least area of the centre of a room [m²]: the best of 0.05 to 4 m², tuned on homes 900 to 906 at openness 0 to 0.9, and
    the value in Bormann's survey."""
    least_m: float = 0.4
    """Smallest threshold that is tried for the distance to walls [m]; 0.55 m gives the same rooms in the tuning homes."""

    def segments(self, free: Free, resolution_m: float) -> Segments:
        """Divide the free cells of a storey into rooms."""
        distances_m = clearance(free, resolution_m)
        best = np.zeros(free.shape, np.int32)
        for least_m in np.arange(self.least_m, float(distances_m.max()), resolution_m):
            centres = large_components(distances_m > least_m, self.least_area_m2 / resolution_m**2)
            if centres.max() > best.max():
                best = centres
        return grown(best, free)
