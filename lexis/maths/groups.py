"""Groups of items that pairs join."""

import numpy as np
from jaxtyping import Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def groups_of(pairs: Int[np.ndarray, "m 2"], count: int) -> Int[np.ndarray, "n"]:
    """Return the number of the group of each of `count` items, where the two items of every pair are in one group.

    Groups are numbered from 0 in the order of their first items.
    """
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])
