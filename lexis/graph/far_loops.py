"""`FarLoops`: loops that images confirm although the pose estimate rules them out, because the robot may have been carried.

Odometry does not notice that a robot is picked up and put down elsewhere (the kidnapped-robot problem). All later poses are
then displaced by one rigid motion, and verification refuses each true loop to an earlier place, because it is far from the
estimate. Rooms that look alike give such loops, too, but these are false. What tells one from the other are steps of the
odometry, from one keyframe to the next:

- A far loop claims that the robot was carried in one of the steps between its two keyframes.
- A loop that fits the estimate bridges all steps between its two keyframes: the robot was carried in none of them.
- A far loop of which all steps are bridged is therefore false.

The other far loops may be true. They displace the robot to where it may be, and place recognition searches there, too
(`FarLoops.poses_of`), until several keyframes in turn were compared there and no far loop confirmed it. At the end of a
session, far loops may correct the map (`lexis.sessions.kidnapping`).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between, inverse, rotation_angle
from lexis.types import LoopArrays, LoopEdge, Pose, Poses

LEVEL_M = 2.0
"""A displacement counts if it changes the height of the robot by less than this [m], which is less than a storey. Storeys
that look alike give many far loops, and a robot is rarely carried to another storey."""
_MOST, _MOST_POSSIBLE, _MOST_POSES = 2000, 300, 10
"""Largest numbers of far loops that are kept for the end of the session, of those that displace the robot, and of different
poses to which they displace it. The newest ones are kept."""
_SAME_M, _SAME_RAD = 1.0, 0.35
"""Displacements count as one if they lead to poses of the robot that differ by at most this [m, rad]."""
_BESIDE_M, _BESIDE_RAD = 0.7, 0.35
"""Largest distance and angle between a displaced pose and a keyframe whose images must then show the same place [m, rad]."""
_MOST_FAILURES = 5
"""The robot is no longer searched at a displaced pose when so many keyframes in turn were compared with keyframes beside it,
and no far loop confirmed the displacement."""


@dataclass
class _PossibleLoop:
    """A far loop that may be true."""

    loop: LoopEdge
    failures: int = 0
    """Number of keyframes in turn that were compared with keyframes beside the pose to which it leads, without a far loop
    that confirms this pose."""


class _Displaced(NamedTuple):
    """A pose that the robot may have, and the far loops that lead to it."""

    T_W_B: Pose
    loops: Sequence[_PossibleLoop]


class FarLoops:
    """The far loops of a pose graph, each between two keyframes of one session."""

    def __init__(self) -> None:
        """Begin without loops."""
        self.kept: Sequence[LoopEdge] = []
        """The far loops in the order in which they were found, whether or not other loops bridge their steps."""
        self._possible: list[_PossibleLoop] = []
        self._is_bridged = GrowingArray((), bool)

    def begin_session(self) -> None:
        """Forget the poses that the robot may have had in the session before."""
        self._possible = []

    def add_step(self) -> None:
        """Add the step that leads to a new keyframe."""
        self._is_bridged.append(False)

    def add(self, query: int, candidates: Sequence[int], loops: Sequence[LoopEdge], T_W_B: Poses) -> None:
        """Add the far loops of the newest keyframe, `query`, whose images were compared with those of the candidates.

        For each displaced pose beside a candidate, this also counts whether one of the new loops confirms it. `T_W_B` are
        the current estimates of all keyframes.
        """
        new = [_PossibleLoop(loop) for loop in loops]
        seen = _implied(new, query, T_W_B)
        for displaced in self._displaced(query, T_W_B):
            if is_close(displaced.T_W_B, T_W_B[list(candidates)], _BESIDE_M, _BESIDE_RAD).any():
                confirmed = is_close(displaced.T_W_B, seen, _SAME_M, _SAME_RAD).any()
                for each in displaced.loops:
                    each.failures = 0 if confirmed else each.failures + 1
        self.kept = [*self.kept, *loops][-_MOST:]
        self._possible = [*self._possible, *new][-_MOST_POSSIBLE:]
        self._drop_false_ones()

    def bridge(self, loops: Iterable[LoopEdge]) -> None:
        """Bridge the steps between the keyframes of loops that fit the estimate, each between keyframes of one session."""
        for loop in loops:
            self._is_bridged.replace(steps_of(loop), True)
        self._drop_false_ones()

    def poses_of(self, query: int, T_W_B: Poses) -> Float64[np.ndarray, "poses 4 4"]:
        """Return the poses that the keyframe `query` may have: its estimate first, then those that far loops imply.

        Poses that nearly coincide are returned once, and of many different ones those of the newest loops. `T_W_B` are the
        current estimates of all keyframes.
        """
        displaced = (each.T_W_B for each in islice(self._displaced(query, T_W_B), _MOST_POSES))
        return np.array([T_W_B[query], *displaced])

    def _displaced(self, query: int, T_W_B: Poses) -> Iterator[_Displaced]:
        """Yield the poses to which far loops displace the keyframe `query` on its level, those of the newest loops first."""
        implied = _implied(self._possible, query, T_W_B)
        left = np.flatnonzero(np.abs(implied[:, 2, 3] - T_W_B[query, 2, 3]) < LEVEL_M)[::-1]
        while len(left):
            together = is_close(implied[left[0]], implied[left], _SAME_M, _SAME_RAD)
            yield _Displaced(implied[left[0]], [self._possible[i] for i in left[together].tolist()])
            left = left[~together]

    def _drop_false_ones(self) -> None:
        """Drop far loops from the search of which all steps are bridged, or that have led to poses in vain."""
        if not self._possible:
            return
        count = np.concatenate([[0], np.cumsum(~self._is_bridged.rows)])
        self._possible = [
            each
            for each in self._possible
            if count[each.loop.query + 1] > count[each.loop.match + 1] and each.failures < _MOST_FAILURES
        ]


def steps_of(loop: LoopEdge) -> slice:
    """Return the steps between the two keyframes of a loop. A step has the id of the keyframe to which it leads."""
    return slice(loop.match + 1, loop.query + 1)


def shifts_of(loops: Sequence[LoopEdge], T_W_B: Poses) -> Float64[np.ndarray, "loops 4 4"]:
    """Return the rigid motion in the frame W, for each loop, that moves the later keyframe to where the loop sees it."""
    arrays = LoopArrays.of(loops)
    return np.asarray(T_W_B[arrays.match] @ arrays.T_match_query @ inverse(T_W_B[arrays.query]))


def _implied(loops: Sequence[_PossibleLoop], query: int, T_W_B: Poses) -> Float64[np.ndarray, "loops 4 4"]:
    """Return the pose of the keyframe `query` that each loop implies."""
    return np.asarray(shifts_of([each.loop for each in loops], T_W_B) @ T_W_B[query])


def is_close(pose: Pose, others: Poses, most_m: float, most_rad: float) -> Bool[np.ndarray, "others"]:
    """Return which of the other poses differ from a pose by at most the given distance [m] and angle [rad]."""
    off = between(pose, others)
    distances, angles = np.linalg.norm(off[:, :3, 3], axis=1), rotation_angle(off)
    return np.asarray(np.logical_and(distances <= most_m, angles <= most_rad))
