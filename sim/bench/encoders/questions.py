"""Questions for rooms in free words, to measure how often the right room is ranked first.

There are three topics: things that truly stand in rooms of a single label and are visible on the walk, things that are
typical of a room, and activities that are typical of a room. The questions of each topic come in three wordings: with words
and sentence frames that were used in training, with words that occur in no training caption, and with sentence frames that
occur in none. A sentence frame is the text around the words, such as "where is {a}".
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Int

from lexis.questions.answers import best_views_mean
from sim.bench.encoders.runs import EncoderRun
from sim.bench.encoders.texts import EmbeddedTexts
from sim.training.frames import THINGS
from sim.training.phrases import (
    HELD_OUT_ACTIVITIES,
    HELD_OUT_OBJECTS,
    HELD_OUT_PLACE_FRAMES,
    HELD_OUT_THING_FRAMES,
    HELD_OUT_THINGS,
    OBJECT_NAMES,
    PLACE_FRAMES,
    ROOM_ACTIVITIES,
    ROOM_THINGS,
    THING_FRAMES,
    Table,
    framed,
)
from worlds.furniture.catalogue import CATALOGUE
from worlds.labels import ROOM_LABELS
from worlds.truth import objects

SEEN, SEEN_IN = 0.01, 3
"""Questions ask for a thing only if at least `SEEN_IN` images show it, each on more than the share `SEEN` of its pixels."""
TRAINED, HELD_OUT_WORDS, HELD_OUT_FRAMES = WORDINGS = "trained", "held-out words", "held-out frames"
THING, TYPICAL, ACTIVITY = TOPICS = "thing", "typical thing", "activity"
"""Topics of questions: things that truly stand in a room, things typical of a room, activities typical of a room."""


class RoomQuestion(NamedTuple):
    """A question to which the rooms of one label are the right answers."""

    topic: str
    wording: str
    about: str
    """The kind of thing or the phrase that the question is about."""
    text: str
    answer: str
    """The label of the rooms that are right answers."""


@dataclass(frozen=True)
class AnsweredQuestion:
    """A question, and the label of the room that was ranked first (`said`)."""

    question: RoomQuestion
    said: str

    @property
    def right(self) -> bool:
        """Whether the room that was ranked first has the right label."""
        return self.said == self.question.answer


class Failure(NamedTuple):
    """A thing or phrase with at least one wrong answer, and the number of questions and of right answers."""

    topic: str
    wording: str
    about: str
    answer: str
    asked: int
    right: int
    instead: str
    """The wrong label that was ranked first most often."""


def ask(run: EncoderRun, images: Float32[np.ndarray, "n d"], texts: EmbeddedTexts) -> list[AnsweredQuestion]:
    """Ask all questions that have a right answer in the house. Rooms are ranked by their best views, as in `lexis query`."""
    questions = list(questions_of(run))
    if not questions:
        return []
    rooms = np.unique(run.room)
    fits = images @ texts.texts([question.text for question in questions]).T
    best = np.array([best_views_mean(fits[run.room == room]) for room in rooms]).argmax(axis=0)
    labels = [ROOM_LABELS[i] for i in _labels(run, rooms)]
    return [AnsweredQuestion(question, labels[i]) for question, i in zip(questions, best, strict=True)]


def questions_of(run: EncoderRun) -> Iterator[RoomQuestion]:
    """Yield the questions to which rooms of exactly one label of the house are right answers."""
    for kind, label in standing_in_one(run).items():
        names, held_out = OBJECT_NAMES.get(kind, (kind,)), HELD_OUT_OBJECTS.get(kind, ())
        yield from _worded(THING, kind, names, held_out, label, (THING_FRAMES, HELD_OUT_THING_FRAMES))
    for label in {ROOM_LABELS[i]: None for i in run.frames.rooms}:
        yield from _of_label(TYPICAL, label, ROOM_THINGS, HELD_OUT_THINGS, (THING_FRAMES, HELD_OUT_THING_FRAMES))
        yield from _of_label(ACTIVITY, label, ROOM_ACTIVITIES, HELD_OUT_ACTIVITIES, (PLACE_FRAMES, HELD_OUT_PLACE_FRAMES))


def standing_in_one(run: EncoderRun) -> Mapping[str, str]:
    """Return the kinds of furniture that stand in rooms of a single label, each with this label.

    Two sorts of kinds are left out: kinds that too few images of the run show (see `SEEN`), and kinds in rooms with a label
    that no room on the walk has.
    """
    house = run.house
    labels: dict[str, set[str]] = {}
    for thing in objects(house):
        labels.setdefault(thing.kind, set()).add(house.room_by_id[thing.room].label)
    seen = {THINGS[k] for k in np.flatnonzero((run.frames.shares > SEEN).sum(axis=0) >= SEEN_IN)}
    walked = {ROOM_LABELS[i] for i in run.frames.rooms}
    return {
        kind: next(iter(rooms))
        for kind, rooms in sorted(labels.items())
        if kind in CATALOGUE and kind in seen and len(rooms) == 1 and rooms <= walked
    }


def share_right(asked: Iterable[AnsweredQuestion], topic: str, wording: str) -> tuple[float | None, int]:
    """Return the share of right answers to questions of one topic and wording, and the number of these questions.

    The share is None if there are no such questions.
    """
    right = [a.right for a in asked if (a.question.topic, a.question.wording) == (topic, wording)]
    return (float(np.mean(right)) if right else None), len(right)


def failures(asked: Sequence[AnsweredQuestion]) -> list[Failure]:
    """Group questions by topic, wording, thing and right label; return the groups with wrong answers, the worst first."""
    groups: dict[tuple[str, str, str, str], list[AnsweredQuestion]] = {}
    for one in asked:
        topic, wording, about, _, answer = one.question
        groups.setdefault((topic, wording, about, answer), []).append(one)
    found = [
        Failure(*key, len(group), sum(one.right for one in group), _most([one.said for one in group if not one.right]))
        for key, group in groups.items()
        if not all(one.right for one in group)
    ]
    return sorted(found, key=lambda failure: failure.right - failure.asked)


def _worded(
    topic: str,
    about: str,
    words: Sequence[str],
    held_out: Sequence[str],
    label: str,
    frames: tuple[Sequence[str], Sequence[str]],
) -> Iterator[RoomQuestion]:
    trained_frames, held_out_frames = frames
    for wording, used, around in (
        (TRAINED, words, trained_frames),
        (HELD_OUT_WORDS, held_out, trained_frames),
        (HELD_OUT_FRAMES, words, held_out_frames),
    ):
        yield from (RoomQuestion(topic, wording, about, text, label) for text in framed(around, used))


def _of_label(
    topic: str, label: str, trained: Table, held_out: Table, frames: tuple[Sequence[str], Sequence[str]]
) -> Iterator[RoomQuestion]:
    for phrase in trained[label]:
        yield from _worded(topic, phrase, (phrase,), (), label, frames)
    for phrase in held_out[label]:
        yield from _worded(topic, phrase, (), (phrase,), label, frames)


def _labels(run: EncoderRun, rooms: Int[np.ndarray, "rooms"]) -> list[int]:
    return [int(run.frames.rooms[np.argmax(run.room == room)]) for room in rooms]


def _most(labels: Sequence[str]) -> str:
    return Counter(labels).most_common(1)[0][0]
