"""Keyframe selection: equally spaced keyframes, and support frames between them (paper, Sec. III-A).

Keyframes become nodes of the pose graph. Support frames do not: they are the additional views from which the landmarks of
the keyframes are triangulated.
"""

from dataclasses import dataclass

import numpy as np

from lexis.config import KeyframeConfig
from lexis.inputs import MAX_VARIANCE, usable_covariances
from lexis.maths.se3 import between, compose_covariance, rotation_angle
from lexis.maths.ties import reaches
from lexis.types import Covariance, Observation, Pose

MAX_STEP_M = 3.0
"""Largest distance between consecutive keyframes of a walk [m]. A larger distance is a gap in the recording."""


@dataclass(frozen=True, eq=False)
class Frame:
    """An observation that was selected as a keyframe or as a support frame."""

    observation: Observation
    is_keyframe: bool
    """Whether the observation becomes a keyframe; False: a support frame, which only serves to triangulate landmarks."""
    step_covariance: Covariance
    """Covariance of the odometry's motion estimate since the previous keyframe [rad², m²]. Where the sum of the increments
    has an entry beyond `MAX_VARIANCE`, or too large rounding errors, nothing is known: `MAX_VARIANCE` times the identity."""


class KeyframeSelector:
    """Selects a keyframe every `spacing_m` of odometry path, and support frames in between, `support_spacing_m` apart.

    Support frames only serve to triangulate the landmarks of keyframes.
    """

    def __init__(self, config: KeyframeConfig) -> None:
        """Create a selector for a new sequence of observations."""
        self._config = config
        self._last: Pose | None = None
        self._path_since_keyframe = 0.0
        self._path_since_frame = 0.0
        self._turn_since_keyframe = 0.0
        self._covariance: Covariance = np.zeros((6, 6))

    def select(self, observation: Observation) -> Frame | None:
        """Return the observation as a frame, or None if it is too close to the previous frame.

        The first observation is always a keyframe.
        """
        first = self._last is None
        if self._last is not None:
            self._advance(between(self._last, observation.T_O_B), observation.increment_covariance)
        self._last = observation.T_O_B
        if first or self._keyframe_due():
            frame = Frame(observation, True, _usable(self._covariance))
            self._path_since_keyframe = self._path_since_frame = self._turn_since_keyframe = 0.0
            self._covariance = np.zeros((6, 6))
            return frame
        if reaches(self._path_since_frame, self._config.support_spacing_m):
            self._path_since_frame = 0.0
            return Frame(observation, False, _usable(self._covariance))
        return None

    def _advance(self, increment: Pose, covariance: Covariance) -> None:
        distance = float(np.linalg.norm(increment[:3, 3]))
        self._path_since_keyframe += distance
        self._path_since_frame += distance
        self._turn_since_keyframe += float(rotation_angle(increment))
        self._covariance = compose_covariance(self._covariance, increment, covariance)

    def _keyframe_due(self) -> bool:
        rotation_rad = self._config.rotation_rad
        turned = rotation_rad is not None and bool(reaches(self._turn_since_keyframe, rotation_rad))
        return turned or bool(reaches(self._path_since_keyframe, self._config.spacing_m))


def _usable(covariance: Covariance) -> Covariance:
    return covariance if usable_covariances(covariance) else MAX_VARIANCE * np.eye(6)
