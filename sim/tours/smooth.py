"""`smooth_path`: smooths a walkable polyline as if it were an elastic band, and keeps the body's clearance from obstacles.

1. Divide the line into points 5 cm apart (the band), and find the obstacles near each point.
2. Minimise the band's bending plus its distance from the line, under the constraint of clearance. ADMM alternates between a
   linear solve (bending and distance) and pushing points away from the nearest box (clearance, with exact distances).
3. Take the points as the control points of a cubic B-spline.
4. Where the spline is still too close to an obstacle, blend back to the line, which is known to be free of collisions.
5. Resample the path at equal distances.
"""

import math
from itertools import pairwise

import numpy as np
from jaxtyping import Float64, Int
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.ndimage import grey_dilation, uniform_filter1d

from lexis.maths.paths import arc_length
from sim.tours.clearance import NearbyBoxes
from worlds.walkable import Walkable

STEP_M = 0.01
"""Distance between the points of a smooth path [m]."""
_BAND_STEP_M = 0.05
"""Distance between the points of the band [m]."""
_PER_STEP = 5
"""Number of points of the spline per step of the band."""
_STIFFNESS = 6.0**4
"""Weight of bending. With a weight of k⁴, the band rounds a corner over about k of its steps on either side."""
_PENALTY = 3.0
"""Penalty parameter of ADMM."""
_ITERATIONS = 50
_DIGITS = 6
"""Number of decimals to which coordinates are rounded after every iteration (micrometres). The last bits of LAPACK's results
differ between processors, and corners of obstacles would amplify such differences to metres."""
_AT_STAIRS = 3.0
"""Weight that holds the band close to the original line near stairs. Elsewhere on the floor, this weight is 1."""
_ON_STAIRS = 20.0
"""Weight that holds the band close to the original line on stairs."""
_PINNED = 1e4
"""Weight that holds the band to the original line at both ends, and at points at which the line turns back."""
_SPARE_M = (0.01, 0.05)
"""Clearance that the band keeps in addition to the body's radius, at least and at most [m]. In between, it keeps as much
clearance as the original line."""
_NEEDED_M = 0.002
"""Clearance that the path keeps in addition to the body's radius [m]. The motion is another spline, over time, which cuts
the path's corners by about a millimetre."""
_REACH_M = 0.3
"""Largest distance by which the band is expected to move away from the original line [m]. Obstacles are searched as far as
this requires."""
_BLEND = 8
"""Number of steps of the band over which the smooth path is blended into the original line."""
_SLOPE_STEPS = 5
"""Width of the moving average that rounds the path's height at the foot and head of stairs [steps]. It is applied twice."""
_TURNS_BACK = -0.85
"""Cosine of the least angle by which the line turns at a point where it turns back. The band has to keep such points."""


def smooth_path(line: Float64[np.ndarray, "k 3"], walkable: Walkable) -> Float64[np.ndarray, "_ 3"]:
    """Smooth a walkable polyline in W [m] and return points 1 cm apart.

    Corners are rounded, except where the polyline turns back.
    """
    base = _divided(line)
    base[:, 2] = _rounded(base[:, 2])
    reach = walkable.radius_m + _SPARE_M[1] + _REACH_M
    wells = NearbyBoxes.of(base, walkable.wells, reach)
    at_stairs = np.flatnonzero(wells.distance(base[:, :2]) < walkable.radius_m - 1e-6)
    near = NearbyBoxes.of(base, walkable.solids, reach).and_also(wells.without(at_stairs))
    hold = np.ones(len(base))
    hold[at_stairs] = _AT_STAIRS
    hold[1:][np.diff(base[:, 2]) != 0.0] = _ON_STAIRS
    hold[_turning_points(base)] = _PINNED
    keep = np.clip(near.distance(base[:, :2]), walkable.radius_m + _SPARE_M[0], walkable.radius_m + _SPARE_M[1])
    band = _relaxed(base[:, :2], hold, near, keep)
    smooth, straight = _spline(np.column_stack([band, base[:, 2]])), _between(base)
    return evenly(_clear(smooth, straight, near, walkable.radius_m + _NEEDED_M), STEP_M)


def evenly(points: Float64[np.ndarray, "k 3"], step_m: float) -> Float64[np.ndarray, "_ 3"]:
    """Return points on a polyline at equal distances of about `step_m` [m], with both ends."""
    s = arc_length(points)
    at = np.linspace(0.0, s[-1], max(2, round(s[-1] / step_m) + 1))
    return np.stack([np.interp(at, s, axis) for axis in points.T], axis=-1)


def _divided(line: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "n 3"]:
    """Return the line's corners and points between them, at most a step of the band apart, without duplicates."""
    line = line[np.append(True, np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-6)]
    pieces = [
        np.linspace(a, b, math.ceil(float(np.linalg.norm(b - a)) / _BAND_STEP_M), endpoint=False) for a, b in pairwise(line)
    ]
    return np.concatenate([*pieces, line[-1:]])


