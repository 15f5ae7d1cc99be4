"""A floor plan as drawn: the outlines of rooms and the strokes of openings, before they are straightened into a house."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from worlds.errors import SpecError
from worlds.labels import ROOM_LABELS
from worlds.spec import MAX_ROOMS, MAX_STOREYS, OpeningKind, Point, json_schema
from worlds.spec_errors import explain, mistakes_error
from worlds.valid_names import did_you_mean

MAX_STROKES = 3200
MAX_LISTED = 8
"""Largest number of ignored shapes that one note lists."""
_SURE = 0.8
"""Least similarity, in [0, 1], of an unknown word and the known word that a note suggests instead. With a lower value, the
notes would suggest `half wall` for `wall`."""
_MAX_WORDS, _MAX_NOTES = 1000, 20
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
    """The outline of a room, as drawn."""

    where: str
    """Place of the room in the file, for messages."""
    name: str
    """Name as drawn; empty if the file gives none."""
    label: str
    storey: int
    corners: tuple[Point, ...]
    """Corners [m], clockwise or counter-clockwise. The first corner is not repeated at the end."""
    climb: object = "flights"
    """Field `climb` of `RoomSpec` as given in the file, not yet validated."""


@dataclass(frozen=True)
class Stroke:
    """A drawn line or point on a wall that stands for a door or another opening."""

    where: str
    """Place of the stroke in the file, for messages."""
    kind: OpeningKind
    storey: int
    points: tuple[Point, ...]
    """Both ends of the opening, or its middle alone [m]."""
    details: tuple[tuple[str, Any], ...] = ()
    """Further fields of `OpeningSpec`. The field `leaf` refers to rooms by their names in the drawing."""


@dataclass(frozen=True)
class DrawnPlan:
    """The content of a file, in metres, with x to the right and y up."""

    rooms: tuple[DrawnRoom, ...]
    strokes: tuple[Stroke, ...]
    heights_m: tuple[tuple[int, object], ...] = ()
    """Pairs (storey, height as given in the file, not yet validated [m]) for the storeys whose height is given."""
    slab_m: object = None
    """Thickness of the slab between storeys as given in the file, not yet validated [m]; None if the file gives none."""
    notes: tuple[str, ...] = ()
    """Notes for the user, such as which shapes were ignored."""

    @property
    def doubt(self) -> str:
        """Text for the end of an error message: the first of the notes, put in parentheses; empty if there are no notes.

        The note helps because a shape that was ignored may have caused the error.
        """
        return f" (note: {self.notes[0]})" if self.notes else ""


@lru_cache(maxsize=256)
def normalised_name(text: str) -> str:
    """Return a name in lower case, with spaces for underscores and without a number at its end: "office" for "Office_2"."""
    words = " ".join(text.lower().replace("_", " ").split())
    without_number = words.rstrip("0123456789")
    return words if without_number == words else without_number.rstrip(" .#-")


def find_label(text: str) -> str | None:
    """Return the room label that a text stands for, such as "toilet" for "WC"; None if the text is no known label."""
    return _LABELS.get(normalised_name(text).replace("-", " "))


def label_of(where: str, text: str) -> str:
    """Return the room label that a text stands for. Raises `SpecError` if the text is no known label."""
    if (label := find_label(text)) is None:
        guess = did_you_mean(normalised_name(text), ROOM_LABELS)
        raise SpecError(f"{where}: unknown label {text[:60]!r}{guess}; valid: {', '.join(ROOM_LABELS)}")
    return label


def find_kind(text: str) -> OpeningKind | None:
    """Return the kind of opening that a text stands for, such as "door" for "Doors"; None if the text is no known kind."""
    word = normalised_name(text).replace("-", " ")
    return _KINDS.get(word) or _KINDS.get(word.removesuffix("s")) or _KINDS.get(word.removesuffix("es"))


def opening_kind_of(where: str, text: str) -> OpeningKind:
    """Return the kind of opening that a text stands for. Raises `SpecError` if the text is no known kind."""
    if (kind := find_kind(text)) is None:
        guess = did_you_mean(normalised_name(text), KINDS)
        raise SpecError(f"{where}: unknown kind of opening {text[:60]!r}{guess}; valid: {', '.join(KINDS)}")
    return kind


def spelling_notes(spoken: Iterable[tuple[str, str]], meaningful: Iterable[str]) -> tuple[str, ...]:
    """Return notes for the user on unknown words in a file that resemble a word in `meaningful`.

    `spoken` lists the unknown words as pairs (place in the file, word). Each word is reported once, at its first place.
    """
    places: dict[str, str] = {}
    for where, word in spoken:
        places.setdefault(word, where)
    valid = tuple(meaningful)
    found = ((where, word[:60], did_you_mean(word[:60], valid, _SURE)) for word, where in islice(places.items(), _MAX_WORDS))
    notes = (f"{where}: {word!r} is unknown{guess}; ignored" for where, word, guess in found if guess)
    return tuple(islice(notes, _MAX_NOTES))


def storey_number(where: str, value: object) -> int:
    """Return `value` as the number of a storey, 0 for the ground floor. Raises `SpecError` if it is no valid number."""
    text = str(value)
    if isinstance(value, bool) or not re.fullmatch(r"\d(\.0)?", text) or int(text[0]) >= MAX_STOREYS:
        raise SpecError(f"{where}: storey {text[:40]!r}; valid: 0 (the lowest) to {MAX_STOREYS - 1}")
    return int(text[0])


def validated(where: str, model: type[_Model], **fields: Any) -> _Model:
    """Build a part of a spec from its fields.

    Raises `SpecError` for fields that are not valid. The message names the place `where` and lists all mistakes.
    """
    try:
        return model.model_validate(fields, strict=True)
    except ValidationError as error:
        schema = json_schema()
        part = schema["$defs"].get(error.title, schema)
        mistakes = explain(error, None, {**part, "$defs": schema["$defs"]})
        raise mistakes_error(where, mistakes) from None


def checked(rooms: Iterable[DrawnRoom], strokes: Iterable[Stroke], **more: Any) -> DrawnPlan:
    """Return a plan with these rooms and strokes; `more` are further fields of `DrawnPlan`.

    Raises `SpecError` if there is no room, or if there are too many rooms or strokes.
    """
    drawing = DrawnPlan(tuple(rooms), tuple(strokes), **more)
    if not 1 <= len(drawing.rooms) <= MAX_ROOMS:
        raise SpecError(f"has {len(drawing.rooms)} rooms with a label; valid: 1 to {MAX_ROOMS}{drawing.doubt}")
    if len(drawing.strokes) > MAX_STROKES:
        raise SpecError(f"has {len(drawing.strokes)} openings; valid: at most {MAX_STROKES}")
    return drawing
