"""`FalseLoops`: loop closures that are confirmed although they are wrong."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lexis.config import VerificationConfig
from lexis.graph.pose_estimate import PoseEstimate
from lexis.maths.se3 import between
from lexis.types import Camera, Keyframe, LoopEdge
from lexis.verification import Verification, Verifier
from sim.harness.feature_input import FeatureInput
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import AcceptsFeatures
from sim.suites.stream_changes import NoChange

_SURE = np.repeat([0.01, 0.04], 3) ** 2
"""Variances that a false loop states, as small as those of a true loop: rotation, then translation [rad², m²]."""
_INLIERS = 40
"""Number of inliers that a false loop states."""


@dataclass(frozen=True)
class FalseLoops(NoChange):
    """Loop verification confirms some loops with a wrong relative pose, as happens where two places look alike.

    SLAM systems that verify loops by their own method are not affected.
    """

    share: float = 0.3
    """Share of the keyframes with loop candidates that get a false loop."""
    error_m: float = 1.0
    """Distance by which the relative pose of a false loop is wrong [m].

    For a SLAM that asks `FeatureInput.verify`, the verifier knows no estimated poses. A false loop then says that the camera
    was this far from its earlier pose, with the same orientation.
    """
    seed: int = 0

    def features(self, features: FeatureInput) -> FeatureInput:
        """Return the input with a verifier that also confirms false loops."""
        return replace(features, verifier=_Mistaken(features.verifier, self))

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Return whether the SLAM may use the verifier of the feature sensor."""
        return scenario.fidelity == "features" and isinstance(slam, AcceptsFeatures)


@dataclass(frozen=True, eq=False)
class _Mistaken:
    """A loop verifier that adds false loops to those of another one; they replace true loops between the same frames."""

    verifier: Verifier
    mistakes: FalseLoops

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseEstimate, camera: Camera, config: VerificationConfig
    ) -> Verification:
        """Return the confirmed loops and, for some queries, a false one as well."""
        verified = self.verifier(query, candidates, graph, camera, config)
        rng = np.random.default_rng((self.mistakes.seed, query.id))
        if not candidates or rng.random() >= self.mistakes.share:
            return verified
        match = int(rng.choice(list(candidates)))
        wrong = between(graph.T_W_B[match], graph.T_W_B[query.id])
        angle = rng.uniform(0.0, 2.0 * np.pi)
        wrong[:2, 3] += self.mistakes.error_m * np.array([np.cos(angle), np.sin(angle)])
        mistake = LoopEdge(query.id, match, wrong, np.diag(_SURE), _INLIERS)
        # The false loop takes the place of a true one: an estimate may hold each pair of frames once only.
        kept = tuple(edge for edge in verified.edges if edge.match != match)
        return replace(verified, edges=(*kept, mistake))
