"""The colours and materials of furniture. Colours are few, because pieces of one material and colour share a texture."""

from collections.abc import Sequence

from numpy.random import Generator

from worlds.parts import Colour

WHITE: Colour = (0.93, 0.92, 0.9)
BLACK: Colour = (0.12, 0.12, 0.13)
GREY: Colour = (0.55, 0.56, 0.57)
STEEL: Colour = (0.75, 0.77, 0.79)
CHROME: Colour = (0.85, 0.87, 0.9)
GLASS: Colour = (0.7, 0.84, 0.88)
SKY: Colour = (0.68, 0.84, 0.97)
LAMP: Colour = (1.0, 0.95, 0.8)
GREEN: Colour = (0.24, 0.46, 0.18)
TERRACOTTA: Colour = (0.72, 0.38, 0.25)
CARDBOARD: Colour = (0.7, 0.54, 0.36)
PAPER: Colour = (0.95, 0.94, 0.9)
RED: Colour = (0.75, 0.14, 0.12)

OAK: Colour = (0.74, 0.57, 0.37)
WALNUT: Colour = (0.42, 0.28, 0.19)

WOODS: tuple[Colour, ...] = (OAK, WALNUT, (0.62, 0.42, 0.24), (0.83, 0.7, 0.52), (0.52, 0.3, 0.18))
DARK_WOODS: tuple[Colour, ...] = (WALNUT, (0.3, 0.19, 0.13), (0.2, 0.17, 0.16))
WHITES: tuple[Colour, ...] = (WHITE, (0.9, 0.87, 0.8), (0.84, 0.85, 0.86))
METALS: tuple[Colour, ...] = (STEEL, (0.45, 0.46, 0.48), BLACK)
FRONTS: tuple[Colour, ...] = (WHITE, (0.86, 0.84, 0.76), (0.42, 0.5, 0.46), (0.3, 0.38, 0.5), OAK, (0.66, 0.2, 0.18))
UPHOLSTERY: tuple[Colour, ...] = (
    (0.45, 0.47, 0.5),
    (0.24, 0.32, 0.46),
    (0.55, 0.28, 0.22),
    (0.72, 0.64, 0.52),
    (0.26, 0.42, 0.36),
    (0.36, 0.24, 0.18),
)
LINEN: tuple[Colour, ...] = (
    WHITE,
    (0.55, 0.68, 0.84),
    (0.85, 0.66, 0.68),
    (0.66, 0.78, 0.6),
    (0.88, 0.8, 0.56),
    (0.46, 0.4, 0.58),
)
BRIGHT: tuple[Colour, ...] = (
    (0.86, 0.2, 0.18),
    (0.97, 0.78, 0.16),
    (0.18, 0.48, 0.84),
    (0.26, 0.68, 0.34),
    (0.93, 0.5, 0.66),
    (0.95, 0.55, 0.15),
)
STONES: tuple[Colour, ...] = ((0.3, 0.3, 0.32), (0.68, 0.66, 0.63), (0.88, 0.87, 0.85), (0.5, 0.44, 0.38))

MATERIALS = (
    "bare", "plain", "plaster", "concrete", "wood", "parquet", "tile", "brick", "paving", "carpet", "marble", "wallpaper",
    "grass", "fabric", "metal", "ceramic", "glass", "leaves", "books", "picture", "screen", "keyboard", "food", "scribble",
    "label",
)  # fmt: skip
"""The materials that a part can have. `worlds.visuals.materials` paints each of them."""


def pick(rng: Generator, colours: Sequence[Colour]) -> Colour:
    """Draw one of `colours` at random."""
    return colours[int(rng.integers(len(colours)))]
