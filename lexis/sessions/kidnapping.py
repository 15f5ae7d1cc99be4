"""Kidnapping: in which step of its path a robot was carried elsewhere (beyond the paper).

A robot that is picked up and put down elsewhere does not notice it. Later loops to earlier places are then far from the
estimate (`lexis.graph.far_loops`). At the end of a session, the map is corrected if the far loops of many keyframes agree on
one displacement, which keeps the height. The robot was carried in the step that most of these loops skip, among the steps
that no trusted loop bridges.

Rooms that look alike also give far loops that agree. They must not correct the map:

- When a robot that was not carried comes back, trusted loops bridge all of its steps.
- If it does not come back, several steps are skipped equally often. The map is then corrected only if the loops are of
  several visits or of a long one, because the robot usually sees rooms that look alike in one short visit. The less similar
  the images before and after a step are, the more probable is the step. The median of the steps is chosen, weighted by
  their probabilities: it displaces the fewest keyframes wrongly, in expectation.

A session is corrected once, for the kidnapping that most keyframes show: loops across the corrected step would also bridge
the step of a second kidnapping.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, islice

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.config import VerificationConfig
from lexis.graph.far_loops import LEVEL_M, is_close, shifts_of, steps_of
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.ties import rounded
from lexis.sessions.relocalisation import agree, queries_of
from lexis.types import LoopArrays, LoopEdge, Pose, Poses
from lexis.verification import within_drift

_BETWEEN_VISITS = 8
"""Two visits lie more than this many keyframes apart."""
_LONG = 40
"""Number of agreeing keyframes that suffices in one visit. In rooms that look alike, at most 22 agree
(lexis/pages/places.md)."""
_NEAR_M, _NEAR_RAD = 1.5, 0.35
"""Two loops displace a keyframe alike if they lead to poses that differ by at most this [m, rad]."""
_SIMILARITY_WEIGHT = 20.0
"""Log odds by which a step is less probable for each unit of similarity of the images before and after it. In 14 tuning
walks with several possible steps (`home`, `ori`, `uh2-apt`, `apartment` and `uh2-office`, seeds 306 to 319), the chosen step
is 0.6 keyframes off on average and at most 6; with 10, it is up to 19 off. No command repeats this study. The least similar
step is as close there, but was 122 keyframes off in a test house (`uh2-apt`, seed 500)."""

_Steps = Bool[np.ndarray, "steps"]
"""A flag for every step of the path. A step is named by the keyframe to which it leads."""


@dataclass(frozen=True, eq=False)
class Kidnapping:
    """A step of the path in which the robot was carried, and the loops that show it."""

    step: int
    """Id of the first keyframe after it."""
    loops: tuple[LoopEdge, ...]
    """The loops that agree, each from a keyframe after the step to one before it."""
    shift: Pose
    """Rigid motion in the frame W that moves the keyframes after the step to where the loops see them."""
    is_only_step: bool
    """Whether the loops skip no other step as often."""

    @property
    def queries(self) -> list[int]:
        """Ids of the later keyframes of the loops, ascending."""
        return sorted(queries_of(self.loops))

    @property
    def is_certain(self) -> bool:
        """Whether the loops agree on this step alone, or are of several visits or of a long one."""
        several_visits = bool((np.diff(self.queries) > _BETWEEN_VISITS).any())
        return self.is_only_step or several_visits or len(self.queries) >= _LONG


def find_kidnapping(graph: PoseGraph, agreeing: int, tolerances: VerificationConfig) -> Kidnapping | None:
    """Return the kidnapping in the last session that most keyframes show, or None if none is certain.

    At least `agreeing` keyframes must have far loops that agree, within the limits of `lexis.verification.within_drift`.
    """
    is_open = ~graph.bridged
    left = [loop for loop in _far_loops(graph, tolerances) if is_open[steps_of(loop)].any()]
    certain = []
    while left:
        fits = agree(left[0], left, graph, tolerances)
        group = [left[i] for i in np.flatnonzero(fits).tolist()]
        left = [left[i] for i in np.flatnonzero(~fits).tolist()]
        if len(queries_of(group)) >= agreeing:
            found = _by_votes(group, is_open, graph)
            if len(found.queries) >= agreeing and found.is_certain and _is_level(found, graph):
                certain.append(found)
    return max(certain, key=lambda found: len(found.queries), default=None)


def strongest(loops: Iterable[LoopEdge], count: int) -> list[LoopEdge]:
    """Return the loops without those of a query that already has `count` loops with more inliers, ascending by query."""
    ranked = sorted(loops, key=lambda loop: (loop.query, -loop.inliers))
    return [loop for _, own in groupby(ranked, key=lambda loop: loop.query) for loop in islice(own, count)]


def _far_loops(graph: PoseGraph, tolerances: VerificationConfig) -> list[LoopEdge]:
    """Return the far loops of the last session that are still far from the estimate, without those of retired keyframes."""
    known = [
        loop
        for loop in graph.far_loops.kept
        if loop.query >= graph.session_start and graph.keyframes[loop.query].anchor is None
    ]
    loops = LoopArrays.of(known)
    measured, path_m = graph.T_W_B[loops.match] @ loops.T_match_query, graph.path_m[loops.query] - graph.path_m[loops.match]
    near = within_drift(measured, graph.T_W_B[loops.query], path_m, tolerances)
    return [known[i] for i in np.flatnonzero(~near).tolist()]


def _by_votes(loops: Sequence[LoopEdge], is_open: _Steps, graph: PoseGraph) -> Kidnapping:
    """Return the open step that most of the loops skip, with those of the loops that displace the robot as most do."""
    votes = np.zeros(len(is_open), int)
    for loop in loops:
        votes[steps_of(loop)] += is_open[steps_of(loop)]
    steps = np.flatnonzero(votes == votes.max())
    step = int(steps[_median(np.exp(-_SIMILARITY_WEIGHT * _similarities(steps, graph)))])
    skipping = [loop for loop in loops if loop.match < step <= loop.query]
    shifts = shifts_of(skipping, graph.T_W_B)
    usual, alike = _usual(shifts @ graph.T_W_B[step])
    agreeing = tuple(skipping[i] for i in np.flatnonzero(alike).tolist())
    return Kidnapping(step, agreeing, shifts[usual], len(steps) == 1)


def _median(weights: Float64[np.ndarray, "k"]) -> int:
    """Return the index at which half of the weights are reached."""
    return int(np.argmax(rounded(np.cumsum(weights) / weights.sum()) >= 0.5))


def _similarities(steps: Int[np.ndarray, "k"], graph: PoseGraph) -> Float64[np.ndarray, "k"]:
    """Return how similar the images before and after each step are: the mean cosine similarity over all cameras."""
    before, after = (np.stack([graph.keyframes[id].embeddings for id in ids.tolist()]) for ids in (steps - 1, steps))
    return rounded((before.astype(np.float64) * after).sum(axis=2).mean(axis=1))


def _usual(poses: Poses) -> tuple[int, Bool[np.ndarray, "n"]]:
    """Return the row of the pose to which most of the poses are near, and which ones are."""
    near = np.stack([is_close(pose, poses, _NEAR_M, _NEAR_RAD) for pose in poses])
    usual = int(near.sum(axis=1).argmax())
    return usual, near[usual]


def _is_level(found: Kidnapping, graph: PoseGraph) -> bool:
    """Whether the displacement hardly changes the height of the robot."""
    T_W_B = graph.T_W_B[found.step]
    return bool(abs((found.shift @ T_W_B - T_W_B)[2, 3]) < LEVEL_M)
