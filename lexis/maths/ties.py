"""One rule for ties: values are rounded to a millionth before they are compared, and the first of equal values is chosen.

The last digits of a sum depend on the order of its terms, and therefore on the processor, the numerical library and the
number of threads. A choice between equal candidates must not depend on these digits, so it is made on rounded values.
"""

import numpy as np
from jaxtyping import Bool, Float, Float64, Int, Shaped
from scipy.spatial import cKDTree

DECIMALS = 6
"""Number of decimals to which values are rounded: a micrometre for positions, a millionth for cosine similarities."""
MILLIONTH = 10.0**-DECIMALS
"""Difference up to which a value that is below a limit still reaches it."""


def rounded(values: Shaped[np.ndarray, "*shape"]) -> Float64[np.ndarray, "*shape"]:
    """Round values, in double precision, so that `argmax`, `argmin` and stable sorting choose alike on all machines."""
    return np.round(np.asarray(values, np.float64), DECIMALS)


def reaches(values: Float[np.ndarray, "*shape"] | float, limit: float) -> Bool[np.ndarray, "*shape"]:
    """Whether each value is at least `limit` minus a millionth. Ten steps of 0.1 thus reach 1 despite rounding errors."""
    return np.asarray(np.asarray(values) >= limit - MILLIONTH)


def near_pairs(points: Float[np.ndarray, "n d"], distance: float) -> Int[np.ndarray, "m 2"]:
    """Return the pairs of points that are at most `distance` apart, when rounded to `DECIMALS`, the smaller index first."""
    pairs = cKDTree(points).query_pairs(distance + MILLIONTH, output_type="ndarray")  # none is lost before the rounding
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    return np.asarray(pairs[rounded(lengths) <= distance])


def nearest_others(points: Float[np.ndarray, "n d"], count: int) -> Int[np.ndarray, "n k"]:
    """Return in row i the indices of the `count` nearest other points of point i, or of all others if there are fewer.

    Points that are equally near, when rounded to `DECIMALS`, are taken in the order of their indices. The indices in a row
    ascend, so that sums over equal sets of points are equal to the last bit.
    """
    # Query more and more neighbours until every row holds all points that are as near as the last wanted point.
    n, wanted = len(points), min(count + 1, len(points))
    tree, queried = cKDTree(points), wanted
    while True:
        queried = min(2 * queried, n)
        distances, indices = tree.query(points, k=np.arange(1, queried + 1))
        distances = rounded(np.asarray(distances))
        if queried == n or (distances[:, -1] > distances[:, wanted - 1]).all():
            break
    distances[indices == np.arange(n)[:, None]] = -1.0  # every point comes first in its own row and is dropped
    order = np.lexsort((indices, distances), axis=1)[:, 1:wanted]
    return np.sort(np.take_along_axis(indices, order, axis=1), axis=1)
