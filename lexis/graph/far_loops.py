"""`FarLoops`: loops that images confirm although the pose estimate rules them out, because the robot may have been carried.

Odometry does not notice that a robot is picked up and put down elsewhere (the kidnapped-robot problem). All later poses are
then displaced by one rigid motion, and verification refuses each true loop to an earlier place, because it is far from the
estimate. Rooms that look alike give such loops, too, but these are false. What tells one from the other are steps of the
odometry, from one keyframe to the next:

- A far loop claims that the robot was carried in one of the steps between its two keyframes.
- A loop that fits the estimate bridges all steps between its two keyframes: the robot was carried in none of them.
- A far loop of which all steps are bridged is therefore false.

The other far loops may be true. They displace the robot to where it may be, and place recognition searches there, too
(`FarLoops.poses_of`), until images were compared there several times in vain. At the end of a session, far loops may correct
the map (`lexis.sessions.kidnapping`).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between, inverse, rotation_angle
from lexis.types import LoopArrays, LoopEdge, Pose, Poses

LEVEL_M = 2.0
"""A displacement counts if it changes the height of the robot by less than this [m], which is less than a storey. Storeys
that look alike give many far loops, and a robot is rarely carried to another storey."""
_MOST, _MOST_OPEN = 2000, 300
"""Largest numbers of far loops that are kept, and of those that displace the robot. The newest ones are kept."""
_SAME_M, _SAME_RAD = 1.0, 0.35
"""Displacements count as one if they lead to poses of the robot that differ by at most this [m, rad]."""
_BESIDE_M, _BESIDE_RAD = 0.7, 0.35
"""Largest distance and angle between a displaced pose and a keyframe whose images must then show the same place [m, rad]."""
_IN_VAIN = 5
"""The robot is no longer searched at a displaced pose when so many keyframes in turn were compared with keyframes beside it,
and no far loop confirmed the displacement."""


@dataclass
class _OpenLoop:
    """A far loop that may be true."""

    loop: LoopEdge
    in_vain: int = 0
    """Number of keyframes in turn that were compared in vain with keyframes beside the poses to which it leads."""


class _Displaced(NamedTuple):
    """A pose that the robot may have, and the far loops that lead to it."""

    T_W_B: Pose
    loops: Sequence[_OpenLoop]


class FarLoops:
    """The far loops of a pose graph, each between two keyframes of one session."""

    def __init__(self) -> None:
        """Begin without loops."""
        self.all: Sequence[LoopEdge] = []
        """The far loops in the order in which they were found, whether or not other loops bridge their steps."""
        self._open: list[_OpenLoop] = []
        self._is_bridged = GrowingArray((), bool)

    def add_step(self) -> None:
        """Add the step that leads to a new keyframe."""
        self._is_bridged.append(False)

    def add(self, query: int, candidates: Sequence[int], loops: Sequence[LoopEdge], T_W_B: Poses) -> None:
        """Add the far loops of the newest keyframe, `query`, whose images were compared with those of the candidates.

        `T_W_B` are the current estimates of all keyframes.
        """
        new = [_OpenLoop(loop) for loop in loops]
        seen = _implied(new, query, T_W_B)
        for displaced in self._displaced(query, T_W_B):
            if _close(displaced.T_W_B, T_W_B[list(candidates)], _BESIDE_M, _BESIDE_RAD).any():
                confirmed = _close(displaced.T_W_B, seen, _SAME_M, _SAME_RAD).any()
                for each in displaced.loops:
                    each.in_vain = 0 if confirmed else each.in_vain + 1
        self.all = [*self.all, *loops][-_MOST:]
        self._open = [*self._open, *new][-_MOST_OPEN:]
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
        self.all = [loop for loop in self.all if (loop.query, loop.match) not in gone]
        self._open = [each for each in self._open if (each.loop.query, each.loop.match) not in gone]

    def poses_of(self, query: int, T_W_B: Poses) -> Poses:
        """Return the poses that the keyframe `query` may have: its estimate first, then those that far loops imply.

        Poses that nearly coincide are returned once. `T_W_B` are the current estimates of all keyframes.
        """
        return np.array([T_W_B[query], *(displaced.T_W_B for displaced in self._displaced(query, T_W_B))])

    def _displaced(self, query: int, T_W_B: Poses) -> Iterator[_Displaced]:
        """Yield the poses to which far loops displace the keyframe `query` on its level, those of the newest loops first."""
        implied = _implied(self._open, query, T_W_B)
        left = np.flatnonzero(np.abs(implied[:, 2, 3] - T_W_B[query, 2, 3]) < LEVEL_M)[::-1]
        while len(left):
            together = _close(implied[left[0]], implied[left], _SAME_M, _SAME_RAD)
            yield _Displaced(implied[left[0]], [self._open[i] for i in left[together].tolist()])
            left = left[~together]

    def _keep_open_ones(self) -> None:
        """Drop far loops from the search of which all steps are bridged, or that have led to poses in vain."""
        if not self._open:
            return
        count = np.concatenate([[0], np.cumsum(~self._is_bridged.rows)])
        skips = (count[each.loop.query + 1] > count[each.loop.match + 1] for each in self._open)
        self._open = [each for each, may in zip(self._open, skips, strict=True) if may and each.in_vain < _IN_VAIN]


def _implied(loops: Sequence[_OpenLoop], query: int, T_W_B: Poses) -> Poses:
    """Return the pose of the keyframe `query` that each loop implies."""
    arrays = LoopArrays.of([each.loop for each in loops])
    moved = T_W_B[arrays.match] @ arrays.T_match_query @ inverse(T_W_B[arrays.query])
    return np.asarray(moved @ T_W_B[query])


def _close(pose: Pose, others: Poses, most_m: float, most_rad: float) -> Bool[np.ndarray, "others"]:
    off = between(pose, others)
    distances, angles = np.linalg.norm(off[:, :3, 3], axis=1), rotation_angle(off)
    return np.asarray(np.logical_and(distances <= most_m, angles <= most_rad))
