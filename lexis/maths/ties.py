"""One rule for ties: values are rounded to a millionth before they are compared, and of equal ones the first is chosen.

The last digits of a sum depend on the order of its terms, and so on the processor, the numerical library and the number
of threads. A choice between candidates that are truly equal must not depend on them: it is made between settled values.
"""

import numpy as np
from jaxtyping import Bool, Float, Float64, Int, Shaped
from scipy.spatial import cKDTree

DECIMALS = 6
"""Decimals that count: a micrometre, or a millionth of a cosine similarity."""


def settled(values: Shaped[np.ndarray, "*shape"]) -> Float64[np.ndarray, "*shape"]:
    """The values in double precision, rounded so that `argmax`, `argmin` and stable sorting choose alike everywhere."""
    return np.round(np.asarray(values, np.float64), DECIMALS)


def reaches(values: Float[np.ndarray, "*shape"] | float, limit: float) -> Bool[np.ndarray, "*shape"]:
    """Whether amounts reach a limit, within a millionth: in any order, steps of 0.1 add up to 0.3."""
    return np.asarray(np.asarray(values) >= limit - 10.0**-DECIMALS)


def nearest_others(points: Float[np.ndarray, "n d"], count: int) -> Int[np.ndarray, "n k"]:
    """Row i holds the indices of the `count` points nearest to point i, itself left out (fewer where there are no more).

    Points that are equally near, within `DECIMALS`, are taken in the order of their indices. Every row ascends, so that
    sums over equal sets of points are equal to the last bit.
    """
    n, wanted = len(points), min(count + 1, len(points))
    tree, looked_at = cKDTree(points), wanted
    while True:
        looked_at = min(2 * looked_at, n)
        distances, indices = tree.query(points, k=np.arange(1, looked_at + 1))
        distances = settled(np.asarray(distances))
        if looked_at == n or (distances[:, -1] > distances[:, wanted - 1]).all():
            break
    distances[indices == np.arange(n)[:, None]] = -1.0  # a point comes first among its own nearest, and is left out
    order = np.lexsort((indices, distances), axis=1)[:, 1:wanted]
    return np.sort(np.take_along_axis(indices, order, axis=1), axis=1)
