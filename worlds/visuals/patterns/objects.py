"""Patterns for furniture and small objects: materials, and motifs such as pictures and screens."""

import math

import cv2
import numpy as np
from jaxtyping import Float32, Float64
from numpy.random import Generator

from worlds.visuals.patterns.texture_area import Planes, Shade, TextureArea, courses


def fabric(surface: TextureArea, rng: Generator) -> Planes:
    """Woven cloth with stripes; its threads run in both directions."""
    threads = surface.noise(rng, 0.04, octaves=3, gain=1.0, stretch=4.0)
    threads += surface.transposed.noise(rng, 0.04, octaves=3, gain=1.0, stretch=4.0).T
    bands = courses(rng, surface, rng.uniform(0.06, 0.2), 50.0, vary=0.0)
    planes = bands.spread(rng, light=rng.choice([0.03, 0.1]), tint=rng.choice([0.0, 0.05]), joint=0.94)
    planes *= 1.0 + 0.08 * threads
    return planes


def metal(surface: TextureArea, rng: Generator) -> Shade:
    """Brushed metal: fine lines, soft reflections, a few smudges."""
    brushed = surface.noise(rng, 0.02, octaves=2, stretch=20.0)
    reflections = surface.noise(rng, 0.4, octaves=2, stretch=0.6)
    return 1.0 + 0.05 * brushed + 0.1 * reflections + 0.04 * surface.noise(rng, 0.08, octaves=3)


def ceramic(surface: TextureArea, rng: Generator) -> Shade:
    """Glazed ceramic with soft reflections and small flaws."""
    shade = 0.97 + 0.06 * surface.noise(rng, 0.25, octaves=4)
    for x, y in surface.scatter(rng, 12.0, most=40):
        cv2.circle(shade, (int(x), int(y)), max(1, int(rng.uniform(0.006, 0.02) * surface.px_per_m)), 0.78, -1)
    return shade


