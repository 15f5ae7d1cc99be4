"""Patterns for floors, walls and ceilings, and for outdoor surfaces (brick, paving, grass)."""

import cv2
import numpy as np
from jaxtyping import Float64, Int32
from numpy.random import Generator

from worlds.visuals.patterns.texture_area import Planes, Shade, TextureArea, courses

_BLOSSOM_COLOURS = 6
_PETALS = 5


def bare(surface: TextureArea, rng: Generator) -> Shade:
    """Even paint with almost no texture: the shade changes slowly over metres."""
    return 0.98 + 0.012 * surface.noise(rng, 3.0, octaves=1)


def plain(surface: TextureArea, rng: Generator) -> Shade:
    """Paint with faint mottling and a few scuff marks."""
    shade = 0.97 + 0.085 * surface.noise(rng, 0.24, octaves=4, gain=1.0)
    _marks(shade, surface, rng, per_m2=7.0, length_m=0.07, strength=0.3)
    return shade


def plaster(surface: TextureArea, rng: Generator) -> Shade:
    """Rough plaster: trowel strokes and blotches."""
    strokes = surface.noise(rng, 0.14, octaves=4, gain=1.0, stretch=1.8)
    blotches = surface.noise(rng, 0.5, octaves=4)
    return 1.0 + 0.05 * blotches + 0.1 * np.tanh(1.6 * strokes)


def concrete(surface: TextureArea, rng: Generator) -> Shade:
    """Cast concrete: clouds, pores and cracks."""
    shade = 1.0 + 0.09 * surface.noise(rng, 0.6, octaves=6, gain=0.75)
    for x, y in surface.scatter(rng, 14.0):
        cv2.circle(shade, (int(x), int(y)), int(rng.integers(1, 3)), 0.68, -1)
    _marks(shade, surface, rng, per_m2=1.5, length_m=0.5, strength=0.25)
    return shade


def wood(surface: TextureArea, rng: Generator) -> Planes:
    """Wooden boards along the longer side of the surface, with grain and knots."""
    return _boards(surface, rng, width_m=0.14, length_m=1.6, tint=0.01, light=0.09, joint=0.66)


def parquet(surface: TextureArea, rng: Generator) -> Planes:
    """Parquet of short blocks that differ strongly in brightness."""
    return _boards(surface, rng, width_m=0.1, length_m=0.55, tint=0.012, light=0.15, joint=0.6)


def tile(surface: TextureArea, rng: Generator) -> Planes:
    """Square tiles in a grid. Each is glazed a little differently, and a few are decorated."""
    side = rng.uniform(0.15, 0.3)
    joint = rng.choice([0.62, 1.25])
    laid = courses(rng, surface, side, side, vary=0.0, aligned=True)
    planes = laid.spread(rng, light=0.08, tint=0.008, joint=joint)
    planes *= 1.0 + 0.045 * surface.noise(rng, 0.12, octaves=3)
    for x, y in surface.scatter(rng, 1.5, most=40):
        _blossom(planes, rng, (x, y), 0.3 * side * surface.px_per_m)
    return planes


def brick(surface: TextureArea, rng: Generator) -> Planes:
    """Brickwork in rows with uneven bricks."""
    laid = courses(rng, surface, 0.085, 0.24, vary=0.12)
    planes = laid.spread(rng, light=0.15, tint=0.012, joint=1.3)
    planes *= 1.0 + 0.12 * surface.noise(rng, 0.06, octaves=3, gain=0.9)
    return planes


def paving(surface: TextureArea, rng: Generator) -> Planes:
    """Paving slabs of uneven length with dark joints."""
    laid = courses(rng, surface, 0.4, 0.55, vary=0.35)
    planes = laid.spread(rng, light=0.12, tint=0.006, joint=0.55)
    planes *= 1.0 + 0.11 * surface.noise(rng, 0.2, octaves=5, gain=0.85)
    return planes


def carpet(surface: TextureArea, rng: Generator) -> Shade:
    """Carpet pile: strong fine noise over soft blotches."""
    return 1.0 + 0.14 * surface.noise(rng, 0.08, octaves=4, gain=1.0) + 0.05 * surface.noise(rng, 0.5, octaves=2)


def marble(surface: TextureArea, rng: Generator) -> Shade:
    """Marble with dark veins, which run where random noise changes its sign."""
    veins = np.abs(surface.noise(rng, 0.45, octaves=6, gain=0.62))
    shade: Shade = 1.05 - 0.4 * np.exp(-9.0 * veins) + 0.05 * surface.noise(rng, 0.3, octaves=4)
    return shade


