"""What captions say: rooms, things and what is done there, in the frames that people put them in.

Every third entry of the lexicon, and every third frame of activities and things, is held out: it stands in no caption, not
even within another phrase, and measures how far the text tower understands words and wordings that images were never
aligned with. Everything is drawn from an explicit generator.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

import numpy as np

from lexis.encoder.prompts import with_article
from sim.training.lexicon import ACTIVITIES, ROOMS, SYNONYMS, THINGS
from worlds.furniture.catalogue import CATALOGUE

Table = Mapping[str, tuple[str, ...]]
_TABLES = (ROOMS, ACTIVITIES, THINGS, SYNONYMS)


def _holding(phrases: Sequence[str]) -> re.Pattern[str]:
    """Matches texts in which one of the phrases stands, as whole words."""
    return re.compile(r"\b(?:" + "|".join(sorted(map(re.escape, phrases))) + r")\b", re.IGNORECASE)


_KEYS = " , ".join(chain(*_TABLES, CATALOGUE))
HELD_OUT_PHRASES = tuple(
    sorted(
        {
            phrase
            for table in _TABLES
            for row in table.values()
            for phrase in row[2::3]
            if not _holding([phrase]).search(_KEYS)
        }
    )
)
"""Every third entry, less the words that labels and kinds of furniture are made of: those have to be trained."""
HOLDS_HELD_OUT = _holding(HELD_OUT_PHRASES)


def _split(table: Table) -> tuple[dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    held_out = frozenset(HELD_OUT_PHRASES)
    trained = {key: tuple(entry for entry in row if not HOLDS_HELD_OUT.search(entry)) for key, row in table.items()}
    return trained, {key: tuple(entry for entry in row[2::3] if entry in held_out) for key, row in table.items()}


ROOM_NAMES, HELD_OUT_NAMES = _split(ROOMS)
"""Trained and held-out names by room label; the first trained one is the label itself."""
ROOM_ACTIVITIES, HELD_OUT_ACTIVITIES = _split(ACTIVITIES)
"""What is done in a room, to be read after "to"."""
ROOM_THINGS, HELD_OUT_THINGS = _split(THINGS)
"""What stands in a room and nearly nowhere else."""
OBJECT_NAMES, HELD_OUT_OBJECTS = _split(SYNONYMS)
"""Names by kind of furniture; kinds that are not listed go by their own name."""

TEMPLATES = (
    "{}", "a photo of {a}", "a picture of {a}", "{a} in a house", "a view of {a}", "inside {a}", "an image of {a}",
    "this is {a}", "a wide photo of {a}", "a photo taken in {a}",
)  # fmt: skip
"""Around the name of a room, {a} with its article; those of `lexis.encoder.prompts` are among them."""


def _frames(frames: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Trained ones, and every third."""
    return tuple(frame for index, frame in enumerate(frames) if index % 3 != 2), tuple(frames[2::3])


_PLACE_FRAMES = (
    "a place to {}", "where can I {}", "somewhere to {}", "a room to {} in", "where to {}", "where could one {}",
    "I want to {}", "{}", "the best place to {}", "a room where people {}", "where do people {}", "I would like to {}",
)  # fmt: skip
_THING_FRAMES = (
    "{a}", "a room with {a}", "where is {a}", "a photo of {a}", "where can I find {a}", "a place with {a}",
    "find {a}", "{a} in a room", "the room that has {a}", "{}", "a view of {a}", "I am looking for {a}",
)  # fmt: skip
PLACE_FRAMES, HELD_OUT_PLACE_FRAMES = _frames(_PLACE_FRAMES)
"""Around what is done somewhere."""
THING_FRAMES, HELD_OUT_THING_FRAMES = _frames(_THING_FRAMES)
"""Around a thing."""

_ROOM_SHARE = (0.35, 0.35, 0.15, 0.15)
"""Of captions with the label itself, another name, an activity, a thing."""


def caption(name: str, rng: np.random.Generator) -> str:
    """A caption with `name`, of a room or a thing, in a random frame."""
    return _framed(_pick(TEMPLATES, rng), name)


def room_caption(label: str, rng: np.random.Generator) -> str:
    """A caption that tells the room: by a trained name, the label itself above all, by what is done or what stands there."""
    draw = int(rng.choice(4, p=_ROOM_SHARE))
    if draw == 0:
        return caption(label, rng)
    if draw == 1:
        return caption(_pick(ROOM_NAMES[label], rng), rng)
    if draw == 2:
        return _framed(_pick(PLACE_FRAMES, rng), _pick(ROOM_ACTIVITIES[label], rng))
    return _framed(_pick(THING_FRAMES, rng), _pick(ROOM_THINGS[label], rng))


def object_caption(kind: str, rng: np.random.Generator) -> str:
    """A caption or question that names a kind of furniture by a trained name."""
    return _framed(_pick(THING_FRAMES, rng), _pick(OBJECT_NAMES.get(kind, (kind,)), rng))


def framed(frames: Sequence[str], words: Sequence[str]) -> Iterator[str]:
    """Every word or phrase in every frame."""
    return (_framed(frame, phrase) for phrase in words for frame in frames)


def _framed(frame: str, phrase: str) -> str:
    return frame.format(phrase, a=with_article(phrase))


def _pick(choices: Sequence[str], rng: np.random.Generator) -> str:
    return choices[int(rng.integers(len(choices)))]
