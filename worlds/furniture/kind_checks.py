"""`check_kinds`: the checks of declarations that wait until a room is furnished.

Until then, the kinds that a declaration names may still be declared, and so may the functions that its function calls.
"""

import math
from collections.abc import Iterator
from functools import cache
from numbers import Real
from typing import Any

import numpy as np

from worlds.errors import WorldsError
from worlds.furniture.kinds import Kind, Range, Size
from worlds.furniture.palette import MATERIALS
from worlds.parts import Part
from worlds.valid_names import did_you_mean

_MARGIN_M = 0.02
"""Greatest distance by which a part may reach beyond the size of its piece [m]."""


@cache
def check_kinds(catalogue: tuple[Kind, ...]) -> None:
    """Raise `WorldsError` if a kind names kinds that do not exist, or if it builds a piece that is not as declared."""
    names = {kind.name for kind in catalogue}
    for kind in catalogue:
        for name in (*kind.hosts, *getattr(kind.place, "beside", ())):
            if name not in names:
                raise WorldsError(
                    f"kind {kind.name!r}: its place names an unknown kind {name!r}{did_you_mean(name, names)}; "
                    "valid: a name in worlds.furniture.CATALOGUE"
                )
        _check_sample(kind)


@cache
def _check_sample(kind: Kind) -> None:
    """Raise `WorldsError` if the smallest piece of the kind has no parts, or a part that is not valid."""
    size = Size(kind.width[0], kind.depth[0], kind.height[0])
    parts: Any = kind.build(size, np.random.default_rng(0))
    mistake = next(_mistakes(parts, size), None)
    if mistake is not None:
        raise WorldsError(f"kind {kind.name!r}, built at {' x '.join(f'{m:g}' for m in size)} m: {mistake}")


def _mistakes(parts: Any, size: Size) -> Iterator[str]:
    if not isinstance(parts, tuple) or not parts or not all(isinstance(part, Part) for part in parts):
        yield f"its function returns {repr(parts)[:80]}; valid: a tuple of at least one part"
        return
    for part in parts:
        if part.material not in MATERIALS:
            yield f"a {part.shape} has the material {part.material!r}; valid: {', '.join(MATERIALS)}"
        if not _is_colour(part.colour):
            yield f"a {part.shape} has the colour {part.colour!r:.60}; valid: three numbers from 0 to 1"
        for axis, (start, end), (low, high) in zip("xyz", _spans(part), (size.x, size.y, size.z), strict=True):
            if not low - _MARGIN_M <= start < end <= high + _MARGIN_M:
                yield f"a {part.shape} reaches from {start:.4g} to {end:.4g} m along {axis}; valid: {low:g} ... {high:g} m"


def _is_colour(colour: Any) -> bool:
    numbers = isinstance(colour, tuple | list) and len(colour) == 3 and all(isinstance(each, Real) for each in colour)
    return numbers and all(0.0 <= each <= 1.0 for each in colour)


def _spans(part: Part) -> Iterator[Range]:
    """Return the intervals in x, y and z that the part covers in the frame of its piece [m]."""
    cos, sin = abs(math.cos(part.yaw)), abs(math.sin(part.yaw))
    x, y, z = part.size
    for centre, length in zip(part.centre, (cos * x + sin * y, sin * x + cos * y, z), strict=True):
        yield centre - length / 2, centre + length / 2
