"""`edge_truth`: compares the loop closures of a SLAM with the true poses."""

import numpy as np
from jaxtyping import Bool

from lexis.evaluation.loops import true_edges
from sim.harness.finished_run import Run


def edge_truth(run: Run) -> Bool[np.ndarray, "loops"]:
    """Return, for each estimated loop, whether its relative pose is within 0.5 m and 0.2 rad of the truth."""
    loops = run.estimate.loops
    if loops is None:
        return np.zeros(0, bool)
    return true_edges(loops.query, loops.match, loops.T_match_query, run.true_poses)
