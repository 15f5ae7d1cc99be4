"""Reads the element tree of an SVG, and lists its visible shapes with their groups, transforms and storeys.

Copies of shapes by `<use>` are listed, too. Document types are refused unless they only refer to SVG itself, because with
entities of its own a small file could expand without bound or read other files.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np
from jaxtyping import Float64

from worlds.errors import SpecError
from worlds.plan_import.svg_shapes import TAGS, Outline, length_px, outline, transform

LABEL = "inkscape:label"
_LINE = " line"
"""Key of an element's line number, which is stored among its attributes. No XML attribute has a space in its name, so this
key never clashes."""
_SHOWN_BY = " use"
"""Key of the id of the `<use>` that shows an element. It names the element in messages, and may give its storey."""
_NAMES = ("class", LABEL, "data-label", "data-kind", "data-name", "data-storey")
_HIDDEN = ("defs", "symbol", "clipPath", "mask", "pattern", "marker")
_STOREY = re.compile(r"(?:storey|story|floor|level)(?:[ _]+(?=-?\d)|[ _-]*(?=\d))(-?\d+)", re.IGNORECASE)
"""Matches the name of a layer, such as "Floor 1" or "floor-1", which are storey 1, and "Floor -1", which is below."""
_IS_VISIBLE = {"visible": True, "hidden": False, "collapse": False}
_WITH_COORDINATES = ("svg", "symbol")
"""Elements that have coordinates of their own if they have one of the attributes `_PLACEMENT`."""
_PLACEMENT = ("x", "y", "viewBox")
_MAX_DEPTH, _MAX_ELEMENTS = 100, 100_000
_TOO_MUCH = f"has elements nested deeper than {_MAX_DEPTH} or more than {_MAX_ELEMENTS}"


@dataclass(frozen=True, eq=False)
class Named:
    """An SVG element with the names that the drawing gives it."""

    tag: str
    attributes: Mapping[str, str]

    @property
    def where(self) -> str:
        """Place of the element in the file, for messages."""
        names = (self.attributes.get(key) for key in (LABEL, _SHOWN_BY, "id", "class"))
        name = next(filter(None, names), "")
        return f"<{self.tag}>" + (f" {name[:60]!r}" if name else "") + f" on line {self.attributes[_LINE]}"

    @property
    def names(self) -> tuple[str, ...]:
        """All texts that may say what the element is: the whole `class`, each single class, the Inkscape label, the id."""
        classes = self.attributes.get("class", "")
        return (classes, *classes.split(), self.attributes.get(LABEL, ""), self.attributes.get("id", ""))


@dataclass(frozen=True, eq=False)
class SvgShape(Named):
    """A visible shape of an SVG, with its storey and the groups around it."""

    T_svg_shape: Float64[np.ndarray, "3 3"]
    """Transform from the shape's coordinates to the drawing's coordinates."""
    storey: object
    """Storey as given in the file, not yet validated."""
    groups: tuple[Named, ...]
    """The groups around the shape, the innermost first."""


def outline_of(shape: SvgShape) -> Outline:
    """Return the corners of a shape in the units of the drawing.

    Raises `SpecError` as `svg_shapes.outline` does, and for a shape inside an element with coordinates of its own.
    """
    for group in shape.groups:
        if group.tag in _WITH_COORDINATES and any(name in group.attributes for name in _PLACEMENT):
            raise SpecError(
                f"{shape.where}: lies in {group.where}, which has x, y or viewBox; "
                "valid: a group (<g>) with a transform instead"
            )
    return outline(shape.where, shape.tag, shape.attributes, shape.T_svg_shape)


def read_tree(text: str) -> Element:
    """Return the root element of an SVG. Raises `SpecError` if `text` is not SVG, is too large or defines entities."""
    builder, parser, depth, elements = TreeBuilder(), expat.ParserCreate(), 0, 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth, elements
        depth, elements, tag = depth + 1, elements + 1, name.rpartition(":")[2]
        if elements == 1 and tag != "svg":
            raise SpecError(f"is not SVG: its outermost element is <{tag[:40]}>")
        if depth > _MAX_DEPTH or elements > _MAX_ELEMENTS:
            raise SpecError(_TOO_MUCH)
        builder.start(tag, {**attributes, _LINE: str(parser.CurrentLineNumber)})

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(name.rpartition(":")[2])

    parser.StartElementHandler, parser.EndElementHandler = start, end
    # Without declarations only the five entities of XML itself exist, so nothing can expand. No other file is ever read.
    parser.StartDoctypeDeclHandler, parser.EntityDeclHandler = _check_doctype, _refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise SpecError(f"is not SVG: {expat.ErrorString(error.code)} at line {error.lineno}") from None
    return builder.close()


def _check_doctype(_: str, system: str | None, public: str | None, has_internal_subset: int) -> None:
    """Raise `SpecError` for a document type with declarations, or of another file than the W3C's definition of SVG."""
    if has_internal_subset or not (public or "").startswith("-//W3C//DTD SVG"):
        _refuse()


