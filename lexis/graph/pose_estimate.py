"""`PoseEstimate`: the keyframes and their estimated poses, which is all that a loop verifier reads of the pose graph."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Int

from lexis.types import Keyframe, Poses


@runtime_checkable
class PoseEstimate(Protocol):
    """Interface of a pose graph for reading: `lexis.graph.pose_graph.PoseGraph`, or another view of its poses."""

    @property
    def keyframes(self) -> Sequence[Keyframe]:
        """All keyframes, in the order of their ids."""

    @property
    def T_W_B(self) -> Poses:
        """The current pose estimate of every keyframe."""

    @property
    def sessions(self) -> Int[np.ndarray, "n"]:
        """The session of every keyframe."""

    @property
    def is_split(self) -> bool:
        """Whether there are several components, so that poses of different components cannot be compared."""

    def path_between(self, first: int, second: int) -> float:
        """Return the length of the odometry path between two keyframes; see `PoseGraph.path_between` [m]."""
