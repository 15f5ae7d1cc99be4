"""Rooms and keyframes that fit a question in free words, such as "where can I wash my hands"."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32

from lexis.errors import LexisError
from lexis.map.encoder_check import check_encoder
from lexis.maths.ties import settled
from lexis.perception import TextEncoder
from lexis.query.calibration import Calibration
from lexis.query.questions import Captions, read_question
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
    negated: bool = False
    """Whether the probability is that of the contrary, and the similarity is with what is not wanted."""


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

    Of the readings of a question, the one that a room fits best counts.
    A negated question ("not a kitchen") ranks the other way round: similarities are those with what is not wanted, and a
    probability is that of the contrary.

    Args:
        map: where to search.
        text: in any words that the encoder understands.
        encoder: the one that made the map.
        calibration: of that encoder, for probabilities.

    Raises:
        LexisError: the text is blank or negates a part of itself, the map has no rooms, or the encoder is another than the
            map's.
    """
    question = read_question(text)
    if not map.rooms:
        raise LexisError("the map has no rooms; valid: one with at least one")
    check_encoder(map, encoder)
    readings = np.stack([_embedded(captions, encoder) for captions in question.readings])
    images = np.array([keyframe.embedding for keyframe in map.keyframes])
    answers = [_ranked(map, settled(images.astype(np.float64) @ reading), question.negated) for reading in readings]
    if calibration is None:
        return max(answers, key=lambda answer: answer.rooms[0].similarity)
    likely = [_likely(answer, calibration, reading, encoder) for answer, reading in zip(answers, readings, strict=True)]
    return max(likely, key=lambda answer: answer.rooms[0].probability or 0.0)


def embed_questions(texts: Sequence[str], encoder: TextEncoder) -> Float32[np.ndarray, "texts d"]:
    """Embed every question, of unit norm: the mean over the captions of its first reading.

    Raises LexisError for a question that `read_question` refuses.
    """
    return np.stack([_embedded(read_question(text).readings[0], encoder) for text in texts])


def _embedded(captions: Captions, encoder: TextEncoder) -> Float32[np.ndarray, "d"]:
    mean = encoder.encode_texts(captions).mean(axis=0)
    return np.asarray(mean / np.linalg.norm(mean), np.float32)


def _ranked(map: LexisMap, fits: Float[np.ndarray, "n"], negated: bool) -> Answer:
    """Rooms and keyframes by similarity: the greatest first, or the least where the question is negated."""
    sign = -1.0 if negated else 1.0
    of_rooms = [float(best_views(fits[list(room.keyframes), None])[0]) for room in map.rooms]
    best_keyframes = [room.keyframes[int((sign * fits[list(room.keyframes)]).argmax())] for room in map.rooms]
    rooms = [
        RoomFit(room, fit, None, best, negated) for room, fit, best in zip(map.rooms, of_rooms, best_keyframes, strict=True)
    ]
    return Answer(
        tuple(sorted(rooms, key=lambda fit: (-sign * fit.similarity, fit.room.id))),
        tuple(KeyframeFit(int(i), float(fits[i])) for i in np.argsort(-sign * fits, kind="stable")),
    )


def _likely(answer: Answer, calibration: Calibration, question: Float32[np.ndarray, "d"], encoder: TextEncoder) -> Answer:
    """The answer with probabilities."""
    similarities = np.array([[fit.similarity] for fit in answer.rooms])
    p = calibration.probabilities(similarities, question[None], encoder)[:, 0]
    rooms = (fit._replace(probability=float(1.0 - q if fit.negated else q)) for fit, q in zip(answer.rooms, p, strict=True))
    return replace(answer, rooms=tuple(rooms))


def best_views(similarities: Float[np.ndarray, "n texts"]) -> Float[np.ndarray, "texts"]:
    """How well a room fits every text: the mean over the best of its n views."""
    return np.asarray(np.sort(similarities, axis=0)[-BEST_VIEWS:].mean(axis=0))
