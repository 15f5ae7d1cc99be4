"""Draws random questions about the rooms of a house, with the truth for each room. Half of the questions have no answer."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int, UInt8

from lexis.perception import TextEncoder
from lexis.questions.answers import best_views_mean, embed_questions
from sim.errors import SimError
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.training.frames import THINGS, frames_at
from sim.training.houses import HouseDraw
from sim.training.phrases import (
    HELD_OUT_ACTIVITIES,
    HELD_OUT_NAMES,
    HELD_OUT_OBJECTS,
    OBJECT_NAMES,
    PLACE_FRAMES,
    ROOM_ACTIVITIES,
    ROOM_NAMES,
    TEMPLATES,
    THING_FRAMES,
    Table,
    framed,
)
from sim.training.viewpoints import LEXIS_VIEWS, evenly_along
from worlds.errors import WorldsError
from worlds.labels import ROOM_LABELS
from worlds.truth import room_at

NAME, ACTIVITY, THING = TOPICS = ("name", "activity", "thing")
YES, NO, DOUBTFUL = 1, 0, -1
"""Whether a room is a right answer to a question. For a question about a thing, a room is doubtful if its images show the
thing, but only as a small share of each image."""

_SPACING_M, _MOST = 1.0, 150
_SEEN = 0.01
"""A room is a right answer about a thing if the thing fills at least this share of some image of the room."""
_ASKED = 12
"""Number of questions per topic with an answer in the house, and also number of questions per topic without an answer."""


@dataclass(frozen=True, eq=False)
class RoomViews:
    """Images of the rooms of a house along a walk, with ground truth."""

    images: UInt8[np.ndarray, "n h w 3"]
    room: Int[np.ndarray, "n"]
    """Number of the room of each image. Rooms are numbered from 0 without gaps."""
    label: Int[np.ndarray, "n"]
    """Label of the room of each image, as an index into `ROOM_LABELS`."""
    shares: Float32[np.ndarray, "n things"]
    """Share of each image that shows each of `THINGS`."""

    @property
    def labels(self) -> Int[np.ndarray, "rooms"]:
        """Label of each room, as an index into `ROOM_LABELS`."""
        return np.asarray(self.label[np.unique(self.room, return_index=True)[1]])

    @property
    def shown(self) -> Float32[np.ndarray, "rooms things"]:
        """For each room and each of `THINGS`, the largest share that the thing fills of an image of the room."""
        return np.array([self.shares[self.room == room].max(axis=0) for room in range(len(self.labels))])


@dataclass(frozen=True, eq=False)
class QuestionBatch:
    """Questions with their embeddings, their similarities to every room, and the truth."""

    texts: tuple[str, ...]
    topics: tuple[str, ...]
    embeddings: Float32[np.ndarray, "texts d"]
    similarities: Float64[np.ndarray, "rooms texts"]
    truth: Int[np.ndarray, "rooms texts"]
    """Whether each room is a right answer to each question: `YES`, `NO` or `DOUBTFUL`."""


def room_views(draw: HouseDraw) -> RoomViews | None:
    """Walk through a house as `lexis-sim run` does, and render images; None if the house or the walk is impossible.

    Raises `GraphicsError` if nothing can be rendered.
    """
    try:
        walked = walk(Scenario(preset=draw.preset, seed=draw.seed))
    except (SimError, WorldsError):
        return None
    T_W_B = walked.tour.T_W_B[evenly_along(walked.tour.T_W_B[:, :3, 3], _SPACING_M, _MOST)]
    room = np.unique(room_at(walked.house, T_W_B[:, :3, 3]), return_inverse=True)[1]
    frames = frames_at(walked.house, T_W_B, LEXIS_VIEWS)
    return RoomViews(frames.images, room, frames.rooms, frames.shares)


def embedded(views: RoomViews, encoder: TextEncoder) -> Float32[np.ndarray, "n d"]:
    """Embed each image in `views` with an encoder."""
    return np.array([encoder.encode_image(image) for image in views.images])


def ask(
    views: RoomViews,
    images: Float32[np.ndarray, "n d"],
    encoder: TextEncoder,
    rng: np.random.Generator,
    held_out: bool = False,
) -> QuestionBatch:
    """Draw questions, and compute the similarity of each question to each room.

    Args:
        views: images of the rooms, with ground truth.
        images: embeddings of the images, from `embedded(views)`.
        encoder: encoder of the questions.
        rng: source of randomness.
        held_out: whether to use words that occur in no training caption, instead of trained words.
    """
    drawn = [question for topic in TOPICS for question in _drawn(topic, views, rng, held_out)]
    texts = tuple(text for _, text, _ in drawn)
    questions = embed_questions(texts, encoder)
    fits = (images @ questions.T).astype(float)
    of_rooms = np.array([best_views_mean(fits[views.room == room]) for room in range(len(views.labels))])
    topics, truths = tuple(topic for topic, _, _ in drawn), np.stack([truth for _, _, truth in drawn], axis=1)
    return QuestionBatch(texts, topics, questions, of_rooms, truths)


def _drawn(
    topic: str, views: RoomViews, rng: np.random.Generator, held_out: bool
) -> Iterator[tuple[str, str, Int[np.ndarray, "rooms"]]]:
    """Draw questions of a topic, half of them without an answer in the house; yield topic, text, and truth for each room.

    Nothing is yielded if all possible questions have an answer, or none has.
    """
    truths = {key: _truth(topic, key, views) for key in _words(topic, held_out)}
    answered = [key for key, truth in truths.items() if (truth == YES).any()]
    vain = [key for key, truth in truths.items() if (truth == NO).all()]
    if not answered or not vain:
        return
    for key in (*rng.choice(answered, _ASKED), *rng.choice(vain, _ASKED)):
        texts = list(framed(_frames(topic), _words(topic, held_out)[key]))
        yield topic, texts[int(rng.integers(len(texts)))], truths[key]


def _truth(topic: str, key: str, views: RoomViews) -> Int[np.ndarray, "rooms"]:
    if topic != THING:
        return np.where(views.labels == ROOM_LABELS.index(key), YES, NO)
    share = views.shown[:, THINGS.index(key)]
    return np.where(share >= _SEEN, YES, np.where(share > 0, DOUBTFUL, NO))


def _words(topic: str, held_out: bool) -> Table:
    if topic == NAME:
        return _filled(HELD_OUT_NAMES) if held_out else ROOM_NAMES
    if topic == ACTIVITY:
        return _filled(HELD_OUT_ACTIVITIES) if held_out else ROOM_ACTIVITIES
    return _filled(HELD_OUT_OBJECTS) if held_out else {kind: OBJECT_NAMES.get(kind, (kind,)) for kind in THINGS}


def _filled(table: Table) -> Table:
    return {key: words for key, words in table.items() if words}


def _frames(topic: str) -> tuple[str, ...]:
    return {NAME: TEMPLATES, ACTIVITY: PLACE_FRAMES, THING: THING_FRAMES}[topic]
