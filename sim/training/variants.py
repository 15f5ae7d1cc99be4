"""Held-out colours of furniture, one of every palette, which never occur in training frames.

The look of a piece of furniture follows from the piece's seed. So a house is repainted by giving pieces other seeds, without
moving them.
"""

from dataclasses import replace

import numpy as np

from worlds.furniture.palette import BRIGHT, FRONTS, LINEN, UPHOLSTERY, WOODS
from worlds.house import Furniture, House
from worlds.parts import Colour

HELD_OUT_COLOURS: frozenset[Colour] = frozenset(palette[2] for palette in (WOODS, UPHOLSTERY, LINEN, BRIGHT, FRONTS))
_TRIES = 64


def repainted(house: House, held_out: bool) -> House:
    """Return the house with furniture in trained colours only, or, with `held_out`, in held-out colours if a kind has any.

    With trained colours, pieces for which no trained look is found, e.g. a shelf of many bright things, are left out. The
    result is deterministic.
    """
    pieces = (_with(piece, held_out) for piece in house.furniture)
    return replace(house, furniture=tuple(piece for piece in pieces if piece is not None))


def shows_held_out(piece: Furniture) -> bool:
    """Whether any part of the piece has a held-out colour."""
    return any(part.colour in HELD_OUT_COLOURS for part in piece.parts)


def _with(piece: Furniture, held_out: bool) -> Furniture | None:
    if shows_held_out(piece) == held_out:
        return piece
    for seed in np.random.default_rng(piece.seed).integers(2**32, size=_TRIES).tolist():
        other = replace(piece, seed=seed)
        if shows_held_out(other) == held_out:
            return other
    return piece if held_out else None
