"""Answers to questions in natural language, such as "where can I wash my hands": rooms and keyframes that fit.

1. Turn the question into captions, the texts that the encoder was trained on (`lexis.questions.captions`). A question may
   have several readings.
2. Embed each reading as the mean of its captions, and compare it with the embeddings of all images of all keyframes.
3. Score each room by the mean similarity of its best views, because most of its views may not show the requested thing.
4. With a calibration, convert the scores to probabilities (`lexis.questions.calibration`).
5. Return the rooms and keyframes for the reading that has the best-fitting room.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32

from lexis.errors import LexisError
from lexis.map.encoder_check import check_embedding_size, check_encoder
from lexis.maths.ties import rounded
from lexis.perception import TextEncoder
from lexis.questions.calibration import Calibration
from lexis.questions.captions import Captions, read_question
from lexis.types import LexisMap, RoomInstance

BEST_VIEWS = 5
"""A room's score is the mean similarity of its images (views) that are most similar to the question, at most this many. Its
other images may not show the requested thing."""
FITS = 0.5
"""Least probability at which a room counts as an answer."""


class RoomFit(NamedTuple):
    """A room and how well it fits the question."""

    room: RoomInstance
    similarity: float
    """Mean cosine similarity between the question and the room's best views (`BEST_VIEWS`)."""
    probability: float | None
    """Probability that the room fits the question; None without a calibration."""
    keyframe: int
    """Id of the room's keyframe that fits best."""
    negated: bool = False
    """Whether the question is negated, as in "not a kitchen". If so, `similarity` is the similarity to the excluded thing
    (the kitchen), and `probability` is the probability that the room does not fit the excluded thing."""


class KeyframeFit(NamedTuple):
    """A keyframe and the cosine similarity between its image and the question."""

    keyframe: int
    similarity: float


@dataclass(frozen=True)
class Answer:
    """The answer to a question: all rooms and keyframes of the map, those that fit best first."""

    rooms: tuple[RoomFit, ...]
    keyframes: tuple[KeyframeFit, ...]

    @property
    def unknown(self) -> bool:
        """Whether even the best room has a probability below `FITS`; always False without a calibration."""
        best = self.rooms[0].probability
        return best is not None and best < FITS


def ask(map: LexisMap, text: str, encoder: TextEncoder, calibration: Calibration | None = None) -> Answer:
    """Rank all rooms and keyframes of the map by how well they fit a question; the map's room names are not used.

    A question may have several readings, such as a thing and the room that it is usually in. The reading with the
    best-fitting room is used. For a negated question ("not a kitchen"), similarities are to the excluded thing, and the
    smallest come first; probabilities are probabilities of not fitting the excluded thing.

    Args:
        map: the map to search.
        text: the question.
        encoder: the encoder that made the map.
        calibration: the encoder's calibration, needed for probabilities.

    Raises:
        LexisError: the text is blank, too long or negates only a part of itself, the map has no rooms, or the map was made
            with another encoder.
    """
    question = read_question(text)
    if not map.rooms:
        raise LexisError("the map has no rooms; valid: one with at least one")
    check_encoder(map, encoder)
    readings = np.stack([_embed(captions, encoder) for captions in question.readings])
    check_embedding_size(map, readings)
    answers = [_rank(map, _fits(map, reading), question.negated) for reading in readings]
    if calibration is None:
        return max(answers, key=lambda answer: answer.rooms[0].similarity)
    likely = [_likely(answer, calibration, reading, encoder) for answer, reading in zip(answers, readings, strict=True)]
    return max(likely, key=lambda answer: answer.rooms[0].probability or 0.0)


def embed_questions(texts: Sequence[str], encoder: TextEncoder) -> Float32[np.ndarray, "texts d"]:
    """Embed every question, taken literally, as the normalised mean of the embeddings of its captions.

    Raises LexisError for a question that `read_question` refuses.
    """
    return np.stack([_embed(read_question(text).readings[0], encoder) for text in texts])


def _embed(captions: Captions, encoder: TextEncoder) -> Float32[np.ndarray, "d"]:
    mean = encoder.encode_texts(captions).mean(axis=0)
    return np.asarray(mean / np.linalg.norm(mean), np.float32)


def _fits(map: LexisMap, reading: Float32[np.ndarray, "d"]) -> Float[np.ndarray, "n"]:
    """Return the similarity of every keyframe with a reading; with several cameras, that of the most similar image."""
    images = np.array([keyframe.embeddings for keyframe in map.keyframes])
    keyframes, cameras, size = images.shape
    fits = rounded(images.reshape(keyframes * cameras, size).astype(np.float64) @ reading)
    return np.asarray(fits.reshape(keyframes, cameras).max(axis=1))


def _rank(map: LexisMap, fits: Float[np.ndarray, "n"], negated: bool) -> Answer:
    """Rank rooms and keyframes by similarity: the largest first, or the smallest first if the question is negated."""
    sign = -1.0 if negated else 1.0
    of_rooms = [float(best_views_mean(fits[list(room.keyframes), None])[0]) for room in map.rooms]
    best_keyframes = [room.keyframes[int((sign * fits[list(room.keyframes)]).argmax())] for room in map.rooms]
    rooms = [
        RoomFit(room, fit, None, best, negated) for room, fit, best in zip(map.rooms, of_rooms, best_keyframes, strict=True)
    ]
    return Answer(
        tuple(sorted(rooms, key=lambda fit: (-sign * fit.similarity, fit.room.id))),
        tuple(KeyframeFit(int(i), float(fits[i])) for i in np.argsort(-sign * fits, kind="stable")),
    )


def _likely(answer: Answer, calibration: Calibration, question: Float32[np.ndarray, "d"], encoder: TextEncoder) -> Answer:
    """Add probabilities to an answer."""
    similarities = np.array([[fit.similarity] for fit in answer.rooms])
    p = calibration.probabilities(similarities, question[None], encoder)[:, 0]
    rooms = (fit._replace(probability=float(1.0 - q if fit.negated else q)) for fit, q in zip(answer.rooms, p, strict=True))
    return replace(answer, rooms=tuple(rooms))


def best_views_mean(similarities: Float[np.ndarray, "n texts"]) -> Float[np.ndarray, "texts"]:
    """Return the score of a room for every text.

    The score is the mean similarity of the room's best views: the `BEST_VIEWS` most similar of its n views.
    """
    return np.asarray(np.sort(similarities, axis=0)[-BEST_VIEWS:].mean(axis=0))
