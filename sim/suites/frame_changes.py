"""Changes of the coordinate frames: another origin of the odometry, and other axes of the body.

The SLAM gets the same walk in other coordinates, so it has to return the same estimate.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int

from lexis.config import VerificationConfig
from lexis.graph.pose_estimate import PoseEstimate
from lexis.maths.se3 import adjoint, inverse, transform, upright
from lexis.types import Camera, Covariance, Keyframe, LoopEdge, Observation, Percept, Pose, Poses
from lexis.verification import Verification, Verifier
from sim.harness.feature_input import FeatureInput
from sim.suites.stream_changes import NoChange


@dataclass(frozen=True)
class OtherFrames(NoChange):
    """Base class of the changes of frames: observations, camera and loops are converted by `T_new_old` and `T_B_N`."""

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation in the new frames."""
        T_O_B = self.T_new_old @ observation.T_O_B @ self.T_B_N
        covariance = _in_frame(self.T_B_N, observation.increment_covariance)
        images = [
            replace(image, points=transform(inverse(self.T_B_N), image.points)) if isinstance(image, Percept) else image
            for image in observation.images
        ]
        yield replace(observation, T_O_B=T_O_B, increment_covariance=covariance).with_images(images)

    def camera(self, camera: Camera) -> Camera:
        """Return the camera, and the others of its rig, with their poses in the new body frame."""
        return replace(camera, T_B_C=inverse(self.T_B_N) @ camera.T_B_C, others=tuple(map(self.camera, camera.others)))

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return the input with a verifier that measures loops between the new body frames."""
        return replace(features, verifier=_BetweenOtherBodies(features.verifier, self))


@dataclass(frozen=True)
class MovedOrigin(OtherFrames):
    """The odometry frame lies elsewhere and has another heading: the house is translated and rotated, but stays upright."""

    shift_m: tuple[float, float, float] = (30.0, -20.0, 8.0)
    yaw_rad: float = 2.0

    @property
    def T_new_old(self) -> Pose:
        """Transform of coordinates from the old odometry frame to the new odometry frame."""
        return upright(self.yaw_rad, self.shift_m)


@dataclass(frozen=True)
class TurnedBody(OtherFrames):
    """The body frame has other axes: x up, y left and z backwards, as in data sets whose body frame is that of the IMU."""

    @property
    def T_B_N(self) -> Pose:
        """Pose of the new body frame in the old one, a permutation of axes."""
        return np.array([[0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class _BetweenOtherBodies:
    """A loop verifier for a SLAM that works in other frames. It calls the verifier of the run."""

    verifier: Verifier
    frames: OtherFrames

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseEstimate, camera: Camera, config: VerificationConfig
    ) -> Verification:
        """Return the loops of the run's verifier, converted to the frames of the SLAM."""
        verified = self.verifier(query, candidates, _InOriginalFrames(graph, self.frames), camera, config)
        edges, far = (tuple(map(self._converted, loops)) for loops in (verified.edges, verified.far))
        return replace(verified, edges=edges, far=far)

    def _converted(self, loop: LoopEdge) -> LoopEdge:
        """Return a loop between the new body frames."""
        T_B_N = self.frames.T_B_N
        T_match_query = inverse(T_B_N) @ loop.T_match_query @ T_B_N
        return replace(loop, T_match_query=T_match_query, covariance=_in_frame(T_B_N, loop.covariance))


class _InOriginalFrames:
    """The pose estimate of a SLAM that works in other frames, converted to the frames of the run.

    The keyframes keep their odometry poses in the other frames.
    """

    def __init__(self, graph: PoseEstimate, frames: OtherFrames) -> None:
        self._graph = graph
        self._left, self._right = inverse(frames.T_new_old), inverse(frames.T_B_N)

    @property
    def T_W_B(self) -> Poses:
        """The current estimate, in the frames of the run."""
        return np.asarray(self._left @ self._graph.T_W_B @ self._right)

    @property
    def keyframes(self) -> Sequence[Keyframe]:
        """The keyframes of the SLAM."""
        return self._graph.keyframes

    @property
    def sessions(self) -> Int[np.ndarray, "n"]:
        """The session of every keyframe."""
        return self._graph.sessions

    @property
    def is_split(self) -> bool:
        """Whether the pose graph of the SLAM has several components."""
        return self._graph.is_split

    def path_between(self, first: int, second: int) -> float:
        """Return the length of the odometry path between two keyframes [m]."""
        return self._graph.path_between(first, second)


def _in_frame(T_B_N: Pose, covariance: Covariance) -> Covariance:
    """Convert the covariance of a motion, perturbed on the right, from body frame B to body frame N."""
    Ad = adjoint(inverse(T_B_N))
    return np.asarray(Ad @ covariance @ Ad.T)
