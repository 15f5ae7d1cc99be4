"""Shapes from which furniture is built. Intervals and lengths are in metres, in the frame of the piece of furniture."""

from dataclasses import replace

from numpy.random import Generator

from worlds.furniture.kinds import Parts, Range, Size
from worlds.parts import Colour, Part, Shape


def box(x: Range, y: Range, z: Range, colour: Colour, material: str = "plain") -> Part:
    """Return a box that extends over the intervals `x`, `y` and `z`."""
    return _spanning("box", x, y, z, colour, material)


def cylinder(x: Range, y: Range, z: Range, colour: Colour, material: str = "plain") -> Part:
    """Return an upright cylinder within the intervals; its base is an ellipse if `x` and `y` differ in length."""
    return _spanning("cylinder", x, y, z, colour, material)


def cone(x: Range, y: Range, z: Range, colour: Colour, material: str = "plain") -> Part:
    """Return an upright cone, tip up, within the intervals; its base is an ellipse if `x` and `y` differ in length."""
    return _spanning("cone", x, y, z, colour, material)


def ball(x: Range, y: Range, z: Range, colour: Colour, material: str = "plain") -> Part:
    """Return an ellipsoid that extends over the intervals `x`, `y` and `z`."""
    return _spanning("ball", x, y, z, colour, material)


def moved(part: Part, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Part:
    """Return the part, moved by (x, y, z) [m]."""
    return replace(part, centre=(part.centre[0] + x, part.centre[1] + y, part.centre[2] + z))


def about(centre: float, length: float) -> Range:
    """Return the interval of `length` with its middle at `centre`."""
    return centre - length / 2, centre + length / 2


def inset(interval: Range, by: float) -> Range:
    """Return the interval, shortened by `by` at both ends."""
    return interval[0] + by, interval[1] - by


def ends(interval: Range, depth: float, margin: float = 0.0) -> tuple[Range, Range]:
    """Return the two parts of the interval within `depth` of its lower and its upper end, without the outer `margin`."""
    low, high = interval
    return (low + margin, low + depth), (high - depth, high - margin)


def split(interval: Range, count: int, gap: float = 0.0) -> list[Range]:
    """Return the interval divided into `count` equal pieces with gaps of `gap` between them."""
    step = (interval[1] - interval[0] + gap) / count
    return [(interval[0] + i * step, interval[0] + (i + 1) * step - gap) for i in range(count)]


def spaced(low: float, high: float, count: int) -> list[float]:
    """Return `count` evenly spaced numbers from `low` to `high`; at least 2."""
    return [low + i * (high - low) / (count - 1) for i in range(count)]


def octagon(
    u: float, v: float, diameter: float, narrow: float = 0.42, diagonal: float = 0.8
) -> tuple[tuple[Range, Range], ...]:
    """Return three rectangles that together look like a disc, each as its intervals along two axes, u and v.

    Wheels are built from them, because all cylinders stand upright. The disc has its centre at (`u`, `v`). Two of the
    rectangles are as long as the `diameter`, and `narrow` times as wide; the third is a square with sides of `diagonal`
    times the diameter.
    """
    shares = (1.0, narrow), (narrow, 1.0), (diagonal, diagonal)
    return tuple((about(u, diameter * along_u), about(v, diameter * along_v)) for along_u, along_v in shares)


def legs(s: Size, top: float, thickness: float, colour: Colour, material: str = "wood", margin: float = 0.02) -> Parts:
    """Return four legs near the corners, from the floor up to the height `top`."""
    x, y = inset(s.x, margin), inset(s.y, margin)
    return tuple(box(i, j, (0.0, top), colour, material) for i in ends(x, thickness) for j in ends(y, thickness))


def fronts(
    x: Range, z: Range, at: float, columns: int, rows: int, colour: Colour, handle: Colour, material: str = "wood"
) -> Parts:
    """Return a grid of door and drawer fronts that face +y; with their handles, they fill the last 2 cm before y = `at`.

    Fronts that are higher than wide are doors, with an upright handle near the edge of larger x. All others are drawers,
    with a level handle near the top.
    """
    parts: list[Part] = []
    for left, right in split(inset(x, 0.01), columns, 0.012):
        for low, high in split(inset(z, 0.01), rows, 0.012):
            parts.append(box((left, right), (at - 0.02, at - 0.005), (low, high), colour, material))
            width, height = right - left, high - low
            if height > width:
                grip = about(right - 0.05, 0.015), about((low + high) / 2, min(0.2, height / 3))
            else:
                grip = about((left + right) / 2, min(0.16, width / 3)), about(high - 0.05, 0.015)
            parts.append(box(grip[0], (at - 0.006, at), grip[1], handle))
    return tuple(parts)


def shelf_unit(s: Size, shelves: int, colour: Colour, material: str = "wood", board: float = 0.03) -> Parts:
    """Return the boards of a shelf: two sides, a back, and boards that form `shelves` compartments, open to the front."""
    sides = [box(x, s.y, s.z, colour, material) for x in ends(s.x, board)]
    back = box(s.x, (s.back, s.back + 0.015), s.z, colour, material)
    levels = [i * (s.height - board) / shelves for i in range(shelves + 1)]
    return (*sides, back, *(box(inset(s.x, board), s.y, (z, z + board), colour, material) for z in levels))


def stocked(
    s: Size, shelves: int, goods: tuple[str, ...], colour: Colour, rng: Generator, board: float = 0.03, fill: float = 0.8
) -> Parts:
    """Return goods for the shelves of a `shelf_unit` of this size: blocks with a material drawn from `goods`.

    Each shelf has a place for one block about every half metre; each place gets a block with the probability `fill`.
    """
    parts: list[Part] = []
    step = (s.height - board) / shelves
    for level in range(shelves):
        for x in split(inset(s.x, board + 0.01), max(1, round(s.width / 0.5)), 0.02):
            low = level * step + board
            length = (x[1] - x[0]) * rng.uniform(0.55, 1.0)
            high = low + (step - board) * rng.uniform(0.55, 0.92)
            if rng.random() < fill:
                material = goods[int(rng.integers(len(goods)))]
                y = s.back + 0.02, s.front - rng.uniform(0.02, 0.08)
                parts.append(box((x[0], x[0] + length), y, (low, high), colour, material))
    return tuple(parts)


def _spanning(shape: Shape, x: Range, y: Range, z: Range, colour: Colour, material: str) -> Part:
    centre = (x[0] + x[1]) / 2, (y[0] + y[1]) / 2, (z[0] + z[1]) / 2
    return Part(shape, centre, (x[1] - x[0], y[1] - y[0], z[1] - z[0]), colour, material)
