"""Reads floor plans as SVG: closed shapes are rooms, strokes are openings, and all other shapes are ignored.

- A room is a `rect`, `polygon`, `polyline` or `path` that names a room label ("kitchen", "Office_2"): in its `data-label`,
  its `class`, its Inkscape label or its `id`.
- An opening is a `line`, `polyline` or `path` that names a kind of opening ("door"): in its `data-kind`, its `class`, its
  Inkscape label or its `id`. It runs from one end to the other; a closed one has four corners, and the opening runs along
  the middle of this rectangle. With `data-kind`, `rect` and `polygon` are openings, too.
- A shape that names neither a label nor a kind takes it from the innermost group around the shape that names one: every
  stroke in a layer "Doors" is a door, and the only shape in a group "kitchen" is the kitchen.
- `data-name`, or else the Inkscape label, is the name of a room.
- `data-storey` on an element or on a group around it gives the storey. So does the name of a group or layer such as
  "storey-1" or "Floor 1".
- Layers and shapes that `display` or `visibility` hides are ignored. These properties are read from attributes and from
  `style`, but not from style sheets.
- Rooms and openings inside an `<svg>` or `<symbol>` with `x`, `y` or `viewBox` are refused; only the outermost `<svg>` can
  have these attributes.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TypeAlias
from xml.etree.ElementTree import Element

import numpy as np

from worlds.errors import SpecError
from worlds.labels import ROOM_LABELS
from worlds.plan_import.drawn_plan import (
    KINDS,
    MAX_LISTED,
    DrawnPlan,
    DrawnRoom,
    Stroke,
    checked,
    find_kind,
    find_label,
    label_of,
    normalised_name,
    opening_kind_of,
    spelling_notes,
    storey_number,
)
from worlds.plan_import.svg_shapes import OPENING_TAGS, ROOM_TAGS, Outline, is_curved, length_px
from worlds.plan_import.svg_tree import LABEL, Named, SvgShape, outline_of, read_tree, shown_shapes
from worlds.spec import OpeningKind, Point
from worlds.valid_names import listed

_PX_M = 0.0254 / 96.0
_SMALLEST_PLAN_M = 2.0
"""Least size of a plan at full scale [m]. A smaller plan must have been drawn at a reduced scale, such as 1:100."""
_FAR_M = 1e8
_MAX_CHARACTERS = 1_000_000
_Meaning: TypeAlias = tuple[SvgShape, str | None, OpeningKind | None]
"""A shape, its label if it is a room, and its kind if it is an opening. Either the label or the kind is None."""
_NAMELESS = "they name neither a label nor a kind"
_UNSUITABLE = "such shapes cannot be what their name, or their group's name, says"
_UNCLEAR = "several shapes could be the room that their group names"
_PAGE = re.compile(r"\s*[\d.]+\s*(?:mm|cm|in|pt|pc)\s*")


@np.errstate(over="ignore", invalid="ignore")  # huge transforms give infinite corners, which _points refuses
def read_svg(text: str, metres_per_unit: float | None) -> DrawnPlan:
    """Read the plan in an SVG. Raises `SpecError` if the text is not SVG, or if a room or an opening is invalid.

    If `metres_per_unit` is None, the root element has to state the scale: by `data-metres-per-unit`, or by a page width with
    a unit such as mm.
    """
    root = read_tree(text)
    scale = _scale(root) if metres_per_unit is None else metres_per_unit
    if not 0.0 < scale < 1e6:
        raise SpecError(f"has a scale of {scale} metres per unit; valid: above 0")
    shapes = list(shown_shapes(root))
    meanings = _meanings(shapes)
    if sum(len(shape.attributes.get("d", shape.attributes.get("points", ""))) for shape, *_ in meanings) > _MAX_CHARACTERS:
        raise SpecError(f"has more than {_MAX_CHARACTERS} characters of coordinates in rooms and openings")
    rooms = [_room(shape, label, scale) for shape, label, _ in meanings if label is not None]
    strokes = [_stroke(shape, kind, scale) for shape, _, kind in meanings if kind is not None]
    understood = {id(shape) for shape, *_ in meanings}
    drawing = checked(rooms, strokes, notes=tuple(_notes([shape for shape in shapes if id(shape) not in understood])))
    if metres_per_unit is None and "data-metres-per-unit" not in root.attrib:
        _check_true_to_scale(drawing, scale)
    return drawing


def _room(shape: SvgShape, label: str, scale: float) -> DrawnRoom:
    drawn = outline_of(shape)
    if shape.tag == "path" and not drawn.closed:
        raise SpecError(f"{shape.where}: a room's path is closed; end it with Z")
    name = shape.attributes.get("data-name") or shape.attributes.get(LABEL, "")
    corners = _points(shape.where, drawn, scale)
    return DrawnRoom(shape.where, name, label, storey_number(shape.where, shape.storey), corners)


def _stroke(shape: SvgShape, kind: OpeningKind, scale: float) -> Stroke:
    drawn = outline_of(shape)
    points = _points(shape.where, drawn, scale)
    ends = _middle_line(shape.where, points) if drawn.closed and len(points) > 2 else (points[0], points[-1])
    return Stroke(shape.where, kind, storey_number(shape.where, shape.storey), ends)


def _middle_line(where: str, corners: Sequence[Point]) -> tuple[Point, Point]:
    """Return the middles of the two shorter sides of an opening that is drawn as a rectangle with these corners."""
    if len(corners) != 4:
        raise SpecError(
            f"{where}: is a closed shape with {len(corners)} corners; valid: for an opening 4, or the line along its wall"
        )
    a, b, c, d = corners
    sides = ((a, b), (c, d)) if math.dist(a, b) + math.dist(c, d) < math.dist(b, c) + math.dist(d, a) else ((b, c), (d, a))
    (start, end) = (((x0 + x1) / 2, (y0 + y1) / 2) for (x0, y0), (x1, y1) in sides)
    return start, end


def _scale(root: Element) -> float:
    """Return the metres per unit that the root element states: in `data-metres-per-unit`, or by the width of its page."""
    if (stated := root.get("data-metres-per-unit")) is not None:
        try:
            return float(stated)
        except ValueError:
            raise SpecError(f"data-metres-per-unit is {stated[:40]!r}; valid: a number above 0") from None
    width = root.get("width", "")
    if not _PAGE.fullmatch(width):
        raise SpecError(
            "does not state its scale; give --metres-per-unit (in Python metres_per_unit) or data-metres-per-unit on <svg>, "
            "for example 0.01 where a unit is a centimetre"
        )
    page_px = length_px("<svg>", "width", width)
    if page_px == 0.0:
        raise SpecError(f"has a page with the width {width[:40]!r}; valid: a width above 0")
    box = re.findall(r"[-+.\deE]+", root.get("viewBox", ""))
    try:
        units = float(box[2]) if len(box) == 4 else page_px
        return page_px * _PX_M / units
    except (ValueError, ZeroDivisionError):
        raise SpecError(
            f"has the viewBox {root.get('viewBox', '')[:60]!r}; valid: the numbers x, y, width and height, the width above 0"
        ) from None


def _check_true_to_scale(drawing: DrawnPlan, scale: float) -> None:
    x, y = zip(*(corner for room in drawing.rooms for corner in room.corners), strict=True)
    width, height = max(x) - min(x), max(y) - min(y)
    if max(width, height) < _SMALLEST_PLAN_M:
        raise SpecError(
            f"is {width:.2g} x {height:.2g} m on its page, too small for a house, so it must be a scale drawing; "
            f"give --metres-per-unit (in Python metres_per_unit), {100 * scale:.4g} for 1:100"
        )


def _meaning(thing: Named) -> tuple[str | None, OpeningKind | None]:
    """Return (label, kind): the room label or the kind of opening that a shape or group itself names. At least one is None.

    A name in the class, the Inkscape label or the id counts only if it suits the tag: a `line` cannot be a room, and a
    `rect` or `polygon` cannot be an opening.
    """
    attributes, tag = thing.attributes, thing.tag
    if "data-kind" in attributes:
        return None, opening_kind_of(thing.where, attributes["data-kind"])
    if "data-label" in attributes:
        return label_of(thing.where, attributes["data-label"]), None
    for text in thing.names:
        kind = find_kind(text)
        if kind is not None and tag not in ("rect", "polygon"):
            return None, kind
        label = find_label(text)
        if label is not None and tag != "line":
            return label, None
    return None, None


def _meanings(shapes: Sequence[SvgShape]) -> list[_Meaning]:
    """Return the shapes that stand for a room or an opening, by their own names or else by the names of groups around them.

    If a group names a kind of opening, every stroke in the group is an opening of this kind. If a group names a room label,
    the label counts only if exactly one shape in the group can be the room. With several shapes, such as the outline and the
    furniture of a kitchen, it would be unclear which shape is the room.
    """
    found: list[tuple[_Meaning, Named | None]] = []
    for shape in shapes:
        label, kind = _meaning(shape)
        if label is not None or kind is not None:
            found.append(((shape, label, kind), None))
        elif inherited := _inherited(shape):
            group, label, kind = inherited
            found.append(((shape, label, kind), group if label is not None else None))
    heirs = Counter(id(group) for _, group in found if group is not None)
    return [meaning for meaning, group in found if group is None or heirs[id(group)] == 1]


def _inherited(shape: SvgShape) -> tuple[Named, str | None, OpeningKind | None] | None:
    """Return the innermost group around a shape that names a room label or a kind of opening, with this label and kind.

    Either the label or the kind is None. The whole result is None if no group names anything, or if the shape's tag does not
    suit what the group names.
    """
    for group in shape.groups:
        label, kind = _meaning(group)
        if label is not None or kind is not None:
            # A layer of doors also contains arcs that show how the doors swing; they are not openings.
            fits = shape.tag in ROOM_TAGS if kind is None else shape.tag in OPENING_TAGS and not is_curved(shape.attributes)
            return (group, label, kind) if fits else None
    return None


def _points(where: str, drawn: Outline, scale: float) -> tuple[Point, ...]:
    """Return the corners in metres, with y up."""
    corners = drawn.corners * scale
    if not np.isfinite(corners).all() or np.abs([corners.real, corners.imag]).max() > _FAR_M:
        raise SpecError(f"{where}: has a corner more than {_FAR_M:g} m from the origin; valid: nearer corners")
    return tuple((x, -y) for x, y in zip(corners.real.tolist(), corners.imag.tolist(), strict=True))


def _notes(ignored: Sequence[SvgShape]) -> Iterator[str]:
    """Yield notes for the user on ignored shapes.

    The notes name words that resemble known words, and known words on shapes that do not suit them. The last notes list the
    ignored shapes, one note for each reason.
    """
    spoken: list[tuple[str, str]] = []
    misfits: dict[tuple[str, str], str] = {}
    for shape in ignored:
        for word in map(normalised_name, shape.names):
            if find_kind(word) or find_label(word):
                misfits.setdefault(
                    (shape.tag, word), f"{shape.where}: {word!r} is {_valid_tags(word)}, not a {shape.tag}; ignored"
                )
            elif word:
                spoken.append((shape.where, word))
    yield from spelling_notes(spoken, (*ROOM_LABELS, *KINDS))
    yield from misfits.values()
    by_reason: dict[str, list[SvgShape]] = {_NAMELESS: [], _UNSUITABLE: [], _UNCLEAR: []}
    for shape in ignored:
        by_reason[_why_ignored(shape)].append(shape)
    for reason, shapes in by_reason.items():
        if shapes:
            yield f"ignored, because {reason}: {listed(shapes, MAX_LISTED, shown=_located, separator='; ')}"


def _why_ignored(shape: SvgShape) -> str:
    """Return the reason why a shape is neither a room nor an opening, for a note on all shapes with this reason."""
    if _inherited(shape) is not None:
        return _UNCLEAR
    says = any(find_kind(text) or find_label(text) for text in shape.names)
    return _UNSUITABLE if says or any(_meaning(group) != (None, None) for group in shape.groups) else _NAMELESS


def _located(shape: SvgShape) -> str:
    """Return the place of a shape in the file, as text that also gives its first corner in the units of the drawing."""
    try:
        corner = outline_of(shape).corners[0]
    except SpecError:
        return shape.where
    return f"{shape.where} at ({corner.real:.6g}, {corner.imag:.6g})"


def _valid_tags(word: str) -> str:
    thing, tags = ("an opening", OPENING_TAGS) if find_kind(word) else ("a room", ROOM_TAGS)
    return f"{thing}: a {', '.join(tags[:-1])} or {tags[-1]}"
