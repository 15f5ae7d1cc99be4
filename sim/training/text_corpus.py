"""Makes the training texts of the text tower: single words, random compositions of words, and the training captions.

The texts have no labels, since the teacher (a sentence encoder) gives their targets. Held-out phrases of several words are
left out, also as parts of longer texts. Held-out single words do occur, like all other words of the vocabulary.
"""

import re
from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np
import open_clip.tokenizer
from jaxtyping import Float32

from lexis.encoder.prompts import with_article
from sim.training.phrases import (
    HELD_OUT_PHRASES,
    OBJECT_NAMES,
    PLACE_FRAMES,
    ROOM_ACTIVITIES,
    ROOM_NAMES,
    ROOM_THINGS,
    TEMPLATES,
    THING_FRAMES,
    framed,
)

_PHRASES = (
    "{0}", "{0} {1}", "{0} {1}", "{0} {1}", "{0}{1}", "{0} {2} {1}", "{0} and {1}", "{1} with {a0}", "{1} for {0}",
    "{1} of {0}", "{0} the {1}", "{0} my {1}", "{0} {a1}", "{0} in the {1}", "{1} full of {0}", "{0} on the {1}",
    "{0} the {2} {1}", "{0}'s {1}", "{1} where {2} {0}", "{1} to {0} {2}", "{0} with {2} {1}", "{0} to the {1}",
)  # fmt: skip
"""Patterns that combine random words. Meaningless combinations do no harm, since the teacher embeds them too."""

_HEADS = (
    "room", "area", "space", "place", "hall", "house", "corner", "shop", "closet", "cabinet", "table", "chair", "shelf",
    "stand", "board", "machine", "rack", "box", "floor", "door", "lamp", "bed", "bench", "yard", "way",
    "ette", "er", "ing", "ery", "s",
)  # fmt: skip
"""Words and suffixes at the end of many names of rooms and things."""
_SCENES = (
    "{0} with {1}", "{0} with {1} and {2}", "{1} in {0}", "{1} and {2}", "a room with {1} and {2}", "{0} with {1} in it",
)  # fmt: skip
"""Sentence frames with a room {0} and two things {1} and {2}."""
_BARE_SHARE, _HEAD_SHARE = 0.4, 0.3
"""Share of all random texts (see `compositions`) that are not put into a sentence frame (a template), and share of all
random texts whose second word is replaced by one of `_HEADS`."""
_NEAR_SHARE = 0.7
"""Share of the random words that are drawn from words related to houses (`near_words`), not from all words."""


_FORBIDDEN = re.compile(
    r"\b(?:" + "|".join(re.escape(phrase) for phrase in HELD_OUT_PHRASES if " " in phrase) + r")\b", re.IGNORECASE
)


def plain_words(more: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the words of CLIP's vocabulary and of `more` that consist of three or more letters a to z, sorted."""
    tokens = open_clip.tokenizer.SimpleTokenizer().encoder
    whole = (token.removesuffix("</w>") for token in tokens if token.endswith("</w>"))
    return tuple(sorted({word for word in chain(whole, more) if re.fullmatch("[a-z]{3,}", word)}))


def captions() -> tuple[str, ...]:
    """Return captions: each trained name, activity and thing in each trained sentence frame (template)."""
    rooms = (framed(TEMPLATES, names) for names in ROOM_NAMES.values())
    places = (framed(PLACE_FRAMES, activities) for activities in ROOM_ACTIVITIES.values())
    things = (framed(THING_FRAMES, names) for table in (ROOM_THINGS, OBJECT_NAMES) for names in table.values())
    return tuple(dict.fromkeys(chain.from_iterable(chain(rooms, places, things))))


def near_words(
    words: Sequence[str], vectors: Float32[np.ndarray, "words d"], anchors: Float32[np.ndarray, "anchors d"], count: int
) -> tuple[str, ...]:
    """Return words that are related to houses: the `count` words most similar to any anchor, then all words of captions.

    The words of captions are listed twice, so that they are drawn more often. `vectors` are the teacher's embeddings of the
    words, and `anchors` are embeddings by the teacher of captions of rooms.
    """
    order = np.argsort(-(vectors @ anchors.T).max(axis=1), kind="stable")
    tables = (ROOM_NAMES, ROOM_ACTIVITIES, ROOM_THINGS, OBJECT_NAMES)
    entries = " ".join(entry for table in tables for row in table.values() for entry in row)
    used = tuple(sorted(set(re.findall("[a-z]{3,}", entries.lower()))))
    return (*(words[i] for i in order[:count]), *used, *used)


def compositions(words: Sequence[str], near: Sequence[str], count: int, rng: np.random.Generator) -> tuple[str, ...]:
    """Compose `count` different texts of random words, mostly from `near`, without held-out phrases of several words."""
    found: dict[str, None] = {}
    frames = (*TEMPLATES, *PLACE_FRAMES, *THING_FRAMES)
    while len(found) < count:
        drawn = [_draw(words, near, rng, count) for _ in range(3)]
        phrases, frame_of = rng.integers(len(_PHRASES), size=count), rng.integers(len(frames), size=count)
        heads, ends = rng.random(count) < _HEAD_SHARE, rng.integers(len(_HEADS), size=count)
        bare = rng.random(count) < _BARE_SHARE
        for k, (first, second, third) in enumerate(zip(*drawn, strict=True)):
            last = _HEADS[ends[k]] if heads[k] else second
            phrase = _PHRASES[phrases[k]].format(first, last, third, a0=with_article(first), a1=with_article(last))
            text = phrase if bare[k] else frames[frame_of[k]].format(phrase, a=with_article(phrase))
            if not _FORBIDDEN.search(text):
                found[text] = None
    return tuple(found)[:count]


def room_scenes(count: int, rng: np.random.Generator) -> tuple[str, ...]:
    """Draw `count` captions with a trained name of a room and one or two things of the room.

    Duplicates and captions with held-out phrases are removed.
    """
    labels = tuple(ROOM_NAMES)
    drawn = (_scene(labels[int(rng.integers(len(labels)))], rng) for _ in range(count))
    return tuple(text for text in dict.fromkeys(drawn) if not _FORBIDDEN.search(text))


def _scene(label: str, rng: np.random.Generator) -> str:
    name = with_article(str(rng.choice(ROOM_NAMES[label])))
    things = [with_article(str(thing)) for thing in rng.choice(ROOM_THINGS[label], 2, replace=False)]
    return _SCENES[int(rng.integers(len(_SCENES)))].format(name, *things)


def _draw(words: Sequence[str], near: Sequence[str], rng: np.random.Generator, count: int) -> list[str]:
    close = rng.random(count) < _NEAR_SHARE
    indices = np.where(close, rng.integers(len(near), size=count), rng.integers(len(words), size=count))
    return [near[i] if c else words[i] for i, c in zip(indices, close, strict=True)]
