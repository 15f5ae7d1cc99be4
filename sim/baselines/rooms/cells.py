"""Operations on grids of cells that all segmentations of a map share. Cells with the same segment number form a segment."""

from typing import TypeAlias

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int32

Free: TypeAlias = Bool[np.ndarray, "nx ny"]
"""Whether each cell of a storey's map is free."""
Segments: TypeAlias = Int32[np.ndarray, "nx ny"]
"""Number of the segment of each cell, counted from 1; 0 for a cell without a segment."""
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
_SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))


def clearance(free: Free, resolution_m: float) -> Float32[np.ndarray, "nx ny"]:
    """Return the distance from every cell to the closest occupied cell [m]. Cells beyond the map count as occupied."""
    padded = np.pad(free, 1).astype(np.uint8)
    distances = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(distances[1:-1, 1:-1] * resolution_m, np.float32)


def components(cells: Free) -> Segments:
    """Number the connected groups of cells from 1. Each cell is connected to its four neighbours."""
    return np.asarray(cv2.connectedComponents(cells.astype(np.uint8), connectivity=4)[1], np.int32)


def large_components(cells: Free, least_cells: float, most_cells: float = np.inf) -> Segments:
    """Number the connected groups that have `least_cells` to `most_cells` cells, from 1; cells of other groups get 0."""
    found = components(cells)
    sizes = np.bincount(found.ravel())
    kept = (sizes >= least_cells) & (sizes <= most_cells)
    kept[0] = False
    return np.asarray((np.cumsum(kept) * kept)[found], np.int32)


def grown(seeds: Segments, free: Free) -> Segments:
    """Let segments grow from `seeds` as a wave front until they cover all free cells that they can reach.

    Each connected group of free cells without a seed becomes a segment of its own.
    """
    segments = seeds.astype(np.float32)
    for step in range(int(free.size)):
        front = cv2.dilate(segments, _CROSS if step % 2 else _SQUARE)
        reached = free & (segments == 0) & (front > 0)
        if not reached.any() and step % 2:
            break
        segments[reached] = front[reached]
    rest = components(free & (segments == 0))
    return np.where(rest > 0, rest + int(segments.max()), segments).astype(np.int32)
