"""What furniture and things are made of or covered with."""

import cv2
import numpy as np
from jaxtyping import Float32, Float64
from numpy.random import Generator

from worlds.patterns.surface import Planes, Shade, Surface, courses


def fabric(surface: Surface, rng: Generator) -> Planes:
    """Woven cloth: threads both ways and a few woven stripes."""
    threads = surface.noise(rng, 0.04, octaves=3, gain=1.0, stretch=4.0)
    threads += surface.transposed.noise(rng, 0.04, octaves=3, gain=1.0, stretch=4.0).T
    bands = courses(rng, surface, rng.uniform(0.06, 0.2), 50.0, vary=0.0)
    planes = bands.spread(rng, light=rng.choice([0.03, 0.1]), tint=rng.choice([0.0, 0.05]), joint=0.94)
    planes *= 1.0 + 0.08 * threads
    return planes


def metal(surface: Surface, rng: Generator) -> Shade:
    """Brushed metal: fine lines, soft reflections, a few smudges."""
    brushed = surface.noise(rng, 0.02, octaves=2, stretch=20.0)
    reflections = surface.noise(rng, 0.4, octaves=2, stretch=0.6)
    return 1.0 + 0.05 * brushed + 0.1 * reflections + 0.04 * surface.noise(rng, 0.08, octaves=3)


def ceramic(surface: Surface, rng: Generator) -> Shade:
    """Glaze: soft reflections and small flaws."""
    shade = 0.97 + 0.06 * surface.noise(rng, 0.25, octaves=4)
    for x, y in surface.scatter(rng, 12.0, most=40):
        cv2.circle(shade, (int(x), int(y)), max(1, int(rng.uniform(0.006, 0.02) * surface.px_per_m)), 0.78, -1)
    return shade


def glass(surface: Surface, rng: Generator) -> Shade:
    """A pane: slanted reflections over a gradient."""
    slope = np.linspace(1.15, 0.9, surface.height, dtype=np.float32)[:, None]
    shade = slope + 0.03 * surface.noise(rng, 0.2, octaves=4)
    for _ in range(4):
        x, lean, wide = (
            rng.uniform(-0.3, 1.0) * surface.width,
            0.4 * surface.width,
            rng.integers(1, max(2, surface.width // 10)),
        )
        cv2.line(shade, (int(x), surface.height), (int(x + lean), 0), rng.uniform(1.1, 1.35), int(wide), cv2.LINE_AA)
    return shade


def leaves(surface: Surface, rng: Generator) -> Planes:
    """Foliage: layers of leaves, the deep ones dark."""
    depth = np.round(2.2 * surface.noise(rng, 0.12, octaves=3, gain=0.9)) / 2.2
    edge = surface.noise(rng, 0.05, octaves=2)
    return np.stack([1.0 + 0.3 * depth + 0.12 * edge, 1.0 + 0.26 * depth + 0.08 * edge, 1.0 + 0.3 * depth])


def books(surface: Surface, rng: Generator) -> Planes:
    """Rows of spines of all colours, with titles."""
    upright = surface.transposed
    shelf_m = surface.height_m / max(1, round(surface.height_m / 0.3))
    spines = courses(rng, surface, shelf_m, 0.045, vary=0.5)
    planes = spines.spread(rng, light=0.22, tint=0.3, joint=0.15)
    planes *= 1.0 + 0.06 * surface.noise(rng, 0.05, octaves=2)
    titles = upright.noise(rng, 0.03, octaves=2, stretch=3.0).T
    planes += 0.55 * ((titles > 1.1) & (planes[0] > 0.3))
    np.maximum(planes, 0.08, out=planes)
    return planes


def picture(surface: Surface, rng: Generator) -> Planes:
    """A painting or poster: sky, ground and bold shapes."""
    height, width = surface.height, surface.width
    image = np.empty((height, width, 3), np.float32)
    horizon = int(height * rng.uniform(0.3, 0.8))
    image[:horizon], image[horizon:] = rng.uniform(0.35, 1.2, 3), rng.uniform(0.15, 0.9, 3)
    size = min(height, width)
    for _ in range(int(rng.integers(7, 13))):
        corner = rng.uniform(0.0, 1.0, 2) * (width, height)
        _shape(image, rng, corner, size * rng.uniform(0.06, 0.3), tuple(rng.uniform(0.05, 1.25, 3).tolist()))
    image *= (1.0 + 0.1 * surface.noise(rng, 0.1, octaves=4))[..., None]
    return np.ascontiguousarray(image.transpose(2, 0, 1))


def screen(surface: Surface, rng: Generator) -> Planes:
    """A lit display: windows, lines of text, a picture."""
    height, width = surface.height, surface.width
    planes = np.empty((3, height, width), np.float32)
    planes[:] = rng.uniform(0.3, 0.8, (3, 1, 1)) * (1.0 + 0.15 * surface.noise(rng, 0.2, octaves=4))
    for _ in range(3):
        x, y = (rng.uniform(0.0, 0.6, 2) * (width, height)).astype(int)
        window = planes[:, y : y + height // 2, x : x + width // 2]
        window[:] = rng.uniform(0.7, 2.2, (3, 1, 1))
        _text(window, rng)
    return planes


def keyboard(surface: Surface, rng: Generator) -> Planes:
    """Rows of keys or buttons."""
    row_m = min(surface.height_m / 2, max(0.02, 6.0 / surface.px_per_m))
    keys = courses(rng, surface, row_m, 1.1 * row_m, vary=0.3)
    planes = keys.spread(rng, light=0.2, tint=0.03, joint=0.25)
    planes += 0.5 * (surface.noise(rng, 0.4 * row_m, octaves=1) > 1.5)
    return planes


def food(surface: Surface, rng: Generator) -> Planes:
    """Shelves of packets, tins and bottles."""
    shelf_m = surface.height_m / max(1, round(surface.height_m / 0.28))
    planes = courses(rng, surface, shelf_m, 0.11, vary=0.5).spread(rng, light=0.2, tint=0.35, joint=0.2)
    for x, y in surface.scatter(rng, 120.0, most=60):
        _patch(planes, rng, (x, y), (0.05 * surface.px_per_m, 0.04 * surface.px_per_m))
    np.maximum(planes, 0.1, out=planes)
    return planes


def scribble(surface: Surface, rng: Generator) -> Planes:
    """A whiteboard or map: lines, boxes and notes in several colours."""
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


def label(surface: Surface, rng: Generator) -> Planes:
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


def _shape(
    image: Float32[np.ndarray, "height width 3"],
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


def _patch(planes: Planes, rng: Generator, at: tuple[float, float], half: tuple[float, float]) -> None:
    x, y = int(at[0]), int(at[1])
    dx, dy = int(half[0] * rng.uniform(0.3, 1.0)) + 1, int(half[1] * rng.uniform(0.3, 1.0)) + 1
    planes[:, max(0, y - dy) : y + dy, max(0, x - dx) : x + dx] = rng.uniform(0.1, 1.4, (3, 1, 1))
