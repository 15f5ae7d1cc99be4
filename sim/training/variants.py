"""Held-out colours of furniture, one of each palette, which never occur in training frames.

The look of a piece of furniture follows from the piece's seed. A house is therefore repainted by giving pieces other seeds.
The pieces are not moved.
"""

from dataclasses import replace

import numpy as np

from worlds.furniture.palette import BRIGHT, FRONTS, LINEN, UPHOLSTERY, WOODS
from worlds.house import Furniture, House
from worlds.parts import Colour

HELD_OUT_COLOURS: frozenset[Colour] = frozenset(palette[2] for palette in (WOODS, UPHOLSTERY, LINEN, BRIGHT, FRONTS))
_TRIES = 64


def repainted(house: House, held_out: bool) -> House:
    """Return the house with repainted furniture.

    If `held_out`, each piece shows a held-out colour, unless no such look is found. Otherwise, no piece shows a held-out
    colour; pieces for which no such look is found, such as a shelf of many bright things, are left out. The result is
    deterministic.
    """
    pieces = (_with(piece, held_out) for piece in house.furniture)
    return replace(house, furniture=tuple(piece for piece in pieces if piece is not None))


def shows_held_out(piece: Furniture) -> bool:
    """Return whether any part of a piece of furniture has a held-out colour."""
    return any(part.colour in HELD_OUT_COLOURS for part in piece.parts)


def _with(piece: Furniture, held_out: bool) -> Furniture | None:
    if shows_held_out(piece) == held_out:
        return piece
    for seed in np.random.default_rng(piece.seed).integers(2**32, size=_TRIES).tolist():
        other = replace(piece, seed=seed)
        if shows_held_out(other) == held_out:
            return other
    return piece if held_out else None
