"""Captions and questions: phrases for rooms, things and activities, put into sentence frames.

A sentence frame is a template such as "a photo of {a}", in which {} stands for a phrase and {a} for a phrase with its
article.

Every third entry of the lexicon, and every third sentence frame of activities and things, is held out: it occurs in no
training caption, not even as part of another phrase. Held-out words and frames measure how well the text tower understands
wordings that images were never aligned with. All random draws use an explicit generator.
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
    """Return a pattern that finds any of the phrases, as whole words, in a text."""
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
"""Phrases that are withheld from training: every third entry of the lexicon. Entries that occur in a room label or in the
name of a kind of furniture are not withheld, since labels and kinds have to be trained."""
HOLDS_HELD_OUT = _holding(HELD_OUT_PHRASES)
"""Regular expression that finds held-out phrases in a text."""


def _split(table: Table) -> tuple[dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    held_out = frozenset(HELD_OUT_PHRASES)
    # An entry that contains a held-out phrase is not used for training. It is held out only if it is itself such a phrase.
    trained = {key: tuple(entry for entry in row if not HOLDS_HELD_OUT.search(entry)) for key, row in table.items()}
    return trained, {key: tuple(entry for entry in row[2::3] if entry in held_out) for key, row in table.items()}


ROOM_NAMES, HELD_OUT_NAMES = _split(ROOMS)
"""Trained and held-out names of rooms, by room label. The first trained name is the label itself."""
ROOM_ACTIVITIES, HELD_OUT_ACTIVITIES = _split(ACTIVITIES)
"""Trained and held-out activities in rooms, by room label, as verb phrases that can follow "to"."""
ROOM_THINGS, HELD_OUT_THINGS = _split(THINGS)
"""Trained and held-out things, by room label. They stand in rooms of this label and hardly anywhere else."""
OBJECT_NAMES, HELD_OUT_OBJECTS = _split(SYNONYMS)
"""Trained and held-out names, by kind of furniture. A kind that is not listed has only its own name."""

TEMPLATES = (
    "{}", "a photo of {a}", "a picture of {a}", "{a} in a house", "a view of {a}", "inside {a}", "an image of {a}",
    "this is {a}", "a wide photo of {a}", "a photo taken in {a}",
)  # fmt: skip
"""Sentence frames (templates) for names of rooms. They include the prompts of `lexis.encoder.prompts`."""


def _frames(frames: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Split sentence frames into trained ones and held-out ones (every third)."""
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
"""Trained and held-out sentence frames (templates) for activities in rooms."""
THING_FRAMES, HELD_OUT_THING_FRAMES = _frames(_THING_FRAMES)
"""Trained and held-out sentence frames (templates) for things."""

_ROOM_SHARE = (0.35, 0.35, 0.15, 0.15)
"""Shares of the captions of a room that use its label, any of its names, an activity in it, and a thing in it."""


def caption(name: str, rng: np.random.Generator) -> str:
    """Put `name`, the name of a room or a thing, into a randomly chosen template of `TEMPLATES`."""
    return _framed(_pick(TEMPLATES, rng), name)


def room_caption(label: str, rng: np.random.Generator) -> str:
    """Draw a caption of a room in trained words: with its label, one of its names, an activity or a thing.

    The probabilities of these four kinds of caption are 0.35, 0.35, 0.15 and 0.15.
    """
    draw = int(rng.choice(4, p=_ROOM_SHARE))
    if draw == 0:
        return caption(label, rng)
    if draw == 1:
        return caption(_pick(ROOM_NAMES[label], rng), rng)
    if draw == 2:
        return _framed(_pick(PLACE_FRAMES, rng), _pick(ROOM_ACTIVITIES[label], rng))
    return _framed(_pick(THING_FRAMES, rng), _pick(ROOM_THINGS[label], rng))


def object_caption(kind: str, rng: np.random.Generator) -> str:
    """Draw a caption or question that calls a kind of furniture by one of the names used in training."""
    return _framed(_pick(THING_FRAMES, rng), _pick(OBJECT_NAMES.get(kind, (kind,)), rng))


def framed(frames: Sequence[str], words: Sequence[str]) -> Iterator[str]:
    """Yield each word or phrase in each sentence frame (template)."""
    return (_framed(frame, phrase) for phrase in words for frame in frames)


def _framed(frame: str, phrase: str) -> str:
    return frame.format(phrase, a=with_article(phrase))


def _pick(choices: Sequence[str], rng: np.random.Generator) -> str:
    return choices[int(rng.integers(len(choices)))]
