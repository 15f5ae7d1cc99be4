"""A floor plan as somebody drew it: polygons and strokes that are nearly, but not quite, a house."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from worlds.errors import SpecError
from worlds.labels import ROOM_LABELS
from worlds.spec import MAX_ROOMS, OpeningKind, Point, json_schema
from worlds.spec_errors import explain, refusal
from worlds.valid_names import did_you_mean

MAX_STROKES = 3200
MAX_STOREYS = 8
_SURE = 0.8
"""Likeness of words from which a guess is made unasked: below it, `wall` is a `half wall`."""
_MAX_WORDS, _MAX_NOTES = 1000, 20
_Thing = TypeVar("_Thing")
_Model = TypeVar("_Model", bound=BaseModel)
_LABELS = {label.replace("-", " "): label for label in ROOM_LABELS} | {
    "bath": "bathroom", "wc": "toilet", "restroom": "toilet", "hall": "corridor", "hallway": "corridor",
    "foyer": "entrance hall", "entrance": "entrance hall", "lounge": "living room", "living": "living room",
    "dining": "dining room", "study": "office", "staircase": "stairs", "stairwell": "stairs", "laundry": "laundry room",
    "storage": "storage room", "terrace": "balcony", "nursery": "children's room", "lab": "laboratory", "yard": "garden",
}  # fmt: skip
KINDS: tuple[OpeningKind, ...] = get_args(OpeningKind)
_KINDS: dict[str, OpeningKind] = {kind: kind for kind in KINDS} | {
    "doorway": "door", "passage": "cased", "opening": "cased", "hatch": "counter",
}  # fmt: skip


@dataclass(frozen=True)
class DrawnRoom:
    """A room's outline."""

    where: str
    """Its place in the file, for messages."""
    name: str
    """Empty: none was given."""
    label: str
    storey: int
    corners: tuple[Point, ...]
    """Without the first again at the end; either way round [m]."""


@dataclass(frozen=True)
class Stroke:
    """Something drawn on a wall: a door or another opening."""

    where: str
    kind: OpeningKind
    storey: int
    points: tuple[Point, ...]
    """One (its middle) or both ends [m]."""
    details: tuple[tuple[str, Any], ...] = ()
    """Further fields of `OpeningSpec`; those of `leaf` have the rooms' names as drawn."""


@dataclass(frozen=True)
class DrawnPlan:
    """All that a file says, in metres, x right and y up."""

    rooms: tuple[DrawnRoom, ...]
    strokes: tuple[Stroke, ...]
    heights_m: tuple[tuple[int, float], ...] = ()
    """Storeys whose height is given."""
    notes: tuple[str, ...] = ()

    @property
    def doubt(self) -> str:
        """The first note, to end a message with: what was passed over may be what is missing."""
        return f" (note: {self.notes[0]})" if self.notes else ""


@lru_cache(maxsize=256)
def words(text: str) -> str:
    """A name without case, underscores and the number at its end: "Office_2" is an office."""
    return re.sub(r"\s+", " ", re.sub(r"[ _.#-]*\d+$", "", text.strip().lower().replace("_", " "))).strip()


def find_label(text: str) -> str | None:
    """The room label that a text means, if any."""
    return _LABELS.get(words(text).replace("-", " "))


def label_of(where: str, text: str) -> str:
    """The room label that a text means. Raises `SpecError`."""
    if (label := find_label(text)) is None:
        guess = did_you_mean(words(text), ROOM_LABELS)
        raise SpecError(f"{where}: unknown label {text[:60]!r}{guess}; valid: {', '.join(ROOM_LABELS)}")
    return label


def find_kind(text: str) -> OpeningKind | None:
    """The kind of opening that a text means, if any."""
    word = words(text).replace("-", " ")
    return _KINDS.get(word) or _KINDS.get(word.removesuffix("s")) or _KINDS.get(word.removesuffix("es"))


def kind_of(where: str, text: str) -> OpeningKind:
    """The kind of opening that a text means. Raises `SpecError`."""
    if (kind := find_kind(text)) is None:
        guess = did_you_mean(words(text), KINDS)
        raise SpecError(f"{where}: unknown kind of opening {text[:60]!r}{guess}; valid: {', '.join(KINDS)}")
    return kind


def guesses(spoken: Iterable[tuple[str, str]], meaningful: Iterable[str]) -> tuple[str, ...]:
    """Notes on words that are nearly one of the `meaningful`; of (place, word) pairs, each word where it is first said."""
    places: dict[str, str] = {}
    for where, word in spoken:
        places.setdefault(word, where)
    valid = tuple(meaningful)
    found = ((where, word[:60], did_you_mean(word[:60], valid, _SURE)) for word, where in islice(places.items(), _MAX_WORDS))
    notes = (f"{where}: {word!r} means nothing{guess}; passed over" for where, word, guess in found if guess)
    return tuple(islice(notes, _MAX_NOTES))


def some(things: Sequence[_Thing], shown: Callable[[_Thing], str] = str, most: int = 8) -> str:
    """Things in a line, not too many."""
    return "; ".join(map(shown, things[:most])) + (f"; and {len(things) - most} more" if len(things) > most else "")


def storey_of(where: str, value: object) -> int:
    """A storey's number, 0 for the ground floor. Raises `SpecError`."""
    text = str(value)
    if isinstance(value, bool) or not re.fullmatch(r"\d(\.0)?", text) or int(text[0]) >= MAX_STOREYS:
        raise SpecError(f"{where}: storey {text[:40]!r}; valid: 0 (the lowest) to {MAX_STOREYS - 1}")
    return int(text[0])


def built(where: str, model: type[_Model], **fields: Any) -> _Model:
    """A part of a spec; what is wrong with it is said with its place in the file. Raises `SpecError`."""
    try:
        return model.model_validate(fields, strict=True)
    except ValidationError as error:
        schema = json_schema()
        part = schema["$defs"].get(error.title, schema)
        mistakes = explain(error, None, {**part, "$defs": schema["$defs"]})
        raise refusal(where, mistakes) from None


def checked(rooms: Iterable[DrawnRoom], strokes: Iterable[Stroke], **more: Any) -> DrawnPlan:
    """A drawing of bounded size. Raises `SpecError`."""
    drawing = DrawnPlan(tuple(rooms), tuple(strokes), **more)
    if not 1 <= len(drawing.rooms) <= MAX_ROOMS:
        raise SpecError(f"has {len(drawing.rooms)} rooms with a label; valid: 1 to {MAX_ROOMS}{drawing.doubt}")
    if len(drawing.strokes) > MAX_STROKES:
        raise SpecError(f"has {len(drawing.strokes)} openings; valid: at most {MAX_STROKES}")
    return drawing
