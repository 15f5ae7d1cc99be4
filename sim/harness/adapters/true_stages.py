"""`TrueStages`: stages of LEXIS that know the truth, to find the stage that is to blame for a failure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.config import PlaceRecognitionConfig, VerificationConfig
from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD
from lexis.evaluation.relative import separation
from lexis.graph.pose_estimate import PoseEstimate
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.se3 import between
from lexis.place_recognition import old_keyframes
from lexis.room_labels import Labels
from lexis.types import Camera, Keyframe, LoopEdge, Poses, RoomInstance
from lexis.verification import Verification
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.render.rig import build_rig
from sim.truth import camera_positions
from worlds.truth import room_at

_INLIERS = 1000
"""Number of inliers that is stated for true loop edges. It is so large that LEXIS accepts the edges."""


@dataclass(frozen=True, eq=False)
class TrueStages:
    """The true pose and label of every frame of a tour, in the form of three stages of `lexis.slam.Slam`."""

    T_W_B: Poses
    labels: Int[np.ndarray, "n"]
    """True label of every frame, as an index into the room names that the SLAM is told."""

    @staticmethod
    def of(scenario: Scenario) -> "TrueStages":
        """Collect the truth along the tour of a scenario. Raises the errors of `sim.harness.walk.walk`."""
        walked = walk(scenario)
        names, rooms = walked.house.spec.room_labels, walked.house.rooms
        inside = room_at(walked.house, camera_positions(walked.tour.T_W_B, build_rig(scenario.rig).front))
        return TrueStages(walked.tour.T_W_B, np.array([names.index(rooms[room].label) for room in inside], int))

    def propose(
        self, query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig
    ) -> tuple[int, ...]:
        """Propose keyframes that are old enough and were truly taken at the place of the query, the closest first."""
        old = old_keyframes(graph, query, config)
        distances_m, there = self._compared(query, [graph.keyframes[k] for k in old.tolist()])
        closest = old[there][np.argsort(distances_m[there], kind="stable")]
        return tuple(closest[: config.candidates].tolist())

    def verify(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseEstimate, camera: Camera, config: VerificationConfig
    ) -> Verification:
        """Confirm the candidates that were truly taken at the place of the query, each with its true relative pose."""
        sigmas = np.repeat([config.rotation_sigma_rad, config.translation_sigma_m], 3)
        matches = [graph.keyframes[k] for k in candidates]
        _, there = self._compared(query, matches)
        relative = between(self.T_W_B[_frames(matches)], self.T_W_B[query.observation_index])
        edges = [
            LoopEdge(query.id, match, pose, np.diag(sigmas**2), _INLIERS)
            for match, pose, right in zip(candidates, relative, there, strict=True)
            if right
        ]
        return Verification(tuple(edges[: config.max_edges]))

    def label(self, keyframes: Sequence[Keyframe]) -> Labels:
        """Return the true label of every keyframe."""
        return np.asarray(self.labels[_frames(keyframes)])

    def _compared(
        self, query: Keyframe, others: Sequence[Keyframe]
    ) -> tuple[Float64[np.ndarray, "n"], Bool[np.ndarray, "n"]]:
        """Return the true distance of each other keyframe from the query [m], and whether it shows the query's place.

        A keyframe shows the place of the query if it was truly taken near the query and in nearly the same direction.
        """
        there = self.T_W_B[_frames(others)]
        here = np.broadcast_to(self.T_W_B[query.observation_index], there.shape)
        distances_m, angles_rad = separation(here, there)
        return distances_m, (distances_m <= PLACE_M) & (angles_rad <= PLACE_RAD)


def _frames(keyframes: Sequence[Keyframe]) -> Int[np.ndarray, "n"]:
    return np.array([keyframe.observation_index for keyframe in keyframes], int)
