"""Which loop edges of a run are true."""

import numpy as np
from jaxtyping import Bool

from lexis.evaluation.loops import true_edges
from sim.harness.runner import Run


def edge_truth(run: Run) -> Bool[np.ndarray, "loops"]:
    """Per loop edge of the map: whether its relative pose is within 0.5 m and 0.2 rad of the truth."""
    edges = run.map.loops
    query, match = (np.array([getattr(edge, end) for edge in edges], int) for end in ("query", "match"))
    measured = np.array([edge.T_match_query for edge in edges]).reshape(-1, 4, 4)
    return true_edges(query, match, measured, run.true_poses)