def wallpaper(surface: TextureArea, rng: Generator) -> Planes:
    """Stripes of uneven width with scattered flowers in a few colours; no two flowers are alike."""
    stripes = courses(rng, TextureArea(1, surface.width, 1.0, surface.width_m), 50.0, rng.uniform(0.08, 0.25), vary=0.35)
    planes = stripes.spread(rng, light=0.05, tint=0.02, joint=0.93)
    planes = planes * (1.0 + 0.04 * surface.noise(rng, 0.2, octaves=4))
    blossoms = np.array(surface.scatter(rng, 9.0, most=150))
    colour_of = rng.integers(_BLOSSOM_COLOURS, size=len(blossoms))
    petals = _petals(blossoms, rng, surface.px_per_m)
    for i, colour in enumerate(rng.uniform(0.55, 1.15, (_BLOSSOM_COLOURS, 3)).tolist()):
        shapes = petals[colour_of == i].reshape(-1, *petals.shape[2:])
        for plane, value in zip(planes, colour, strict=True):
            cv2.fillPoly(plane, list(shapes), value)
    return planes


def grass(surface: TextureArea, rng: Generator) -> Planes:
    """Lawn with tufts, worn spots and daisies."""
    tufts = surface.noise(rng, 0.12, octaves=4, gain=0.9)
    worn = surface.noise(rng, 1.2, octaves=4)
    planes = np.stack([1.0 + 0.22 * tufts + 0.22 * worn, 1.0 + 0.2 * tufts + 0.08 * worn, 1.0 + 0.2 * tufts])
    for x, y in surface.scatter(rng, 5.0):
        for plane in planes:
            cv2.circle(plane, (int(x), int(y)), max(1, int(0.02 * surface.px_per_m)), 2.2, -1)
    return planes


def _boards(
    surface: TextureArea, rng: Generator, width_m: float, length_m: float, tint: float, light: float, joint: float
) -> Planes:
    upright = surface.height_m > surface.width_m
    lying = surface.transposed if upright else surface
    planes = courses(rng, lying, width_m, length_m, vary=0.35).spread(rng, light=light, tint=tint, joint=joint)
    grain = lying.noise(rng, 0.05, octaves=4, gain=0.8, stretch=9.0)
    shade = 1.0 + 0.11 * grain
    for x, y in lying.scatter(rng, 4.0):
        radius = rng.uniform(0.008, 0.025) * lying.px_per_m
        cv2.ellipse(shade, (int(x), int(y)), (int(2.2 * radius) + 1, int(radius) + 1), 0.0, 0.0, 360.0, 0.62, -1)
    planes *= shade
    return np.ascontiguousarray(planes.transpose(0, 2, 1)) if upright else planes


def _marks(shade: Shade, surface: TextureArea, rng: Generator, per_m2: float, length_m: float, strength: float) -> None:
    for x, y in surface.scatter(rng, per_m2, most=80):
        dx, dy = rng.normal(0.0, length_m * surface.px_per_m, 2)
        cv2.line(shade, (int(x), int(y)), (int(x + dx), int(y + dy)), 1.0 - strength * rng.uniform(0.4, 1.0), 1, cv2.LINE_AA)


def _blossom(planes: Planes, rng: Generator, at: tuple[float, float], radius: float) -> None:
    axes = (int(radius * rng.uniform(0.5, 1.0)) + 1, int(radius * rng.uniform(0.2, 0.6)) + 1)
    turn = rng.uniform(0.0, 180.0)
    for plane, value in zip(planes, rng.uniform(0.55, 1.15, 3), strict=True):
        for petal in (0.0, 65.0):
            cv2.ellipse(plane, (int(at[0]), int(at[1])), axes, turn + petal, 0.0, 360.0, value, -1)


def _petals(centres: Float64[np.ndarray, "n 2"], rng: Generator, px_per_m: float) -> Int32[np.ndarray, "n petals corners 2"]:
    """Return the outlines [px] of the petals of flowers at `centres` [px].

    The flowers are 6 to 14 cm wide. Their sizes and rotations are random.
    """
    radius = rng.uniform(0.03, 0.07, (len(centres), 1, 1, 1)) * px_per_m
    turn = rng.uniform(0.0, 2 * np.pi, (len(centres), 1)) + 2 * np.pi / _PETALS * np.arange(_PETALS)
    around = np.linspace(0.0, 2 * np.pi, 9)[:-1]
    ellipse = np.column_stack([0.5 + 0.5 * np.cos(around), rng.uniform(0.15, 0.3) * np.sin(around)])
    cos, sin = np.cos(turn)[..., None], np.sin(turn)[..., None]
    turned = np.stack([cos * ellipse[:, 0] - sin * ellipse[:, 1], sin * ellipse[:, 0] + cos * ellipse[:, 1]], axis=-1)
    return np.rint(centres[:, None, None] + radius * turned).astype(np.int32)
