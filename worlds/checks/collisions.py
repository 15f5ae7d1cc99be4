"""Collisions between upright boxes, and between boxes and convex outlines, for all pairs at once.

The test uses the separating axis theorem in the plan: two convex shapes are apart if and only if their projections on the
normal of one of their sides are apart. Heights are compared separately. Before the test, a spatial index excludes pairs that
are far apart.
"""

import numpy as np
import shapely
from jaxtyping import Bool, Float64, Int

from worlds.free_space import Obstacles

Pairs = Int[np.ndarray, "k 2"]
"""One pair of indices per row; rows are sorted by the first index, then by the second."""


def overlaps(a: Obstacles, b: Obstacles, tolerance_m: float) -> Pairs:
    """Return pairs (index in `a`, index in `b`) of boxes that overlap by more than `tolerance_m` [m] in every direction.

    The result is exact for boxes with any yaw. A box without thickness counts as a line, which overlaps a box if it reaches
    more than `tolerance_m` into the box.
    """
    i, j = _near(a.corners, b.corners, tolerance_m).T
    meet = _at_one_height(a.span[i], b.span[j], tolerance_m)
    i, j = i[meet], j[meet]
    axes_a, axes_b = _axes(a)[i], _axes(b)[j]
    axes = np.concatenate([axes_a, axes_b], axis=1)
    apart = np.abs(np.einsum("kad,kd->ka", axes, b.centre[j] - a.centre[i]))
    reach = _reach(axes, axes_a, a.size[i]) + _reach(axes, axes_b, b.size[j])
    meet = (apart < reach - tolerance_m).all(axis=1)
    return np.stack([i[meet], j[meet]], axis=1)


def outlines_over(
    outlines: Float64[np.ndarray, "m v 2"], spans: Float64[np.ndarray, "m 2"], boxes: Obstacles, tolerance_m: float
) -> Pairs:
    """Return pairs (index of a body, index of a box) that overlap by more than `tolerance_m` [m] in every direction.

    The bodies are upright prisms. `outlines` has the corners of each body's base, a convex polygon in the plan, clockwise or
    counter-clockwise; `spans` has the heights of each body's bottom and top [m].
    """
    i, j = _near(outlines, boxes.corners, tolerance_m).T
    meet = _at_one_height(spans[i], boxes.span[j], tolerance_m)
    i, j = i[meet], j[meet]
    sides = np.roll(outlines[i], -1, axis=1) - outlines[i]
    normals = np.stack([-sides[..., 1], sides[..., 0]], axis=-1)
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    axes = np.concatenate([normals, _axes(boxes)[j]], axis=1)
    one, other = (np.einsum("kad,kvd->kav", axes, shape) for shape in (outlines[i], boxes.corners[j]))
    depth = np.minimum(one.max(axis=2), other.max(axis=2)) - np.maximum(one.min(axis=2), other.min(axis=2))
    meet = (depth > tolerance_m).all(axis=1)
    return np.stack([i[meet], j[meet]], axis=1)


def _near(a: Float64[np.ndarray, "n v 2"], b: Float64[np.ndarray, "m w 2"], tolerance_m: float) -> Pairs:
    """Return pairs of polygons whose bounding rectangles overlap by more than `tolerance_m` [m]."""
    half = tolerance_m / 2
    rectangles = [shapely.box(*(c.min(axis=1) + half).T, *(c.max(axis=1) - half).T) for c in (a, b)]
    pairs = shapely.STRtree(rectangles[1]).query(rectangles[0])
    return np.asarray(pairs[:, np.lexsort(pairs[::-1])].T)


def _at_one_height(
    a: Float64[np.ndarray, "k 2"], b: Float64[np.ndarray, "k 2"], tolerance_m: float
) -> Bool[np.ndarray, "k"]:
    """Return, for each pair of height ranges, whether these overlap by more than `tolerance_m` [m]."""
    return np.asarray(np.minimum(a[:, 1], b[:, 1]) - np.maximum(a[:, 0], b[:, 0]) > tolerance_m)


def _axes(boxes: Obstacles) -> Float64[np.ndarray, "n 2 2"]:
    """Return two unit vectors for every box, along its width and along its depth."""
    cos, sin = np.cos(boxes.yaw), np.sin(boxes.yaw)
    return np.stack([cos, sin, -sin, cos], axis=-1).reshape(-1, 2, 2)


def _reach(
    directions: Float64[np.ndarray, "k 4 2"], axes: Float64[np.ndarray, "k 2 2"], size: Float64[np.ndarray, "k 2"]
) -> Float64[np.ndarray, "k 4"]:
    """Return how far each box extends from its centre in each of the given directions [m]."""
    return np.asarray(np.einsum("kab,kb->ka", np.abs(np.einsum("kad,kbd->kab", directions, axes)), size / 2))
