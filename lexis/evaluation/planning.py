"""Success rate and success weighted by path length (SPL).

Source: Anderson et al., 2018, "On evaluation of embodied navigation agents".
"""

import numpy as np
from jaxtyping import Bool, Float64


def success_rate(success: Bool[np.ndarray, "n"]) -> float | None:
    """Share of the planning queries that succeeded; None without a query."""
    return float(success.mean()) if len(success) else None


def spl(
    success: Bool[np.ndarray, "n"], shortest_m: Float64[np.ndarray, "n"], travelled_m: Float64[np.ndarray, "n"]
) -> float | None:
    """Mean over planning queries of success * shortest / max(travelled, shortest); None without a query.

    A query that begins at its goal, with both lengths 0, contributes its success, 0 or 1.
    """
    if not len(success):
        return None
    longest = np.maximum(travelled_m, shortest_m)
    efficiency = np.divide(shortest_m, longest, out=np.ones_like(longest), where=longest > 0)
    return float(np.mean(success * efficiency))