def _refuse(*_: object) -> None:
    raise SpecError(
        "has a document type definition (<!DOCTYPE ...>), which could expand without bound; valid: none, or that of SVG by "
        "the W3C without further declarations"
    )


def shown_shapes(root: Element) -> Iterator[SvgShape]:
    """List the visible shapes in their order in the file. Raises `SpecError` for invalid transforms or too many elements."""
    by_id = {identifier: element for element in root.iter() if (identifier := element.get("id"))}
    return _Walk(by_id).below(root, _Inherited(visible=_is_visible(root.attrib, inherited=True)))


@dataclass(frozen=True, eq=False)
class _Inherited:
    """Properties that an element passes on to the elements inside it."""

    T_svg_here: Float64[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    storey: object = 0
    groups: tuple[Named, ...] = ()
    visible: bool = True
    """Whether the property `visibility` shows the elements inside. They can set this property again themselves."""


@dataclass
class _Walk:
    by_id: Mapping[str, Element]
    visited: int = 0

    def below(self, element: Element, around: _Inherited) -> Iterator[SvgShape]:
        for child in element:
            if child.tag not in _HIDDEN:
                yield from self.at(child, child.attrib, around)

    def at(self, element: Element, attributes: Mapping[str, str], around: _Inherited) -> Iterator[SvgShape]:
        """Yield the visible shapes inside an element; if the element is a shape itself, yield only this shape.

        `attributes` are the attributes of the element. If a `<use>` shows the element, names given on the `<use>` replace
        the names of the element, except for the id, because drawing programs give every `<use>` an id.
        """
        self.visited += 1
        if len(around.groups) > _MAX_DEPTH or self.visited > _MAX_ELEMENTS:
            raise SpecError(_TOO_MUCH)
        if _property(attributes, "display") == "none":
            return
        visible = _is_visible(attributes, around.visible)
        this = Named(str(element.tag), attributes)
        matrix = around.T_svg_here @ transform(this.where, attributes.get("transform", ""))
        storey = attributes.get("data-storey", _storey_of_group(this) or around.storey)
        if element.tag in TAGS:
            if visible:
                yield SvgShape(this.tag, attributes, matrix, storey, around.groups)
            return
        inside = _Inherited(matrix, storey, (this, *around.groups), visible)
        if element.tag != "use":
            yield from self.below(element, inside)
        elif (
            used := self.by_id.get(attributes.get("href", attributes.get("xlink:href", "")).removeprefix("#"))
        ) is not None:
            x, y = (length_px(this.where, name, attributes.get(name, "0")) for name in ("x", "y"))
            moved = replace(inside, T_svg_here=matrix @ np.array([[1, 0, x], [0, 1, y], [0, 0, 1]]))
            names = {key: value for key, value in attributes.items() if key in (*_NAMES, _LINE)}
            shown_by = attributes.get(_SHOWN_BY) or attributes.get("id", "")
            yield from self.at(used, {**used.attrib, **names, _SHOWN_BY: shown_by}, moved)


def _property(attributes: Mapping[str, str], name: str) -> str:
    """Return the value of a CSS property of an element, in lower case; "" if it is not set.

    A declaration in `style` takes precedence over the attribute with the name of the property.
    """
    value = attributes.get(name, "")
    for declaration in attributes.get("style", "").split(";"):
        key, _, text = declaration.partition(":")
        if key.strip().lower() == name:
            value = text
    return value.partition("!")[0].strip().lower()  # without "!important"


def _is_visible(attributes: Mapping[str, str], inherited: bool) -> bool:
    """Return whether the property `visibility` shows an element; an element that does not set it inherits the value."""
    return _IS_VISIBLE.get(_property(attributes, "visibility"), inherited)


def _storey_of_group(element: Named) -> str | None:
    """Return the storey number in the name of a group, as in "storey-1" or "Floor 1".

    The result is None if the name contains no storey number, or if the element is not a group.
    """
    names = (element.attributes.get(key, "") for key in (LABEL, _SHOWN_BY, "id"))
    numbers = (match[1] for name in names if (match := _STOREY.fullmatch(name.strip())))
    return next(numbers, None) if element.tag == "g" else None
