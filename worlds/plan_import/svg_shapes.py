"""The geometry of SVG shapes: corners of straight shapes, lengths with units, and transforms.

The package svgpathtools parses the syntax of paths and transforms.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float64
from svgpathtools import Line, parse_path, parse_transform

from worlds.errors import SpecError

ROOM_TAGS = ("rect", "polygon", "polyline", "path")
OPENING_TAGS = ("line", "polyline", "path")
TAGS = (*ROOM_TAGS, "line")
PX_PER_UNIT = {"": 1.0, "px": 1.0, "in": 96.0, "mm": 96.0 / 25.4, "cm": 96.0 / 2.54, "pt": 96.0 / 72.0, "pc": 16.0}
"""CSS pixels in each unit of length; an inch has 96 pixels."""
_LENGTH = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z]*)")
_CURVES = frozenset("CcSsQqTtAa")
_MAX_POINTS = 1000


@dataclass(frozen=True, eq=False)
class Outline:
    """The corners of a shape in the units of the drawing, with x to the right and y down."""

    corners: Complex[np.ndarray, "n"]
    """Corners as complex numbers x + iy; the first corner is not repeated at the end."""
    closed: bool


def outline(where: str, tag: str, attributes: Mapping[str, str], T_svg_shape: Float64[np.ndarray, "3 3"]) -> Outline:
    """Return the corners of a shape made of straight lines, in the units of the drawing.

    `where` is the place of the shape in the file, for messages. Raises `SpecError` if the shape has curves, more than one
    part or too few or too many corners, or if its coordinates cannot be read.
    """
    text = _path_data(where, tag, attributes).strip()
    if len(re.findall("[Mm]", text)) > 1:
        raise SpecError(f"{where}: its path has more than one part; valid: one shape for each room or opening")
    try:
        segments = list(parse_path(text)) if text[:1] in ("M", "m") else []
    except (ValueError, AssertionError):
        raise SpecError(f"{where}: its coordinates cannot be read; valid: as in 'M 0 0 H 4 V 3 H 0 Z'") from None
    if curve := next((segment for segment in segments if not isinstance(segment, Line)), None):
        raise SpecError(
            f"{where}: its path has a curve ({type(curve).__name__}); valid: straight lines (M, L, H, V, Z), "
            "for a door the line along its wall"
        )
    points = np.array([*(line.start for line in segments), *(line.end for line in segments[-1:])], np.complex128)
    if not 2 <= len(points) <= _MAX_POINTS:
        raise SpecError(f"{where}: has {len(points)} corners; valid: 2 to {_MAX_POINTS}")
    closed = bool(points[0] == points[-1])
    x, y, _ = T_svg_shape @ np.stack([points.real, points.imag, np.ones(len(points))])
    return Outline((x + 1j * y)[: len(points) - closed], closed)


def _path_data(where: str, tag: str, attributes: Mapping[str, str]) -> str:
    def length(name: str) -> float:
        return length_px(where, name, attributes.get(name, "0"))

    match tag:
        case "rect":
            return f"M{length('x')} {length('y')}h{length('width')}v{length('height')}h{-length('width')}z"
        case "line":
            return f"M{length('x1')} {length('y1')}L{length('x2')} {length('y2')}"
        case "path":
            return attributes.get("d", "")
    return f"M{attributes.get('points', '')}{'z' if tag == 'polygon' else ''}"


def is_curved(attributes: Mapping[str, str]) -> bool:
    """Whether a path contains a command for a curve."""
    return not _CURVES.isdisjoint(attributes.get("d", ""))


def length_px(where: str, name: str, text: str) -> float:
    """Convert a length to CSS pixels, the units of a drawing without a viewBox. Raises `SpecError` for an invalid length."""
    match = _LENGTH.fullmatch(text.strip())
    if match is None or match[2] not in PX_PER_UNIT:
        units = ", ".join(filter(None, PX_PER_UNIT))
        raise SpecError(f"{where}: {name} is {text[:40]!r}; valid: a number, alone or with a unit ({units})")
    return float(match[1]) * PX_PER_UNIT[match[2]]


def transform(where: str, text: str) -> Float64[np.ndarray, "3 3"]:
    """Return the matrix of a `transform` attribute. Raises `SpecError` if the attribute cannot be read."""
    try:
        return np.asarray(parse_transform(text, strict=True), np.float64)
    except ValueError:
        raise SpecError(
            f"{where}: has the transform {text[:60]!r}; valid: matrix, translate, scale, rotate, skewX, skewY"
        ) from None
