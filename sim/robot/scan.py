"""`RangeScanner`: what stands around the body, and where the ground breaks off or rises too steeply to climb."""

import numpy as np
from jaxtyping import Float64

from sim.render.gl import mujoco
from sim.robot.body import GROUND_GROUP, OUTLINE_GROUP, STEP_M, Body, group_mask

RANGE_M = 3.0
_BEAMS = 72
_HEAD_M = 1.3
"""Height of the sensor above the foot [m]."""
_RINGS_M = 0.1 * np.arange(1, 7)
"""Where level ground would be looked at, around the foot [m]."""
_DEEP_M = 20.0
"""A gaze that meets no ground this far counts as one that ends there [m]."""
_EVERY = 2
"""Of the beams, this one's bearing has gazes too."""
_TREAD_M = 0.18
"""The ground may rise or fall by a step over this length, as the steepest stairs do [m]."""


class RangeScanner:
    """Level beams all around, at the outlines of what stands there (see `outlines`), and gazes at the ground by the feet.

    MuJoCo casts them, from the head of the body.
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        angles = 2.0 * np.pi * np.arange(_BEAMS) / _BEAMS
        self._beams = np.stack([np.cos(angles), np.sin(angles), np.zeros(_BEAMS)], axis=1)
        gazes = self._beams[::_EVERY, None] * _RINGS_M[:, None] - [0.0, 0.0, _HEAD_M]
        self._gazes = gazes / np.linalg.norm(gazes, axis=-1, keepdims=True)

    def scan(self, yaw: float) -> Float64[np.ndarray, "hits 2"]:
        """Where one cannot go, x forward and y to the left of a body that faces `yaw` in W [m]."""
        cos, sin = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])  # of rows, from the body to W
        level = self._cast(self._beams @ turn, OUTLINE_GROUP, RANGE_M)
        ranges = np.concatenate([level, self._edges(turn, level[::_EVERY])])
        bearings = np.concatenate([self._beams, self._beams[::_EVERY]])[:, :2]
        hit = np.isfinite(ranges)
        return np.asarray(bearings[hit] * ranges[hit, None])

    def _edges(self, turn: Float64[np.ndarray, "3 3"], level: Float64[np.ndarray, "gazes"]) -> Float64[np.ndarray, "gazes"]:
        """How far it is to where the ground breaks off or rises too steeply, per bearing; infinite where it does not [m].

        What lies behind the ends of the `level` beams is not seen.
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
        """Ranges from the head; infinite where nothing is hit within `most_m` [m]."""
        n = len(directions)
        geoms, ranges = np.zeros(n, np.int32), np.zeros(n)
        mujoco.mj_multiRay(
            self._body.model, self._body.data, self._body.position + [0.0, 0.0, _HEAD_M], directions.reshape(-1),
            group_mask(group), True, self._body.id, geoms, ranges, None, n, most_m,
        )  # fmt: skip
        ranges[(ranges < 0.0) | (ranges > most_m)] = np.inf
        return ranges