def _rounded(height: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n"]:
    """Smooth the bends of the path's height at the ends of slopes, by a moving average that is applied twice.

    Level stretches stay exactly as they are.
    """
    for _ in range(2):
        wide = np.pad(height, _SLOPE_STEPS // 2, mode="edge")
        windows = np.lib.stride_tricks.sliding_window_view(wide, _SLOPE_STEPS)
        height = np.where(np.ptp(windows, axis=1) == 0.0, height, windows.mean(axis=1))
    return height


def _turning_points(base: Float64[np.ndarray, "n 3"]) -> Int[np.ndarray, "_"]:
    """Return the indices of both ends and of the points at which the path turns back."""
    step = np.diff(base[:, :2], axis=0)
    step /= np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-9)
    back = np.flatnonzero((step[1:] * step[:-1]).sum(axis=1) < _TURNS_BACK) + 1
    return np.concatenate([[0], back, [len(base) - 1]])


def _relaxed(
    base: Float64[np.ndarray, "n 2"], hold: Float64[np.ndarray, "n"], near: NearbyBoxes, keep: Float64[np.ndarray, "n"]
) -> Float64[np.ndarray, "n 2"]:
    """Compute the band by ADMM: a path that bends little, stays close to the points `base`, and keeps clear of obstacles.

    `hold` are the weights of the distance from `base`, and `keep` the distances to keep from the obstacles [m].
    """
    n = len(base)
    if n < 5:
        return base
    bending = np.zeros((3, n))  # LAPACK's upper banded form of D'D, D being the second difference
    bending[2] = np.concatenate([[1, 5], np.full(n - 4, 6), [5, 1]])
    bending[1, 1:] = -np.concatenate([[2], np.full(n - 3, 4), [2]])
    bending[0, 2:] = 1
    system = _STIFFNESS * bending
    system[2] += hold + _PENALTY
    factor = cholesky_banded(system)
    drawn, dual = hold[:, None] * base, np.zeros_like(base)
    free = band = base
    for _ in range(_ITERATIONS):
        band = cho_solve_banded((factor, False), drawn + _PENALTY * (free - dual)).round(_DIGITS)
        free = near.pushed_out(band + dual, keep)
        dual += band - free
    return np.concatenate([base[:1], band[1:-1], base[-1:]])


def _spline(points: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "m d"]:
    """Return points of the cubic B-spline with these control points: `_PER_STEP` points per step, and the last point."""
    wide = np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])
    t = np.arange(_PER_STEP)[:, None, None] / _PER_STEP
    basis = (1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3
    count = len(points) - 1
    spans = sum(weight / 6 * wide[k : k + count] for k, weight in enumerate(basis))
    return np.concatenate([np.swapaxes(spans, 0, 1).reshape(-1, points.shape[1]), points[-1:]])


def _between(points: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "m d"]:
    """Return points of the polyline through `points`, each of which corresponds to a point that `_spline` returns."""
    t = np.arange(_PER_STEP)[:, None, None] / _PER_STEP
    spans = (1 - t) * points[:-1] + t * points[1:]
    return np.concatenate([np.swapaxes(spans, 0, 1).reshape(-1, points.shape[1]), points[-1:]])


def _clear(
    smooth: Float64[np.ndarray, "m 3"], straight: Float64[np.ndarray, "m 3"], near: NearbyBoxes, distance_m: float
) -> Float64[np.ndarray, "m 3"]:
    """Return the smooth path, blended into the straight path around places where the smooth path is too close to obstacles.

    `distance_m` is the clearance to keep; where the straight path has less clearance, the clearance of the straight path is
    enough. Blended parts may still be too close, so blending is repeated until no part is.
    """
    needed = np.minimum(distance_m, _clearance(straight, near))
    share, path, wide = np.zeros(len(smooth)), smooth, (_BLEND * _PER_STEP,)
    while (bad := (_clearance(path, near) < needed) & (share < 1.0)).any():
        share = np.maximum(share, grey_dilation(bad.astype(np.float64), size=wide))
        eased = uniform_filter1d(grey_dilation(share, size=wide), wide[0])
        share = np.where(share == 1.0, 1.0, eased)
        path = smooth + share[:, None] * (straight - smooth)
    return path


def _clearance(path: Float64[np.ndarray, "m 3"], near: NearbyBoxes) -> Float64[np.ndarray, "m"]:
    """Return the clearance of the path's points [m]. `_PER_STEP` consecutive points belong to each point of the band."""
    clearance = np.full(len(path), np.inf)
    for k in range(_PER_STEP):
        places = path[k::_PER_STEP, :2]
        padded = np.concatenate([places, places[-1:]])[: near.points]
        clearance[k::_PER_STEP] = near.distance(padded)[: len(places)]
    return clearance
