"""Typical materials and colours of the floor, walls and ceiling of a room, by its label."""

from dataclasses import dataclass

from numpy.random import Generator

from worlds.errors import WorldsError
from worlds.labels import OUTDOOR_LABELS, ROOM_LABELS
from worlds.parts import Colour

Covering = tuple[str, Colour]
"""A pattern of `worlds.visuals.materials.PATTERNS` and its colour."""


@dataclass(frozen=True)
class Finish:
    """The coverings (pattern and colour) of the floor, the walls and the ceiling of a room."""

    floor: Covering
    wall: Covering
    ceiling: Covering


@dataclass(frozen=True)
class _Choice:
    """Patterns and colours from which a covering is drawn."""

    patterns: tuple[str, ...]
    colours: tuple[Colour, ...]

    def draw(self, rng: Generator, vary: float = 0.04) -> Covering:
        pattern = self.patterns[int(rng.integers(len(self.patterns)))]
        r, g, b = self.colours[int(rng.integers(len(self.colours)))]
        light = rng.uniform(-vary, vary)
        shift = rng.uniform(-vary / 2, vary / 2, 3) + light
        return pattern, (_clip(r + shift[0]), _clip(g + shift[1]), _clip(b + shift[2]))


def _clip(value: float) -> float:
    return float(min(max(value, 0.02), 1.0))


_WARM = ((0.9, 0.86, 0.78), (0.86, 0.78, 0.66), (0.92, 0.9, 0.86), (0.82, 0.74, 0.68))
_COOL = ((0.84, 0.88, 0.9), (0.74, 0.82, 0.86), (0.9, 0.92, 0.93))
_NEUTRAL = ((0.9, 0.9, 0.89), (0.84, 0.84, 0.83), (0.88, 0.86, 0.83))
_PASTEL = ((0.72, 0.84, 0.95), (0.96, 0.78, 0.84), (0.98, 0.93, 0.66), (0.76, 0.92, 0.76))
_WOODEN = ((0.66, 0.47, 0.29), (0.5, 0.33, 0.2), (0.78, 0.62, 0.42), (0.58, 0.38, 0.25))
_CARPETS = ((0.62, 0.56, 0.5), (0.48, 0.5, 0.58), (0.6, 0.46, 0.46), (0.55, 0.58, 0.48))
_OFFICE_CARPETS = ((0.38, 0.42, 0.5), (0.42, 0.42, 0.43), (0.34, 0.4, 0.4))

_PAINT = _Choice(("plain", "plaster"), _NEUTRAL)
_CEILING = _Choice(("plain", "plaster"), ((0.94, 0.94, 0.93), (0.9, 0.89, 0.86)))
_SKY = _Choice(("plain",), ((0.66, 0.8, 0.94),))

_FLOORS: dict[str, _Choice] = {
    "kitchen": _Choice(("tile", "tile", "paving"), ((0.8, 0.74, 0.64), (0.68, 0.66, 0.64), (0.74, 0.5, 0.38))),
    "dining room": _Choice(("parquet", "wood"), _WOODEN),
    "living room": _Choice(("wood", "parquet"), _WOODEN),
    "bedroom": _Choice(("carpet", "carpet", "wood"), _CARPETS),
    "children's room": _Choice(("carpet",), ((0.5, 0.66, 0.84), (0.6, 0.76, 0.5), (0.86, 0.6, 0.66), (0.86, 0.74, 0.42))),
    "bathroom": _Choice(("tile", "marble"), ((0.62, 0.74, 0.78), (0.78, 0.8, 0.8), (0.46, 0.54, 0.58))),
    "toilet": _Choice(("tile",), ((0.7, 0.76, 0.74), (0.58, 0.62, 0.66))),
    "corridor": _Choice(("wood", "paving", "carpet"), ((0.58, 0.46, 0.34), (0.62, 0.6, 0.57), (0.55, 0.36, 0.32))),
    "entrance hall": _Choice(("paving", "marble"), ((0.7, 0.66, 0.6), (0.56, 0.54, 0.52))),
    "stairs": _Choice(("wood", "paving"), ((0.62, 0.48, 0.34), (0.66, 0.65, 0.63))),
    "office": _Choice(("carpet",), _OFFICE_CARPETS),
    "meeting room": _Choice(("carpet", "wood"), ((0.36, 0.4, 0.5), (0.5, 0.4, 0.32))),
    "open-plan office": _Choice(("carpet",), _OFFICE_CARPETS),
    "lobby": _Choice(("marble", "paving"), ((0.8, 0.77, 0.72), (0.66, 0.66, 0.67))),
    "laundry room": _Choice(("tile", "concrete"), ((0.8, 0.8, 0.78), (0.62, 0.66, 0.68))),
    "storage room": _Choice(("concrete",), ((0.55, 0.54, 0.52), (0.62, 0.58, 0.53))),
    "pantry": _Choice(("tile", "paving"), ((0.72, 0.58, 0.44), (0.66, 0.6, 0.52))),
    "garage": _Choice(("concrete",), ((0.46, 0.46, 0.46), (0.54, 0.53, 0.51))),
    "garden": _Choice(("grass",), ((0.34, 0.52, 0.2), (0.42, 0.56, 0.22), (0.3, 0.46, 0.22))),
    "balcony": _Choice(("paving", "wood"), ((0.6, 0.55, 0.5), (0.6, 0.42, 0.28))),
    "gym": _Choice(("carpet", "parquet"), ((0.26, 0.27, 0.3), (0.72, 0.55, 0.35))),
    "library": _Choice(("parquet", "carpet"), ((0.46, 0.3, 0.2), (0.4, 0.22, 0.2))),
    "classroom": _Choice(("parquet", "tile"), ((0.7, 0.58, 0.42), (0.66, 0.68, 0.66))),
    "laboratory": _Choice(("tile", "concrete"), ((0.78, 0.81, 0.83), (0.68, 0.72, 0.74))),
    "print room": _Choice(("carpet", "concrete"), ((0.46, 0.45, 0.44), (0.6, 0.6, 0.6))),
}

