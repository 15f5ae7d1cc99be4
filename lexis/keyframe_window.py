"""A sliding window of frames that delays each keyframe until the frames after it have arrived.

The landmarks of a keyframe are triangulated from the frames before and after it, for more views and a longer baseline. At
the end of the sequence, fewer frames after the keyframe are available, or none. Each camera of a rig has landmarks of its
own, triangulated from its own images.
"""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

from lexis.config import Config
from lexis.keyframes import Frame
from lexis.landmarks import View, triangulate
from lexis.types import Camera, CameraView, Features, Image, Keyframe, Landmarks, Percept


@dataclass(frozen=True, eq=False)
class _Entry:
    frame: Frame
    features: tuple[Features, ...]
    """Features of the image of every camera."""
    embeddings: tuple[Float32[np.ndarray, "d"], ...] | None
    """CLIP embedding of the image of every camera; None for a support frame."""

    def view(self, camera: int) -> View:
        return View(self.frame.observation.T_O_B, self.features[camera])


class KeyframeWindow:
    """Takes frames in order and returns keyframes with landmarks in the same order."""

    def __init__(self, camera: Camera, config: Config, first_id: int = 0, session: int = 0) -> None:
        """Create an empty window for a session whose first keyframe gets the id `first_id`."""
        self._camera = camera
        self._config = config
        self._entries: deque[_Entry] = deque(maxlen=2 * config.keyframes.supports + 1)
        self._count, self.session = first_id, session

    @property
    def is_empty(self) -> bool:
        """Whether no frame has been added since the beginning or since `flush`."""
        return not self._entries

    def add(
        self, frame: Frame, features: Iterable[Features], embeddings: Iterable[Float32[np.ndarray, "d"]] | None
    ) -> list[Keyframe]:
        """Add a frame. If a keyframe was waiting only for this frame, return it in a list; otherwise return an empty list.

        `features` and `embeddings` belong to the images of all cameras. `embeddings` is None for support frames.
        """
        self._entries.append(_Entry(frame, tuple(features), None if embeddings is None else tuple(embeddings)))
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
        if entry.embeddings is None:
            return []
        first, *others = (
            CameraView(embedding, entry.features[camera], self._landmarks(centre, camera))
            for camera, embedding in enumerate(entry.embeddings)
        )
        observation = entry.frame.observation
        keyframe = Keyframe(
            id=self._count,
            observation_index=observation.index,
            stamp=observation.stamp,
            T_O_B=observation.T_O_B,
            step_covariance=entry.frame.step_covariance,
            embedding=first.embedding,
            features=first.features,
            landmarks=first.landmarks,
            session=self.session,
            others=tuple(others),
        )
        self._count += 1
        return [keyframe]

    def _landmarks(self, centre: int, camera: int) -> Landmarks:
        """Triangulate the landmarks that a camera of the rig sees at the frame `centre`, from the frames around it."""
        supports, entry = self._config.keyframes.supports, self._entries[centre]
        nearby = range(max(centre - supports, 0), min(centre + supports + 1, len(self._entries)))
        views = [self._entries[index].view(camera) for index in nearby if index != centre]
        triangulated = triangulate(entry.view(camera), views, self._camera.rig[camera], self._config.landmarks)
        return _with_points(triangulated, entry.frame.observation.images[camera])


def _with_points(triangulated: Landmarks, seen: Image | Percept) -> Landmarks:
    """Return the landmarks, followed by the points of a percept as landmarks without key points."""
    if not isinstance(seen, Percept) or not len(seen.points):
        return triangulated
    without = np.full(len(seen.points), -1)
    return Landmarks(np.concatenate([triangulated.points, seen.points]), np.concatenate([triangulated.feature_ids, without]))
