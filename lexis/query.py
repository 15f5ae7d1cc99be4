"""Rooms and keyframes that fit a question in free words, such as "where can I wash my hands"."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from lexis.calibration import Calibration
from lexis.errors import LexisError
from lexis.map_encoder import check_encoder
from lexis.perception import TextEncoder
from lexis.types import LexisMap, RoomInstance

BEST_VIEWS = 5
"""Images that speak for a room: most of its views may show nothing of what is asked for."""
FITS = 0.5
"""Probability from which on a room is an answer."""


class RoomFit(NamedTuple):
    """A room, and how well it fits."""

    room: RoomInstance
    similarity: float
    """Mean cosine similarity of the text with the room's best views."""
    probability: float | None
    """That the room is, or shows, what was asked for; None without a calibration."""
    keyframe: int
    """Where it fits best."""


class KeyframeFit(NamedTuple):
    """A keyframe, and the cosine similarity of its image with the text."""

    keyframe: int
    similarity: float


@dataclass(frozen=True)
class Answer:
    """Everything in the map by how well it fits, the best first."""

    rooms: tuple[RoomFit, ...]
    keyframes: tuple[KeyframeFit, ...]

    @property
    def unknown(self) -> bool:
        """Whether nothing in the map fits; never without a calibration."""
        best = self.rooms[0].probability
        return best is not None and best < FITS


def ask(map: LexisMap, text: str, encoder: TextEncoder, calibration: Calibration | None = None) -> Answer:
    """Rank all rooms and keyframes of the map; its room names play no part.

    Args:
        map: where to search.
        text: in any words that the encoder understands.
        encoder: the one that made the map.
        calibration: of that encoder, for probabilities.

    Raises:
        LexisError: the text is blank, the map has no rooms, or the encoder is another than the map's.
    """
    if not text.strip():
        raise LexisError("the question is blank; valid: some words")
    if not map.rooms:
        raise LexisError("the map has no rooms; valid: one with at least one")
    check_encoder(map, encoder)
    fits = np.array([keyframe.embedding for keyframe in map.keyframes]) @ encoder.encode_texts([text])[0]
    of_rooms = np.array([best_views(fits[list(room.keyframes), None])[0] for room in map.rooms])
    likely = None if calibration is None else calibration.probabilities(of_rooms[:, None], [text], encoder)
    rooms = [
        RoomFit(
            room,
            float(of_rooms[i]),
            None if likely is None else float(likely[i, 0]),
            room.keyframes[int(fits[list(room.keyframes)].argmax())],
        )
        for i, room in enumerate(map.rooms)
    ]
    order = np.argsort(-fits, kind="stable")
    return Answer(
        tuple(sorted(rooms, key=lambda fit: (-fit.similarity, fit.room.id))),
        tuple(KeyframeFit(int(i), float(fits[i])) for i in order),
    )


def best_views(similarities: Float[np.ndarray, "n texts"]) -> Float[np.ndarray, "texts"]:
    """How well a room fits every text: the mean over the best of its n views."""
    return np.asarray(np.sort(similarities, axis=0)[-BEST_VIEWS:].mean(axis=0))
