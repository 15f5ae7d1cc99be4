"""The geometry of SVG: the points of straight shapes, and transforms."""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from worlds.errors import SpecError
from worlds.spec import Point

Affine = Callable[[Point], Point]
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_TRANSFORM = re.compile(r"(\w+)\s*\(([^()]*)\)")
_COMMAND = re.compile(r"([A-Za-z])([^A-Za-df-z]*)")
_MAX_POINTS = 1000


@dataclass(frozen=True)
class Shape:
    """The corners of a shape in its own coordinates."""

    points: tuple[Point, ...]
    closed: bool


def outline(where: str, tag: str, attributes: dict[str, str]) -> Shape:
    """The corners of a `rect`, `polygon`, `polyline`, `line` or straight `path`. Raises `SpecError`."""
    if tag == "rect":
        x, y, width, height = (_length(where, attributes, name) for name in ("x", "y", "width", "height"))
        shape = Shape(((x, y), (x + width, y), (x + width, y + height), (x, y + height)), True)
    elif tag == "line":
        x1, y1, x2, y2 = (_length(where, attributes, name) for name in ("x1", "y1", "x2", "y2"))
        shape = Shape(((x1, y1), (x2, y2)), False)
    elif tag == "path":
        shape = _path(where, attributes.get("d", ""))
    else:
        numbers = _numbers(attributes.get("points", ""))
        shape = Shape(tuple(zip(numbers[::2], numbers[1::2], strict=False)), tag == "polygon")
    if not 2 <= len(shape.points) <= _MAX_POINTS:
        raise SpecError(f"{where}: has {len(shape.points)} corners; valid: 2 to {_MAX_POINTS}")
    return shape


def _length(where: str, attributes: dict[str, str], name: str) -> float:
    text = attributes.get(name, "0").strip().removesuffix("px")
    if not _NUMBER.fullmatch(text):
        raise SpecError(f"{where}: {name} is {text[:40]!r}; valid: a number without a unit")
    return float(text)


def _numbers(text: str) -> list[float]:
    return [float(number) for number in _NUMBER.findall(text)]


def _path(where: str, text: str) -> Shape:
    points: list[Point] = []
    closed = False
    for command, rest in _COMMAND.findall(text.replace("E", "e")):
        if closed:
            raise SpecError(f"{where}: its path has more than one part; draw one shape for each room or opening")
        if command in "Zz":
            closed = True
        elif command in "MmLlHhVv":
            if command in "Mm" and points:
                raise SpecError(f"{where}: its path has more than one part; draw one shape for each room or opening")
            points += _steps(command, _numbers(rest), points[-1] if points else (0.0, 0.0))
        else:
            raise SpecError(f"{where}: its path has a curve ({command}); valid: straight lines (M, L, H, V, Z)")
    return Shape(tuple(points), closed)


def _steps(command: str, numbers: list[float], start: Point) -> Iterator[Point]:
    (x, y), relative = start, command.islower()
    steps: list[tuple[float | None, float | None]]
    if command in "HhVv":
        steps = [(number, None) if command in "Hh" else (None, number) for number in numbers]
    else:
        steps = list(zip(numbers[::2], numbers[1::2], strict=False))
    for dx, dy in steps:
        x = x if dx is None else x + dx if relative else dx
        y = y if dy is None else y + dy if relative else dy
        yield x, y


def IDENTITY(point: Point) -> Point:
    """The transform that changes nothing."""
    return point


def compose(outer: Affine, inner: Affine) -> Affine:
    """First `inner`, then `outer`."""
    if inner is IDENTITY:
        return outer
    return inner if outer is IDENTITY else lambda point: outer(inner(point))


def affine(text: str) -> Affine:
    """What a `transform` attribute does. Raises `SpecError` for one that it does not know."""
    whole: Affine = IDENTITY
    for name, arguments in _TRANSFORM.findall(text):
        whole = compose(whole, _one(name, _numbers(arguments)))
    return whole


def _one(name: str, n: list[float]) -> Affine:
    match name, len(n):
        case "translate", 1 | 2:
            return _matrix(1.0, 0.0, 0.0, 1.0, n[0], n[1] if len(n) > 1 else 0.0)
        case "scale", 1 | 2:
            return _matrix(n[0], 0.0, 0.0, n[-1], 0.0, 0.0)
        case "rotate", 1 | 3:
            cos, sin = math.cos(math.radians(n[0])), math.sin(math.radians(n[0]))
            x, y = (n[1], n[2]) if len(n) > 1 else (0.0, 0.0)
            return _matrix(cos, sin, -sin, cos, x - cos * x + sin * y, y - sin * x - cos * y)
        case "matrix", 6:
            return _matrix(*n)
    raise SpecError(f"has a transform {name[:40]}(...) of {len(n)} numbers; valid: translate, scale, rotate, matrix")


def _matrix(a: float, b: float, c: float, d: float, e: float, f: float) -> Affine:
    return lambda p: (a * p[0] + c * p[1] + e, b * p[0] + d * p[1] + f)
