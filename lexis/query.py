"""Rooms that fit a question in free words, such as "where can I wash my hands"."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float32

from lexis.errors import MapError
from lexis.types import LexisMap, RoomInstance

BEST_VIEWS = 5
"""Images that speak for a room: most of its views may show nothing of what is asked for."""


class Answer(NamedTuple):
    """A room, and how well it fits."""

    room: RoomInstance
    similarity: float
    """Mean cosine similarity of the text with the room's best views."""
    keyframe: int
    """Where it fits best."""


def rank_rooms(map: LexisMap, text: Float32[np.ndarray, "d"]) -> tuple[Answer, ...]:
    """All rooms, the best fit first.

    Args:
        map: where to search.
        text: the question's embedding, of unit norm, by the encoder that made the map.

    Raises:
        MapError: the map was made with embeddings of another size.
    """
    embeddings = np.array([keyframe.embedding for keyframe in map.keyframes])
    if embeddings.shape[1:] != text.shape:
        raise MapError(
            f"the map's embeddings have {embeddings.shape[-1]} dimensions, the encoder's {len(text)}; "
            "valid: the encoder that the map was made with"
        )
    fits = embeddings @ text
    answers = [_answer(room, fits[list(room.keyframes)]) for room in map.rooms]
    return tuple(sorted(answers, key=lambda answer: (-answer.similarity, answer.room.id)))


def _answer(room: RoomInstance, fits: Float32[np.ndarray, "k"]) -> Answer:
    best = np.sort(fits)[::-1][:BEST_VIEWS]
    return Answer(room, float(best.mean()), room.keyframes[int(fits.argmax())])
