"""SVG: closed shapes are rooms, strokes are openings; what says neither is passed over.

A room is a `rect`, `polygon`, `polyline` or `path` whose `data-label`, `class` or `id` is a label ("kitchen", "Office_2").
An opening is a `line`, `polyline` or `path` whose `data-kind`, `class` or `id` is a kind of opening ("door").
`data-name` names a room. `data-storey` on an element or a group around it says the storey, and so does a group with the id
"storey-1".
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from worlds.errors import SpecError
from worlds.imports.drawing import (
    KINDS,
    Drawing,
    DrawnRoom,
    Stroke,
    checked,
    find_kind,
    find_label,
    guesses,
    kind_of,
    label_of,
    storey_of,
    words,
)
from worlds.imports.svg_shapes import IDENTITY, Affine, Shape, affine, compose, outline
from worlds.labels import ROOM_LABELS
from worlds.spec import OpeningKind

_SHAPES = ("rect", "polygon", "polyline", "path", "line")
_HIDDEN = ("defs", "symbol", "clipPath", "mask", "pattern", "marker")
_ROOM_SHAPES, _OPENING_SHAPES = _SHAPES[:-1], ("line", "polyline", "path")
_MAX_DEPTH, _MAX_ELEMENTS = 100, 100_000


@dataclass(frozen=True)
class _Group:
    """What an element hands down."""

    transform: Affine = IDENTITY
    storey: object = 0
    hidden: bool = False


@dataclass
class _Reader:
    """Collects shapes while expat reads; there is never a tree in memory."""

    stack: list[_Group] = field(default_factory=lambda: [_Group()])
    shapes: list[tuple[str, dict[str, str], _Group]] = field(default_factory=list)
    root: dict[str, str] = field(default_factory=dict)
    elements: int = 0

    def start(self, name: str, attributes: dict[str, str]) -> None:
        tag, parent = name.rpartition(":")[2], self.stack[-1]
        self.elements += 1
        if len(self.stack) == 1 and tag != "svg":
            raise SpecError(f"is not SVG: its outermost element is <{tag[:40]}>")
        if len(self.stack) > _MAX_DEPTH or self.elements > _MAX_ELEMENTS:
            raise SpecError(f"has elements nested deeper than {_MAX_DEPTH} or more than {_MAX_ELEMENTS}")
        if len(self.stack) == 1:
            self.root = attributes
        of_id = re.fullmatch(r"(?:storey|floor|level)[ _-]*(\d)", attributes.get("id", ""), re.IGNORECASE)
        storey = attributes.get("data-storey", of_id[1] if of_id and tag == "g" else parent.storey)
        transform = compose(parent.transform, affine(attributes.get("transform", "")))
        group = _Group(transform, storey, parent.hidden or tag in _HIDDEN)
        if tag in _SHAPES and not group.hidden:
            self.shapes.append((tag, attributes, group))
        self.stack.append(group)

    def end(self, _: str) -> None:
        self.stack.pop()

    @staticmethod
    def refuse(*_: object) -> None:
        raise SpecError("has a document type definition (<!DOCTYPE ...>), which could hide anything; remove it")


def read_svg(text: str, metres_per_unit: float | None) -> Drawing:
    """What an SVG draws; without a scale, the root's `data-metres-per-unit` says it. Raises `SpecError`."""
    reader = _read(text)
    scale = metres_per_unit
    if scale is None:
        try:
            scale = float(reader.root["data-metres-per-unit"])
        except (KeyError, ValueError):
            raise SpecError(
                "does not say its scale; give --metres-per-unit (in Python metres_per_unit) or data-metres-per-unit on <svg>"
            ) from None
    if not 0.0 < scale < 1e6:
        raise SpecError(f"has a scale of {scale} metres per unit; valid: above 0")
    rooms: list[DrawnRoom] = []
    strokes: list[Stroke] = []
    passed_over: list[tuple[str, str, dict[str, str]]] = []
    for i, (tag, attributes, group) in enumerate(reader.shapes):
        where = f"<{tag}> {attributes.get('id', f'number {i}')[:60]!r}"
        label, kind = _meaning(where, tag, attributes)
        if label is None and kind is None:
            passed_over.append((where, tag, attributes))
            continue
        shape = outline(where, tag, attributes)
        points = tuple((scale * x, -scale * y) for x, y in map(group.transform, shape.points))
        if not all(math.isfinite(value) and abs(value) < 1e8 for point in points for value in point):
            raise SpecError(f"{where}: has a corner at no place on Earth")
        storey = storey_of(where, group.storey)
        if label is not None:
            rooms.append(
                DrawnRoom(where, attributes.get("data-name", ""), label, storey, _closed(where, tag, shape, points))
            )
        elif kind is not None:
            strokes.append(Stroke(where, kind, storey, (points[0], points[-1])))
    return checked(rooms, strokes, notes=_notes(passed_over))


def _read(text: str) -> _Reader:
    reader, parser = _Reader(), expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = reader.start, reader.end
    # Without a DTD there are no entities but XML's own five: nothing can expand, nothing outside is read.
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = reader.refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise SpecError(f"is not SVG: {expat.ErrorString(error.code)} at line {error.lineno}") from None
    return reader


def _meaning(where: str, tag: str, attributes: dict[str, str]) -> tuple[str | None, OpeningKind | None]:
    if "data-kind" in attributes:
        return None, kind_of(where, attributes["data-kind"])
    if "data-label" in attributes:
        return label_of(where, attributes["data-label"]), None
    for text in _names(attributes):
        kind = find_kind(text)
        if kind is not None and tag not in ("rect", "polygon"):
            return None, kind
        label = find_label(text)
        if label is not None and tag != "line":
            return label, None
    return None, None


def _notes(passed_over: list[tuple[str, str, dict[str, str]]]) -> tuple[str, ...]:
    """On shapes (place, tag, attributes) that came to nothing: what they may have been meant as, and how many they are."""
    if not passed_over:
        return ()
    spoken: list[tuple[str, str]] = []
    misfits: dict[tuple[str, str], str] = {}
    for where, tag, attributes in passed_over:
        for word in map(words, _names(attributes)):
            if find_kind(word) or find_label(word):
                misfits.setdefault((tag, word), f"{where}: {word!r} is {_fitting(word)}, not a {tag}; passed over")
            elif word:
                spoken.append((where, word))
    count = f"{len(passed_over)} shapes that say neither a label nor a kind were passed over"
    return (*guesses(spoken, (*ROOM_LABELS, *KINDS)), *misfits.values(), count)


def _fitting(word: str) -> str:
    thing, shapes = ("an opening", _OPENING_SHAPES) if find_kind(word) else ("a room", _ROOM_SHAPES)
    return f"{thing}: a {', '.join(shapes[:-1])} or {shapes[-1]}"


def _names(attributes: dict[str, str]) -> Iterator[str]:
    classes = attributes.get("class", "")
    yield classes
    yield from classes.split()
    yield attributes.get("id", "")


def _closed(where: str, tag: str, shape: Shape, points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if points[0] == points[-1] and len(points) > 1:
        return points[:-1]
    if not shape.closed and tag == "path":
        raise SpecError(f"{where}: a room's path is closed; end it with Z")
    return points
