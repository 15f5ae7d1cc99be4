"""`LoopArrays`: loop edges as arrays, for computations over all of them at once and for files."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from lexis.types import LoopEdge


@dataclass(frozen=True, eq=False)
class LoopArrays:
    """The fields of loop edges, each stacked in the order of the edges. Without edges, the arrays keep their other axes."""

    query: Int[np.ndarray, "m"]
    match: Int[np.ndarray, "m"]
    T_match_query: Float64[np.ndarray, "m 4 4"]
    covariance: Float64[np.ndarray, "m 6 6"]
    """[rad², m²]"""
    inliers: Int[np.ndarray, "m"]

    @staticmethod
    def of(edges: Sequence[LoopEdge]) -> "LoopArrays":
        """The arrays of `edges`."""
        return LoopArrays(
            np.array([edge.query for edge in edges], int),
            np.array([edge.match for edge in edges], int),
            np.array([edge.T_match_query for edge in edges], float).reshape(-1, 4, 4),
            np.array([edge.covariance for edge in edges], float).reshape(-1, 6, 6),
            np.array([edge.inliers for edge in edges], int),
        )

    def edges(self) -> tuple[LoopEdge, ...]:
        """The loop edges: the inverse of `of`. Poses and covariances are views of the arrays."""
        numbers = zip(self.query.tolist(), self.match.tolist(), self.inliers.tolist(), strict=True)
        return tuple(
            LoopEdge(query, match, self.T_match_query[i], self.covariance[i], inliers)
            for i, (query, match, inliers) in enumerate(numbers)
        )
