"""A baseline that is no SLAM: it returns the poses of the odometry unchanged. Every SLAM has to be better than this."""

from collections.abc import Sequence

import numpy as np

from lexis.errors import ObservationError
from lexis.inputs import is_pose
from lexis.maths.ties import reaches
from lexis.types import Camera, Observation, Pose
from sim.errors import SimError
from sim.harness.estimate import Estimate

SPACING_M = 0.5
"""Path length between keyframes [m]."""


class OdometryOnly:
    """A baseline that reports only the odometry's poses of keyframes, which are `SPACING_M` of path apart.

    Its trajectory error is the error of the odometry, so that it is large wherever the odometry drifts.
    """

    def __init__(self) -> None:
        """Create the adapter; a run begins with `start`."""
        self._begin()

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run. The camera and the names of rooms are ignored."""
        self._begin()

    def _begin(self) -> None:
        self._keyframes: dict[int, Pose] = {}
        self._last: tuple[int, Pose] | None = None
        self._path_m = 0.0

    def process(self, observation: Observation) -> None:
        """Take the next odometry pose. Raises `ObservationError` for frames out of order and poses that are not rigid."""
        if not is_pose(observation.T_O_B):
            raise ObservationError(f"observation {observation.index}: T_O_B is unusable; valid: a finite rigid motion")
        pose = observation.T_O_B.astype(float)  # a copy, because the caller may overwrite the array
        if self._last is not None:
            last_index, last_pose = self._last
            if observation.index <= last_index:
                raise ObservationError(f"observation {observation.index} comes after {last_index}; valid: ascending")
            self._path_m += float(np.linalg.norm(pose[:3, 3] - last_pose[:3, 3]))
        self._last = observation.index, pose
        if not self._keyframes or reaches(self._path_m, SPACING_M):
            self._path_m = 0.0
            self._keyframes[observation.index] = pose

    def finish(self) -> Estimate:
        """Return the poses of all keyframes. Raises `SimError` if no observation was usable."""
        if not self._keyframes:
            raise SimError("OdometryOnly: was given no usable observation; valid: one or more")
        return Estimate(np.array(list(self._keyframes)), T_W_B=np.array(list(self._keyframes.values())))