_WALLS: dict[str, _Choice] = {
    "kitchen": _Choice(("tile", "plaster", "plain"), ((0.94, 0.9, 0.78), (0.9, 0.86, 0.7), (0.95, 0.93, 0.9))),
    "dining room": _Choice(("wallpaper", "plaster"), ((0.8, 0.62, 0.5), (0.86, 0.8, 0.66), (0.62, 0.66, 0.56))),
    "living room": _Choice(("plaster", "wallpaper", "plain", "brick"), _WARM),
    "bedroom": _Choice(
        ("wallpaper", "plain"), ((0.78, 0.8, 0.88), (0.88, 0.8, 0.78), (0.82, 0.86, 0.8), (0.86, 0.82, 0.88))
    ),
    "children's room": _Choice(("wallpaper",), _PASTEL),
    "bathroom": _Choice(("tile",), ((0.72, 0.88, 0.92), (0.92, 0.95, 0.95), (0.7, 0.86, 0.8))),
    "toilet": _Choice(("tile", "plain"), ((0.86, 0.92, 0.86), (0.9, 0.9, 0.84))),
    "corridor": _Choice(("plain", "plaster", "wallpaper"), ((0.93, 0.9, 0.82), (0.88, 0.87, 0.84))),
    "entrance hall": _Choice(("plaster", "wallpaper"), _WARM),
    "stairs": _Choice(("plaster", "brick"), ((0.9, 0.88, 0.84), (0.8, 0.76, 0.72))),
    "office": _Choice(("plain", "plaster"), _COOL),
    "open-plan office": _Choice(("plain", "concrete"), _COOL),
    "lobby": _Choice(("marble", "plaster", "wood"), ((0.88, 0.85, 0.8), (0.74, 0.62, 0.48))),
    "laundry room": _Choice(("tile", "plain"), ((0.9, 0.92, 0.94), (0.84, 0.9, 0.94))),
    "storage room": _Choice(("concrete", "plaster"), ((0.74, 0.72, 0.68), (0.66, 0.64, 0.6))),
    "pantry": _Choice(("plaster", "brick"), ((0.9, 0.84, 0.72), (0.8, 0.7, 0.58))),
    "garage": _Choice(("concrete", "brick"), ((0.66, 0.65, 0.63), (0.62, 0.42, 0.34))),
    "garden": _Choice(("brick", "plaster", "wood"), ((0.66, 0.4, 0.3), (0.86, 0.82, 0.74), (0.52, 0.36, 0.24))),
    "balcony": _Choice(("plaster", "brick"), ((0.86, 0.84, 0.8), (0.68, 0.44, 0.34))),
    "gym": _Choice(("plain", "concrete"), ((0.8, 0.82, 0.84), (0.78, 0.5, 0.3))),
    "library": _Choice(("wood", "wallpaper"), ((0.52, 0.36, 0.24), (0.46, 0.52, 0.42))),
    "classroom": _Choice(("plain", "plaster"), ((0.94, 0.92, 0.78), (0.8, 0.88, 0.82))),
    "laboratory": _Choice(("plain", "tile"), ((0.92, 0.95, 0.96), (0.86, 0.9, 0.92))),
}


def finish_of(label: str, rng: Generator) -> Finish:
    """Draw the coverings of a room with `label` at random. Raises `WorldsError` for an unknown label."""
    if label not in ROOM_LABELS:
        raise WorldsError(f"unknown room label {label!r}; valid: {', '.join(ROOM_LABELS)}")
    ceiling = _SKY if label in OUTDOOR_LABELS else _CEILING
    return Finish(_FLOORS[label].draw(rng), _WALLS.get(label, _PAINT).draw(rng), ceiling.draw(rng, 0.02))
