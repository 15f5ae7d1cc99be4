"""`FarLoops`: loops that images confirm although the pose estimate rules them out, because the robot may have been carried.

Odometry does not notice that a robot is picked up and put down elsewhere (the kidnapped-robot problem). All later poses are
then displaced by one rigid motion, and verification refuses each true loop to an earlier place, because it is far from the
estimate. Rooms that look alike give such loops, too, but these are false. What tells one from the other are steps of the
odometry, from one keyframe to the next:

- A far loop claims that the robot was carried in one of the steps between its two keyframes.
- A loop that fits the estimate bridges all steps between its two keyframes: the robot was carried in none of them.
- A far loop of which all steps are bridged is therefore false.

The other far loops may be true. They displace the robot to where it may be, and place recognition searches there, too
(`FarLoops.poses_of`). At the end of a session, they may correct the map (`lexis.sessions.kidnapping`).
"""

from collections.abc import Iterable, Sequence

import numpy as np
from jaxtyping import Bool

from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between, inverse, rotation_angle
from lexis.types import LoopArrays, LoopEdge, Pose, Poses

LEVEL_M = 2.0
"""A displacement counts if it changes the height of the robot by less than this [m], which is less than a storey. Storeys
that look alike give many far loops, and a robot is rarely carried to another storey."""
_MOST = 2000
"""Largest number of far loops that are kept; the newest ones are."""
_SAME_M, _SAME_RAD = 1.0, 0.35
"""Displacements count as one if they lead to poses of the robot that differ by at most this [m, rad]."""


class FarLoops:
    """The far loops of a pose graph, each between two keyframes of one session."""

    def __init__(self) -> None:
        """Begin without loops."""
        self.all: Sequence[LoopEdge] = []
        """The far loops in the order in which they were found, whether or not other loops bridge their steps."""
        self._open: list[LoopEdge] = []
        self._is_bridged = GrowingArray((), bool)

    def add_step(self) -> None:
        """Add the step that leads to a new keyframe."""
        self._is_bridged.append(False)

    def add(self, loops: Sequence[LoopEdge]) -> None:
        """Add far loops of the newest keyframe."""
        self.all = [*self.all, *loops][-_MOST:]
        self._open = [*self._open, *loops][-_MOST:]
        self._keep_open_ones()

    def bridge(self, loops: Iterable[LoopEdge]) -> None:
        """Bridge the steps between the keyframes of loops that fit the estimate, each between keyframes of one session."""
        for loop in loops:
            steps = np.arange(loop.match + 1, loop.query + 1)
            self._is_bridged.replace(steps, np.ones(len(steps), bool))
        self._keep_open_ones()

    def remove(self, loops: Iterable[LoopEdge]) -> None:
        """Remove far loops that have become part of the graph."""
        gone = {(loop.query, loop.match) for loop in loops}
        self.all, self._open = (
            [loop for loop in kept if (loop.query, loop.match) not in gone] for kept in (self.all, self._open)
        )

    def poses_of(self, query: int, T_W_B: Poses) -> Poses:
        """Return the poses that the keyframe `query` may have: its estimate first, then those that far loops imply.

        Poses that nearly coincide are returned once. `T_W_B` are the current estimates of all keyframes.
        """
        estimate = T_W_B[query]
        if not self._open:
            return np.array([estimate])
        loops = LoopArrays.of(self._open)
        implied = T_W_B[loops.match] @ loops.T_match_query @ inverse(T_W_B[loops.query]) @ estimate
        left = implied[np.abs(implied[:, 2, 3] - estimate[2, 3]) < LEVEL_M][::-1]
        found = [estimate]
        while len(left):
            found.append(left[0])
            left = left[~_same(left[0], left)]
        return np.array(found)

    def _keep_open_ones(self) -> None:
        """Drop far loops from the search of which all steps are bridged."""
        if self._open:
            count = np.concatenate([[0], np.cumsum(~self._is_bridged.rows)])
            self._open = [loop for loop in self._open if count[loop.query + 1] > count[loop.match + 1]]


def _same(pose: Pose, others: Poses) -> Bool[np.ndarray, "others"]:
    off = between(pose, others)
    distances, angles = np.linalg.norm(off[:, :3, 3], axis=1), rotation_angle(off)
    return np.asarray(np.logical_and(distances <= _SAME_M, angles <= _SAME_RAD))
