"""A sliding window of frames that delays each keyframe until the frames after it have arrived.

The landmarks of a keyframe are triangulated from the frames before and after it, for more views and a longer baseline. At
the end of the sequence, only the frames before the keyframe are available.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

from lexis.config import Config
from lexis.keyframes import Frame
from lexis.landmarks import View, triangulate
from lexis.types import Camera, Features, Keyframe, Landmarks, Observation, Percept


@dataclass(frozen=True, eq=False)
class _Entry:
    frame: Frame
    features: Features
    embedding: Float32[np.ndarray, "d"] | None
    """CLIP embedding of the image; None for a support frame."""

    @property
    def view(self) -> View:
        return View(self.frame.observation.T_O_B, self.features)


class KeyframeWindow:
    """Takes frames in order and returns keyframes with landmarks in the same order."""

    def __init__(self, camera: Camera, config: Config, first_id: int = 0, session: int = 0) -> None:
        """Create an empty window for a session whose first keyframe gets the id `first_id`."""
        self._camera = camera
        self._config = config
        self._entries: deque[_Entry] = deque(maxlen=2 * config.keyframes.supports + 1)
        self._count, self.session = first_id, session

    def add(self, frame: Frame, features: Features, embedding: Float32[np.ndarray, "d"] | None) -> list[Keyframe]:
        """Add a frame. If a keyframe was waiting only for this frame, return it in a list; otherwise return an empty list.

        `embedding` is None for support frames.
        """
        self._entries.append(_Entry(frame, features, embedding))
        centre = len(self._entries) - 1 - self._config.keyframes.supports
        return self._complete(centre) if centre >= 0 else []

    def flush(self) -> list[Keyframe]:
        """Empty the window at the end of the sequence and return the keyframes that were still waiting for frames."""
        first = max(len(self._entries) - self._config.keyframes.supports, 0)
        ready = [keyframe for centre in range(first, len(self._entries)) for keyframe in self._complete(centre)]
        self._entries.clear()
        return ready

    def _complete(self, centre: int) -> list[Keyframe]:
        entry = self._entries[centre]
        if entry.embedding is None:
            return []
        supports = self._config.keyframes.supports
        nearby = range(max(centre - supports, 0), min(centre + supports + 1, len(self._entries)))
        views = [self._entries[index].view for index in nearby if index != centre]
        observation = entry.frame.observation
        keyframe = Keyframe(
            id=self._count,
            observation_index=observation.index,
            stamp=observation.stamp,
            T_O_B=observation.T_O_B,
            step_covariance=entry.frame.step_covariance,
            embedding=entry.embedding,
            features=entry.features,
            landmarks=_with_points(triangulate(entry.view, views, self._camera, self._config.landmarks), observation),
            session=self.session,
        )
        self._count += 1
        return [keyframe]


def _with_points(triangulated: Landmarks, observation: Observation) -> Landmarks:
    """Return the landmarks, followed by the points of the observation's percept as landmarks without key points."""
    seen = observation.image
    if not isinstance(seen, Percept) or not len(seen.points):
        return triangulated
    without = np.full(len(seen.points), -1)
    return Landmarks(np.concatenate([triangulated.points, seen.points]), np.concatenate([triangulated.feature_ids, without]))
