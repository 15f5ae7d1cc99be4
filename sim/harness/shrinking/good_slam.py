"""What a good SLAM could have reached in a run: a failure is evidence only in a scenario in which a good SLAM passes.

No SLAM is better than an odometry without drift, and none that closes loops is better on a walk without revisits. A claim
such as "trajectory.ate_m <= 0.5 * trajectory.ate_odometry_m" is therefore false there, whatever the SLAM does.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float64, Int

from lexis.config import PlaceRecognitionConfig, PoseGraphConfig, VerificationConfig
from lexis.evaluation.place_recognition import right_matches
from lexis.graph.graph_optimisation import GraphOptimiser
from lexis.maths.paths import arc_length
from lexis.maths.se3 import between
from lexis.types import LoopEdge, Poses
from sim.harness.figures import evaluate
from sim.harness.finished_run import Run
from sim.harness.results import RunResult
from sim.harness.trial import Trial

_ERRORS = ("ate_m", "rpe_8m_m", "rpe_24m_m")
"""The figures of `TrajectoryFigures` that a good SLAM answers for."""
_REVISIT = PlaceRecognitionConfig(min_gap_s=20.0, min_gap_m=10.0)
"""Least time and path between the two frames of a loop. They are twice those of LEXIS, so that a revisit which the good SLAM
needs is one that other SLAMs notice, too."""
_STEP_SIGMA = np.repeat([0.004, 0.03], 3)
"""Standard deviation of the odometry after 1 m of path [rad, m], as a random walk: roughly that of the preset multicam."""
_LEAST_M = 0.01
"""Least length of a step of the odometry for its covariance [m], which may not be zero."""
_LOOP_SIGMA = np.repeat([VerificationConfig.rotation_sigma_rad, VerificationConfig.translation_sigma_m], 3)
_MOST = 500
"""Largest number of poses that are optimised. Other frames keep their odometry pose relative to the last such pose."""


@dataclass(frozen=True)
class GoodSlam:
    """An imaginary SLAM that estimates the true labels, rooms and floors, and poses with small errors."""

    error_m: float
    """Constant that is added to each of its trajectory errors, so that it is not perfect [m]."""
    uses_odometry: bool = False
    """Whether its poses are those of the odometry, corrected by all true loop closures; otherwise, they are true."""

    def result(self, run: Run, trials: Sequence[Trial] = ()) -> RunResult:
        """Return the figures of a run as if this SLAM had made the estimate.

        What the SLAM of the run left out is not added; the rest of its estimate and its driven plans are kept.
        """
        poses = with_true_loops(run) if self.uses_odometry and run.estimate.T_W_B is not None else run.true_poses
        good: dict[str, Any] = {
            "T_W_B": poses,
            "labels": run.true_labels,
            "rooms": run.true_rooms,
            "floors": run.true_floors,
        }
        made = {name: value for name, value in good.items() if getattr(run.estimate, name) is not None}
        result = evaluate(replace(run, estimate=replace(run.estimate, **made)), trials)
        errors = {name: getattr(result.trajectory, name) for name in _ERRORS}
        worse = {name: error + self.error_m for name, error in errors.items() if error is not None}
        return replace(result, trajectory=replace(result.trajectory, **worse))


GOOD_SLAMS = (*(GoodSlam(error_m, uses_odometry=True) for error_m in (0.01, 0.001)), GoodSlam(0.01), GoodSlam(0.001))
"""Good SLAMs, from the one that is easiest to equal to the most exact one."""


class GoodSlamChoice:
    """The good SLAM by which a search judges whether a failure is avoidable: the first that avoids the original failure."""

    def __init__(self) -> None:
        """Leave the choice to the first call of `avoids`."""
        self._is_chosen = False
        self._slam: GoodSlam | None = None

    def avoids(self, run: Run, trials: Sequence[Trial], passes: Callable[[RunResult], bool]) -> bool:
        """Return whether the good SLAM would pass in the situation of a run that fails.

        `passes` evaluates the test or claim on the figures of another SLAM. The first call, with the run of the original
        failure, chooses the first of `GOOD_SLAMS` that passes. If none does, nothing can be said, and the result is True
        for every run.
        """
        if not self._is_chosen:
            self._slam = next((slam for slam in GOOD_SLAMS if passes(slam.result(run, trials))), None)
            self._is_chosen = True
            return True
        return self._slam is None or passes(self._slam.result(run, trials))


def with_true_loops(run: Run) -> Poses:
    """Return the poses of the odometry, corrected by a loop closure at every frame that truly revisits a place.

    Each loop closure has the true relative pose to the nearest earlier frame at that place.
    """
    count, odometry = len(run.estimate.frames), run.odometry_poses
    every = max(1, math.ceil(count / _MOST))
    rows, last = np.arange(0, count, every), np.arange(count) // every
    chosen, truth = odometry[rows], run.true_poses[rows]
    query, match = _revisits(truth, chosen, run.true_stamps[rows])
    if not len(query):
        return odometry
    graph = GraphOptimiser(chosen[0], PoseGraphConfig(kernel="none"))
    for pose, step in zip(chosen[1:], between(chosen[:-1], chosen[1:]), strict=True):
        graph.add_keyframe(pose, step, np.diag(_STEP_SIGMA**2) * max(np.linalg.norm(step[:3, 3]), _LEAST_M))
    covariance = np.diag(_LOOP_SIGMA**2)
    relative = between(truth[match], truth[query])
    edges = zip(query.tolist(), match.tolist(), relative, strict=True)
    graph.add_loops([LoopEdge(later, earlier, pose, covariance, 0) for later, earlier, pose in edges])
    return np.asarray(graph.optimise()[last] @ between(chosen[last], odometry))


def _revisits(
    truth: Poses, odometry: Poses, stamps: Float64[np.ndarray, "n"]
) -> tuple[Int[np.ndarray, "k"], Int[np.ndarray, "k"]]:
    """Return the frames that revisit a place, and for each the nearest earlier frame at this place."""
    query, match = right_matches(truth, stamps, arc_length(odometry[:, :3, 3]), _REVISIT)
    apart_m = np.linalg.norm(truth[query, :3, 3] - truth[match, :3, 3], axis=1)
    nearest = np.lexsort((match, apart_m, query))
    revisits, first = np.unique(query[nearest], return_index=True)
    return revisits, match[nearest][first]
