"""Procedural textures: `texture` paints a named pattern over a surface of a given size, differently for every random seed.

A texture is the shade of a pattern times a colour. Patterns have details at all scales from two pixels to half a metre,
because the distance of the camera decides at which scale the SLAM finds its features. Textures do not repeat, because a
repeating wall causes loop closures that are wrong by exactly one period.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import cv2
import numpy as np
from jaxtyping import UInt8
from numpy.random import Generator

from worlds.errors import WorldsError
from worlds.parts import Colour
from worlds.visuals.patterns import building, objects
from worlds.visuals.patterns.texture_area import Planes, Shade, TextureArea

Pattern = Callable[[TextureArea, Generator], Shade | Planes]

PATTERNS: Mapping[str, Pattern] = MappingProxyType(
    {
        function.__name__: function
        for function in (
            building.bare,
            building.plain,
            building.plaster,
            building.concrete,
            building.wood,
            building.parquet,
            building.tile,
            building.brick,
            building.paving,
            building.carpet,
            building.marble,
            building.wallpaper,
            building.grass,
            objects.fabric,
            objects.metal,
            objects.ceramic,
            objects.glass,
            objects.leaves,
            objects.books,
            objects.picture,
            objects.screen,
            objects.keyboard,
            objects.food,
            objects.scribble,
            objects.label,
        )
    }
)
"""The materials that a `Part`, wall, floor or ceiling can name, each with the function that paints it."""

MAX_PIXELS = 1 << 25


def texture(
    pattern: str, colour: Colour, rng: Generator, shape: tuple[int, int], metres: tuple[float, float]
) -> UInt8[np.ndarray, "height width 3"]:
    """Return an RGB texture of `shape` (height, width) [px] for a surface of `metres` (width, height) [m].

    Raises `WorldsError` for an unknown pattern, a size that is not positive, or more than `MAX_PIXELS` pixels.
    """
    if pattern not in PATTERNS:
        raise WorldsError(f"unknown material {pattern!r}; valid: {', '.join(PATTERNS)}")
    (height, width), (width_m, height_m) = shape, metres
    if min(height, width) < 1 or height * width > MAX_PIXELS or not min(width_m, height_m) > 0.0:
        raise WorldsError(
            f"cannot paint {height} x {width} px over {height_m} x {width_m} m; valid: above 0, at most {MAX_PIXELS} px"
        )
    shade = PATTERNS[pattern](TextureArea(height, width, height_m, width_m), rng)
    planes = shade if shade.ndim == 3 else (shade, shade, shade)
    # `convertScaleAbs` clips to 255 but takes absolute values, so negative shades become 0 first. Converting plane by plane
    # is several times faster than arithmetic on interleaved pixels.
    bright = [np.maximum(plane, 0.0) for plane in planes] if shade.ndim == 3 else [np.maximum(shade, 0.0)] * 3
    return cv2.merge([cv2.convertScaleAbs(plane, alpha=255.0 * value) for plane, value in zip(bright, colour, strict=True)])


def tileable(pattern: str, colour: Colour, rng: Generator, side: int, side_m: float) -> UInt8[np.ndarray, "side side 3"]:
    """Return a square texture of `side` [px] that covers `side_m` [m] and can be repeated without a visible seam."""
    over = max(1, side // 6)
    whole, scale = side + over, side_m / side
    image = texture(pattern, colour, rng, (whole, whole), (whole * scale, whole * scale)).astype(np.float32)
    # The strip painted beyond the far edge is blended into the near edge, so that the near edge continues the far one.
    fade = np.linspace(0.0, 1.0, over, dtype=np.float32)[:, None, None]
    image[:over] = fade * image[:over] + (1.0 - fade) * image[side:]
    image[:, :over] = np.swapaxes(fade, 0, 1) * image[:, :over] + (1.0 - np.swapaxes(fade, 0, 1)) * image[:, side:]
    return np.rint(image[:side, :side]).astype(np.uint8)
