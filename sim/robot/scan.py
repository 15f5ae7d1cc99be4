"""`RangeScanner`: finds obstacles around the robot, and places where the ground drops or rises too steeply to climb."""

import numpy as np
from jaxtyping import Float64

from sim.render.gl import mujoco
from sim.robot.body import GROUND_GROUP, OUTLINE_GROUP, STEP_M, Body, group_mask

RANGE_M = 3.0
_BEAMS = 72
"""Number of level beams around the body."""
_HEAD_M = 1.3
"""Height of the sensor above the foot [m]."""
_RINGS_M = 0.1 * np.arange(1, 7)
"""Distances from the robot's foot at which downward rays would hit level ground [m]."""
_DEEP_M = 20.0
"""Largest length of a downward ray; a ray that hits no ground counts as ending there [m]."""
_EVERY = 2
"""Downward rays are cast at the bearing of every second level beam."""
_TREAD_M = 0.18
"""Horizontal distance over which the height may change by `STEP_M` [m]: the depth of a tread of the steepest stairs."""


class RangeScanner:
    """Casts level beams in all directions at the outlines of obstacles, and downward rays at the ground nearby.

    The module `outlines` adds the outlines to the model. MuJoCo casts the rays, from 1.3 m above the ground.
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        angles = 2.0 * np.pi * np.arange(_BEAMS) / _BEAMS
        self._beams = np.stack([np.cos(angles), np.sin(angles), np.zeros(_BEAMS)], axis=1)
        gazes = self._beams[::_EVERY, None] * _RINGS_M[:, None] - [0.0, 0.0, _HEAD_M]
        self._gazes = gazes / np.linalg.norm(gazes, axis=-1, keepdims=True)

    def scan(self, yaw: float) -> Float64[np.ndarray, "hits 2"]:
        """Return the points that the robot, facing `yaw` in W [rad], cannot pass: obstacles, drops and high steps.

        The points are in the robot's frame: x forward, y left [m].
        """
        cos, sin = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])  # rotates row vectors from the body to W
        level = self._cast(self._beams @ turn, OUTLINE_GROUP, RANGE_M)
        ranges = np.concatenate([level, self._edges(turn, level[::_EVERY])])
        bearings = np.concatenate([self._beams, self._beams[::_EVERY]])[:, :2]
        hit = np.isfinite(ranges)
        return np.asarray(bearings[hit] * ranges[hit, None])

    def _edges(self, turn: Float64[np.ndarray, "3 3"], level: Float64[np.ndarray, "gazes"]) -> Float64[np.ndarray, "gazes"]:
        """Return, per bearing, the distance at which the ground drops or rises too steeply [m]; infinite if it does not.

        Ground that is farther away than the end of the `level` beam at the same bearing is occluded, and ignored.
        """
        lengths = self._cast((self._gazes @ turn).reshape(-1, 3), GROUND_GROUP, _DEEP_M).reshape(len(self._gazes), -1)
        lengths = np.minimum(lengths, _DEEP_M)
        far = np.linalg.norm(self._gazes[..., :2], axis=-1) * lengths
        high = _HEAD_M + self._gazes[..., 2] * lengths
        climb = np.abs(np.diff(high, axis=1, prepend=0.0))
        breaks = climb > STEP_M * np.maximum(1.0, np.diff(far, axis=1, prepend=0.0) / _TREAD_M)
        seen = far < level[:, None]
        first = np.where((breaks & seen).any(axis=1), (breaks & seen).argmax(axis=1), -1)
        return np.where(first < 0, np.inf, np.minimum(_RINGS_M, far)[np.arange(len(first)), first])

    def _cast(self, directions: Float64[np.ndarray, "n 3"], group: int, most_m: float) -> Float64[np.ndarray, "n"]:
        """Return the ranges of rays from the sensor [m]; infinite where nothing of `group` is hit within `most_m` [m]."""
        n = len(directions)
        geoms, ranges = np.zeros(n, np.int32), np.zeros(n)
        mujoco.mj_multiRay(
            self._body.model, self._body.data, self._body.position + [0.0, 0.0, _HEAD_M], directions.reshape(-1),
            group_mask(group), True, self._body.id, geoms, ranges, None, n, most_m,
        )  # fmt: skip
        ranges[(ranges < 0.0) | (ranges > most_m)] = np.inf
        return ranges
