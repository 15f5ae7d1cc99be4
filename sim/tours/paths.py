"""`KnownPaths`: a cache of the paths between the places that a tour visits."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from worlds.walkable import Walkable, polyline_length


@dataclass(frozen=True, eq=False)
class KnownPaths:
    """Paths between nodes of the walkable graph. Each path is searched for once and then remembered."""

    walkable: Walkable
    prefer_clearance_m: float
    straight: bool = False
    """Whether to take the straight line wherever it is free of collisions, even if it is close to obstacles."""
    _known: dict[tuple[int, int], Float64[np.ndarray, "k 3"]] = field(default_factory=dict)

    def leg(self, a: int, b: int) -> Float64[np.ndarray, "k 3"]:
        """Return the path from node `a` to node `b` in W [m]. Raises `UnreachableError` if no path exists."""
        if (a, b) not in self._known:
            self._known[a, b] = self._found(a, b)
        return self._known[a, b]

    def length(self, a: int, b: int) -> float:
        """Return the length of the path from node `a` to node `b` [m]."""
        return polyline_length(self.leg(a, b))

    def line(self, nodes: Sequence[int]) -> Float64[np.ndarray, "k 3"]:
        """Return the path in W [m] that visits the nodes in order."""
        return np.concatenate([self.leg(a, b) for a, b in pairwise(nodes) if a != b])

    def _found(self, a: int, b: int) -> Float64[np.ndarray, "k 3"]:
        ends = self.walkable.nodes[[a, b]]
        if self.straight and ends[0, 2] == ends[1, 2] and self._is_free(ends):
            return ends
        return self.walkable.path(a, b, self.prefer_clearance_m)

    def _is_free(self, ends: Float64[np.ndarray, "2 3"]) -> bool:
        return bool(self.walkable.barriers.clear(ends[:1], ends[1:], self.walkable.radius_m)[0])
