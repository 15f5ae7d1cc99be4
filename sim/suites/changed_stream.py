"""`changed`: puts a change between the input and a SLAM, and converts the SLAM's estimate back to the unchanged input."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Int

from lexis.maths.se3 import inverse
from lexis.types import Camera, Observation, Pose
from sim.errors import SimError
from sim.harness.estimate import Estimate, EstimatedLoops
from sim.harness.feature_input import FeatureInput
from sim.harness.returned_estimate import checked_estimate
from sim.harness.slam_under_test import AcceptsFeatures, SlamUnderTest
from sim.suites.stream_changes import StreamChange, copied


class ChangedStream:
    """A SLAM whose input is changed. Its estimate is that of the SLAM, converted to the unchanged observations."""

    def __init__(self, slam: SlamUnderTest, change: StreamChange) -> None:
        self._slam, self._change = slam, change
        self._original_names: list[int] = []
        """For each room name that the SLAM is told, the index of the unchanged room name; -1 for an additional name."""
        self._given: list[int] = []
        """Index of the unchanged observation for each observation that the SLAM got."""
        self._previous: Observation | None = None

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run with the changed camera and the changed room names."""
        self._slam.start(*self._begin(camera, room_names))

    def process(self, observation: Observation) -> None:
        """Give the SLAM the changed observations that take the place of this observation."""
        previous, self._previous = self._previous, copied(observation)
        for given in self._change.observations(observation, previous):
            self._given.append(given.index)
            self._slam.process(replace(given, index=len(self._given) - 1))

    def finish(self) -> Estimate:
        """Return the estimate for the unchanged observations, in the unchanged body frame, with unchanged room names."""
        estimate = checked_estimate(self._slam.finish(), range(len(self._given)), len(self._original_names))
        return _restored(estimate, np.array(self._given), np.array(self._original_names), self._change)

    def _begin(self, camera: Camera, room_names: Sequence[str]) -> tuple[Camera, tuple[str, ...]]:
        """Forget the previous run, and return the camera and the room names with which the SLAM is started."""
        names = self._change.names(room_names)
        self._original_names = [-1 if name is None else room_names.index(name) for name in names.values()]
        self._given, self._previous = [], None
        return self._change.camera(camera), tuple(names)


class ChangedFeatureStream(ChangedStream):
    """A SLAM whose input is changed, for a SLAM that accepts features."""

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        """Begin a run on percepts with the changed camera and the changed room names."""
        if not isinstance(self._slam, AcceptsFeatures):
            raise SimError("SLAM under test: has no method start_on_features(); valid: ChangedStream")
        started = self._begin(camera, room_names)
        renumbered = features.renumbered(lambda index: self._given[index], lambda index: index < len(self._given))
        self._slam.start_on_features(*started, self._change.features(renumbered))


def changed(slam: SlamUnderTest, change: StreamChange) -> ChangedStream:
    """Return the SLAM with a changed input. The result accepts features if the SLAM does."""
    return (ChangedFeatureStream if isinstance(slam, AcceptsFeatures) else ChangedStream)(slam, change)


def _restored(
    estimate: Estimate, given: Int[np.ndarray, "observations"], name_of: Int[np.ndarray, "names"], change: StreamChange
) -> Estimate:
    """Convert an estimate for changed observations to an estimate for the unchanged observations.

    If several frames show one observation, only the last of these frames is kept. Candidates and decisions are left out.
    """
    frames, from_end = np.unique(given[estimate.frames][::-1], return_index=True)
    last = len(estimate.frames) - 1 - from_end
    T_old_new, T_N_B = inverse(change.T_new_old), inverse(change.T_B_N)
    new_row = np.searchsorted(frames, given[estimate.frames])
    similarities = estimate.similarities
    if similarities is not None:
        kept = name_of >= 0
        columns = np.zeros((len(similarities), int(name_of.max()) + 1))
        columns[:, name_of[kept]] = similarities[:, kept]
        similarities = columns[last]
    return replace(
        estimate,
        frames=frames,
        T_W_B=None if estimate.T_W_B is None else T_old_new @ estimate.T_W_B[last] @ T_N_B,
        labels=_renamed(estimate.labels, last, name_of),
        baseline_labels=_renamed(estimate.baseline_labels, last, name_of),
        rooms=None if estimate.rooms is None else estimate.rooms[last],
        floors=None if estimate.floors is None else estimate.floors[last],
        loops=_moved(estimate.loops, new_row, change.T_B_N),
        candidates=None,
        decisions=None,
        similarities=similarities,
    )


def _renamed(
    labels: Int[np.ndarray, "n"] | None, rows: Int[np.ndarray, "m"], name_of: Int[np.ndarray, "names"]
) -> Int[np.ndarray, "m"] | None:
    return None if labels is None else np.where(labels[rows] < 0, -1, name_of[labels[rows]])


def _moved(loops: EstimatedLoops | None, new_row: Int[np.ndarray, "n"], T_B_N: Pose) -> EstimatedLoops | None:
    """Convert estimated loops: their frames to rows of the unchanged observations, their poses to the unchanged body frame.

    A loop between two frames of the same unchanged observation is left out. If the later frame of a loop showed the earlier
    observation, the loop is turned around. Several copies of an observation may close the same loop: the last of these loops
    is kept. None stays None.
    """
    if loops is None:
        return None
    others = new_row[loops.query] != new_row[loops.match]  # two frames for one observation may form a loop
    query, match = new_row[loops.query[others]], new_row[loops.match[others]]
    T_match_query = T_B_N @ loops.T_match_query[others] @ inverse(T_B_N)
    turned = query < match
    T_match_query[turned] = inverse(T_match_query[turned])
    later, earlier = np.maximum(query, match), np.minimum(query, match)
    _, from_end = np.unique(np.stack((later, earlier), axis=1)[::-1], axis=0, return_index=True)
    kept = np.sort(len(later) - 1 - from_end)
    weights = None if loops.weights is None else loops.weights[others][kept]
    return EstimatedLoops(later[kept], earlier[kept], T_match_query[kept], weights)
