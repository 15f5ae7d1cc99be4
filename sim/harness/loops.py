"""Which loop edges of a run are true."""

import numpy as np
from jaxtyping import Bool

from lexis.evaluation.loops import true_edges
from lexis.loop_arrays import LoopArrays
from sim.harness.runner import Run


def edge_truth(run: Run) -> Bool[np.ndarray, "loops"]:
    """Per loop edge of the map: whether its relative pose is within 0.5 m and 0.2 rad of the truth."""
    edges = LoopArrays.of(run.map.loops)
    return true_edges(edges.query, edges.match, edges.T_match_query, run.true_poses)