def glass(surface: TextureArea, rng: Generator) -> Shade:
    """A window pane: slanted reflections over a gradient."""
    slope = np.linspace(1.15, 0.9, surface.height, dtype=np.float32)[:, None]
    shade = slope + 0.03 * surface.noise(rng, 0.2, octaves=4)
    for _ in range(4):
        x, lean = rng.uniform(-0.3, 1.0) * surface.width, 0.4 * surface.width
        wide = rng.integers(1, max(2, surface.width // 10))
        cv2.line(shade, (int(x), surface.height), (int(x + lean), 0), rng.uniform(1.1, 1.35), int(wide), cv2.LINE_AA)
    return shade


def leaves(surface: TextureArea, rng: Generator) -> Planes:
    """Foliage in layers; the deeper leaves are darker."""
    depth = np.round(2.2 * surface.noise(rng, 0.12, octaves=3, gain=0.9)) / 2.2
    edge = surface.noise(rng, 0.05, octaves=2)
    return np.stack([1.0 + 0.3 * depth + 0.12 * edge, 1.0 + 0.26 * depth + 0.08 * edge, 1.0 + 0.3 * depth])


def books(surface: TextureArea, rng: Generator) -> Planes:
    """Rows of book spines of all colours, with titles."""
    shelf_m = surface.height_m / max(1, round(surface.height_m / 0.3))
    planes = courses(rng, surface, shelf_m, 0.045, vary=0.5).spread(rng, light=0.22, tint=0.3, joint=0.15)
    printed = surface.transposed.noise(rng, 0.03, octaves=2, stretch=3.0).T > 1.1
    titles = np.where(printed & (planes[0] > 0.3), np.float32(0.55), np.float32(0.0))
    worn = 1.0 + 0.06 * surface.noise(rng, 0.05, octaves=1)
    for plane in planes:
        plane *= worn
        plane += titles
        np.maximum(plane, 0.08, out=plane)
    return planes


def picture(surface: TextureArea, rng: Generator) -> Planes:
    """A painting or a poster with a landscape, a portrait or bold shapes; some pictures have a title."""
    height, width = surface.height, surface.width
    image = np.empty((height, width, 3), np.float32)
    horizon = int(height * rng.uniform(0.3, 0.8))
    image[:horizon], image[horizon:] = rng.uniform(0.35, 1.2, 3), rng.uniform(0.15, 0.9, 3)
    paint = (_landscape, _portrait, _shapes)[int(rng.choice(3, p=(0.3, 0.2, 0.5)))]
    paint(image, rng)
    if rng.random() < 0.3:
        _title(image, rng)
    image *= (1.0 + 0.1 * surface.noise(rng, 0.1, octaves=4))[..., None]
    return np.ascontiguousarray(image.transpose(2, 0, 1))


def screen(surface: TextureArea, rng: Generator) -> Planes:
    """A lit display with windows and lines of text."""
    height, width = surface.height, surface.width
    planes = np.empty((3, height, width), np.float32)
    planes[:] = rng.uniform(0.3, 0.8, (3, 1, 1)) * (1.0 + 0.15 * surface.noise(rng, 0.2, octaves=4))
    for _ in range(3):
        x, y = (rng.uniform(0.0, 0.6, 2) * (width, height)).astype(int)
        window = planes[:, y : y + height // 2, x : x + width // 2]
        window[:] = rng.uniform(0.7, 2.2, (3, 1, 1))
        _text(window, rng)
    return planes


def keyboard(surface: TextureArea, rng: Generator) -> Planes:
    """Rows of keys or buttons."""
    row_m = min(surface.height_m / 2, max(0.02, 6.0 / surface.px_per_m))
    keys = courses(rng, surface, row_m, 1.1 * row_m, vary=0.3)
    planes = keys.spread(rng, light=0.2, tint=0.03, joint=0.25)
    planes += 0.5 * (surface.noise(rng, 0.4 * row_m, octaves=1) > 1.5)
    return planes


def food(surface: TextureArea, rng: Generator) -> Planes:
    """Shelves of jars, bottles and packets of all heights, with lids and labels, in front of a dark background."""
    image = np.full((surface.height, surface.width, 3), 0.22, np.float32)
    shelves, scale = max(1, round(surface.height_m / 0.28)), surface.px_per_m
    for shelf in range(shelves):
        floor, room = surface.height * (shelf + 1) // shelves, surface.height // shelves
        board = max(1, room // 14)
        image[max(0, floor - board) : floor] = (0.75, 0.6, 0.42)
        widths = rng.uniform(0.05, 0.12, math.ceil(surface.width_m / 0.05)) * scale
        lefts = np.cumsum(widths) - widths[0] * (1.0 + rng.random())
        heights, colours = rng.uniform(0.4, 0.85, len(widths)) * room, rng.uniform(0.05, 1.25, (len(widths), 2, 3))
        kinds, seen = rng.integers(3, size=len(widths)), lefts < surface.width
        packets = zip(
            lefts[seen].tolist(), widths.tolist(), heights.tolist(), kinds.tolist(), colours.tolist(), strict=False
        )
        for left, width, height, kind, (body, paper) in packets:
            _packet(image, (left, floor - board), (0.9 * width, height), kind, tuple(body), tuple(paper))
    image *= (1.0 + 0.05 * surface.noise(rng, 0.05, octaves=2))[..., None]
    return np.ascontiguousarray(image.transpose(2, 0, 1))


def scribble(surface: TextureArea, rng: Generator) -> Planes:
    """Writing and drawings, as on a whiteboard: crooked lines in four colours."""
    planes = np.empty((3, surface.height, surface.width), np.float32)
    planes[:] = 1.0 + 0.02 * surface.noise(rng, 0.2, octaves=3)
    for x, y in surface.scatter(rng, 22.0, most=40):
        ink = rng.choice([(0.2, 0.25, 0.9), (0.9, 0.2, 0.2), (0.15, 0.15, 0.15), (0.15, 0.6, 0.25)])
        walk = np.cumsum(rng.normal(0.0, 0.05 * surface.px_per_m, (6, 2)), axis=0) + np.array([x, y])
        for plane, value in zip(planes, ink.tolist(), strict=True):
            cv2.polylines(
                plane, [walk.astype(np.int32)], bool(ink[0] < 0.2), value, max(1, surface.height // 90), cv2.LINE_AA
            )
    return planes


def label(surface: TextureArea, rng: Generator) -> Planes:
    """Cardboard with tape and printed labels."""
    planes = np.empty((3, surface.height, surface.width), np.float32)
    planes[:] = 1.0 + 0.05 * surface.noise(rng, 0.08, octaves=4)
    middle, half = surface.height // 2, max(1, surface.height // 16)
    planes[:, middle - half : middle + half] *= 1.22
    for x, y in surface.scatter(rng, 14.0, most=6):
        window = planes[:, int(y) : int(y) + surface.height // 4, int(x) : int(x) + surface.width // 3]
        window[:] = rng.uniform(1.1, 1.6, (3, 1, 1))
        _text(window, rng)
    return planes


_Image = Float32[np.ndarray, "height width 3"]


def _shapes(image: _Image, rng: Generator) -> None:
    height, width, _ = image.shape
    for _ in range(int(rng.integers(7, 13))):
        at, size = rng.uniform(0.0, 1.0, 2) * (width, height), min(height, width) * rng.uniform(0.06, 0.3)
        _shape(image, rng, at, size, _hue(rng))


def _landscape(image: _Image, rng: Generator) -> None:
    """Paint a sun, then ranges of hills; the near hills are low and dark."""
    height, width, _ = image.shape
    cv2.circle(
        image, _spot(rng, image, 0.1, 0.4), int(0.09 * height) + 1, (1.25, 1.1, rng.uniform(0.4, 1.0)), -1, cv2.LINE_AA
    )
    tint = rng.uniform(0.4, 1.0, 3)
    for depth in (0.35, 0.55, 0.75):
        ridge = height * (depth + np.cumsum(rng.normal(0.0, 0.05, 9)))
        outline = np.column_stack([np.linspace(0, width, 9), ridge])
        outline = np.vstack([outline, [(width, height), (0, height)]])
        cv2.fillPoly(image, [outline.astype(np.int32)], tuple((tint * (1.1 - depth)).tolist()), cv2.LINE_AA)


def _portrait(image: _Image, rng: Generator) -> None:
    """Paint head, hair and shoulders in front of the background."""
    height, width, _ = image.shape
    x, y, size = width // 2, int(0.42 * height), 0.17 * min(height, width)
    head = (int(0.75 * size) + 1, int(size) + 1)
    skin = tuple((np.array([0.95, 0.72, 0.58]) * rng.uniform(0.5, 1.1)).tolist())
    cv2.ellipse(image, (x, height), (int(2.2 * size), int(0.42 * height)), 0.0, 180.0, 360.0, _hue(rng), -1, cv2.LINE_AA)
    cv2.ellipse(image, (x, y - head[1] // 4), (head[0] + head[0] // 4, head[1]), 0.0, 0.0, 360.0, _hue(rng), -1, cv2.LINE_AA)
    cv2.ellipse(image, (x, y), head, 0.0, 0.0, 360.0, skin, -1, cv2.LINE_AA)
    for side in (-1, 1):
        cv2.circle(image, (x + side * head[0] // 2, y), max(1, head[0] // 7), (0.1, 0.1, 0.1), -1)


def _title(image: _Image, rng: Generator) -> None:
    """Paint a strip with blocks that look like letters."""
    height, width, _ = image.shape
    low, high = (0.04, 0.16) if rng.random() < 0.5 else (0.82, 0.94)
    image[int(low * height) : int(high * height) + 1] = _hue(rng)
    letters = np.repeat(rng.random(width // 4 + 1) < 0.65, 4)[:width] & (np.arange(width) % 4 > 0)
    image[int((low + 0.03) * height) : int((high - 0.03) * height) + 1, letters] = rng.choice([0.08, 1.2])


def _hue(rng: Generator) -> tuple[float, ...]:
    return tuple(rng.uniform(0.05, 1.25, 3).tolist())


def _spot(rng: Generator, image: _Image, low: float, high: float) -> tuple[int, int]:
    height, width, _ = image.shape
    return int(width * rng.uniform(0.15, 0.85)), int(height * rng.uniform(low, high))


def _shape(
    image: _Image,
    rng: Generator,
    at: Float64[np.ndarray, "2"],
    size: float,
    colour: tuple[float, ...],
) -> None:
    if rng.random() < 0.5:
        axes = (int(size) + 1, int(size * rng.uniform(0.3, 1.0)) + 1)
        cv2.ellipse(image, at.astype(int).tolist(), axes, rng.uniform(0.0, 180.0), 0.0, 360.0, colour, -1, cv2.LINE_AA)
    else:
        corners = at + rng.normal(0.0, size, (int(rng.integers(3, 6)), 2))
        cv2.fillConvexPoly(image, cv2.convexHull(corners.astype(np.int32)), colour, cv2.LINE_AA)


def _text(window: Planes, rng: Generator) -> None:
    width = window.shape[2]
    lines = window[:, 2::4]
    words = rng.random((lines.shape[1], width // 3 + 1)) < 0.6
    lines *= np.where(np.repeat(words, 3, axis=1)[:, :width], 0.25, 1.0)


_LIDS = ((0.0, 0.0), (0.1, 0.85), (0.32, 0.7))
"""Lids of packets, jars and bottles, in this order. The first number says by how much the lid is narrower on either side, as
a share of the width. The second is the height at which the lid begins, as a share of the whole height; 0 means no lid."""


def _packet(
    image: _Image,
    foot: tuple[float, int],
    size: tuple[float, float],
    kind: int,
    body: tuple[float, ...],
    paper: tuple[float, ...],
) -> None:
    """Paint a packet, jar or bottle with a label; its `kind` is an index into `_LIDS`.

    `size` is (width, height) [px], and `foot` the lower left corner (x, y) [px]. `body` is the colour of the packet, `paper`
    the colour of its label.
    """
    (left, bottom), (width, height), (inset, lid) = foot, size, _LIDS[kind]

    def band(low: float, high: float, inset: float, colour: tuple[float, ...]) -> None:
        x = int(left + inset * width), int(left + (1.0 - inset) * width)
        cv2.rectangle(image, (x[0], int(bottom - high * height)), (x[1], int(bottom - low * height)), colour, -1)

    band(0.0, lid or 1.0, 0.0, body)
    band(0.25, 0.6, 0.15 if kind == 0 else 0.0, paper)
    if lid:
        band(lid, 1.0, inset, (0.8, 0.82, 0.84) if body[0] < 0.8 else (0.85, 0.2, 0.15))
