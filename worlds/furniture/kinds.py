"""`Kind`: the declaration of a kind of furniture: sizes, rooms, how it is placed and how it is built."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal, NamedTuple, get_args

from numpy.random import Generator

from worlds.errors import WorldsError
from worlds.labels import ROOM_LABELS
from worlds.parts import Part
from worlds.spec import ID_PATTERN
from worlds.valid_names import did_you_mean

MAX_NAME_LENGTH = 40
"""Largest number of characters of a kind's name. The ids of its pieces consist of three numbers and this name."""
MAX_LENGTH_M = 20.0
"""Greatest length that a declaration may contain [m]. Greater numbers are refused, since they usually mean centimetres."""
Range = tuple[float, float]
"""A range of values, from the lowest to the highest."""
Parts = tuple[Part, ...]


@dataclass(frozen=True)
class PerClutter:
    """The number of pieces, for a kind of furniture that only cluttered rooms have."""

    per_clutter: float
    """Expected number of pieces per unit of clutter above 1.

    For pieces on the floor, this is the number in a room of 12 m²; it grows with the area of the room. For pieces on top of
    another piece (the host), it is the number on each host.
    """


Count = float | tuple[int, int] | PerClutter
"""Number of pieces in a room, declared as an expected number, as an inclusive range (least, most) that holds in a room of
usual clutter with enough space, or as a number that grows with the clutter."""


class Size(NamedTuple):
    """The extents of a piece [m], and the intervals that they span in the piece's frame.

    The origin of the frame is the centre of the footprint on the underside; x points along the width, y to the front, z up.
    """

    width: float
    depth: float
    height: float

    @property
    def left(self) -> float:
        """Smallest x [m]."""
        return -self.width / 2

    @property
    def right(self) -> float:
        """Largest x [m]."""
        return self.width / 2

    @property
    def back(self) -> float:
        """Smallest y [m]."""
        return -self.depth / 2

    @property
    def front(self) -> float:
        """Largest y [m]."""
        return self.depth / 2

    @property
    def x(self) -> Range:
        """Interval in x from the left to the right end of the piece, -width / 2 to width / 2 [m]."""
        return self.left, self.right

    @property
    def y(self) -> Range:
        """Interval in y from the back to the front of the piece, -depth / 2 to depth / 2 [m]."""
        return self.back, self.front

    @property
    def z(self) -> Range:
        """Interval in z from the foot to the top of the piece, 0 to height [m]."""
        return 0.0, self.height


Spot = Literal["centre", "anywhere"]
HostSides = Literal["all", "front"]
TopPosition = Literal["back", "middle", "front", "anywhere"]


@dataclass(frozen=True)
class AgainstWall:
    """Placement of a piece on the floor, with its back to a wall."""

    beside: tuple[str, ...] = ()
    """Kinds of furniture that the piece is preferably placed next to."""
    corner: bool = False
    """Whether the piece is preferably placed at the end of a wall."""
    can_stand_free: bool = False
    """Whether the first piece that a room requires may stand away from the walls if it fits at none, as in an open plan."""


@dataclass(frozen=True)
class OnFloor:
    """Placement of a piece on the floor, independently of the walls."""

    spot: Spot = "anywhere"
    """Where in the room the piece stands: near the centre, or anywhere."""


@dataclass(frozen=True)
class Around:
    """Placement on the floor, facing another piece (the host) of a kind in `hosts`. `Kind.rooms` counts pieces per host."""

    hosts: tuple[str, ...]
    side: HostSides = "all"
    """The sides of the host at which the piece can stand."""
    gap_m: float = 0.03
    """Distance from the host [m]."""


@dataclass(frozen=True)
class OnTop:
    """Placement on top of another piece (the host) of a kind in `hosts`. `Kind.rooms` counts pieces per host."""

    hosts: tuple[str, ...]
    at: TopPosition = "anywhere"
    """Where on the host the piece stands; the front is the host's front."""


@dataclass(frozen=True)
class OnWall:
    """Placement of a piece that hangs on a wall, with the underside at a height drawn from `height_m` [m]."""

    height_m: Range = (1.25, 1.6)
    above: tuple[str, ...] = ()
    """Kinds of furniture (the hosts) that the piece hangs above; if empty, the piece hangs on a free stretch of wall.
    `Kind.rooms` counts pieces per host if there are hosts."""


@dataclass(frozen=True)
class OnCeiling:
    """Placement of a piece that hangs from the ceiling near the centre of the room."""


Place = AgainstWall | OnFloor | Around | OnTop | OnWall | OnCeiling
Build = Callable[[Size, Generator], Parts]


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of furniture, as declared in the catalogue. Two declarations are two kinds, even if they are alike."""

    name: str
    """Name of the kind, of up to `MAX_NAME_LENGTH` characters. It is a part of ids, and may have the same characters."""
    width: Range
    """Range of widths [m]."""
    depth: Range
    """Range of depths [m]."""
    height: Range
    """Range of heights [m]."""
    rooms: Mapping[str, Count]
    """Number of pieces in a room, by the room's label. Rooms with other labels have no such piece, and stairs stay empty."""
    build: Build
    """Function (size, generator) -> parts of a piece; all parts must lie inside the box of the given size."""
    place: Place = AgainstWall()
    solid: bool = True
    """Whether the piece blocks a walking person; a rug, for example, does not."""
    clearance: float = 0.0
    """Depth of the floor in front of the piece that stays free [m]."""
    essential: bool = False
    """Whether a room that requires the piece is of no use without it, such as a kitchen without a sink. Essential pieces are
    placed before all others."""

    def __post_init__(self) -> None:
        """Raise `WorldsError` for a value with which no piece can be placed."""
        if len(self.name) > MAX_NAME_LENGTH or not re.fullmatch(ID_PATTERN, self.name):
            raise WorldsError(
                f"furniture kind {self.name[:80]!r} has a name that cannot be written into a house; valid: up to "
                f"{MAX_NAME_LENGTH} letters a to z, digits, blanks and _ . ' -, beginning with a letter or a digit"
            )
        self._check_fields(self)
        self._check_fields(self.place)
        for label, count in self.rooms.items():
            if label not in ROOM_LABELS:
                guess = did_you_mean(str(label), ROOM_LABELS)
                raise WorldsError(
                    f"kind {self.name!r} names an unknown room {label!r}{guess}; valid: {', '.join(ROOM_LABELS)}"
                )
            if not _is_count(count):
                raise self._error(f"the count in {label!r}", count, _COUNT)

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names of the kinds that a piece of this kind stands at or on, or hangs above; empty if it needs no host."""
        match self.place:
            case OnTop(hosts=names) | Around(hosts=names) | OnWall(above=names):
                return names
        return ()

    def is_required_in(self, label: str) -> bool:
        """Return whether rooms with `label` require a piece: their number is declared as a range from 1, such as (1, 2)."""
        count = self.rooms.get(label)
        return isinstance(count, tuple) and count[0] >= 1

    def _check_fields(self, declared: "Kind | Place") -> None:
        for field in fields(declared):
            if field.name in _RULES:
                is_valid, valid = _RULES[field.name]
                value = getattr(declared, field.name)
                if not is_valid(value):
                    raise self._error(field.name, value, valid)

    def _error(self, where: str, value: object, valid: str) -> WorldsError:
        return WorldsError(f"kind {self.name!r}: {where} is {repr(value)[:80]}; valid: {valid}")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float)


def _is_length(value: Any) -> bool:
    return _is_number(value) and 0.0 <= value <= MAX_LENGTH_M


def _is_range(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 2 and all(map(_is_length, value)) and value[0] <= value[1]


def _is_size(value: Any) -> bool:
    return _is_range(value) and value[0] > 0.0


def _is_count(value: Any) -> bool:
    if isinstance(value, tuple):
        whole = len(value) == 2 and all(isinstance(end, int) for end in value)
        return whole and 0 <= value[0] <= value[1] and value[1] >= 1
    number = value.per_clutter if isinstance(value, PerClutter) else value
    return _is_number(number) and 0.0 < number < math.inf


def _is_names(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(name, str) for name in value)


_Rule = tuple[Callable[[Any], bool], str]


def _choice(choices: object) -> _Rule:
    names = get_args(choices)
    return names.__contains__, ", ".join(names)


_COUNT = "a number above 0, whole numbers (least, greatest) with a greatest of at least 1, or PerClutter of a number above 0"
_SIZE: _Rule = _is_size, f"a range (low, high) with 0 < low <= high <= {MAX_LENGTH_M:g} m"
_LENGTH: _Rule = _is_length, f"0 to {MAX_LENGTH_M:g} m"
_NAMES: _Rule = _is_names, 'a tuple of names of kinds, such as ("sofa",)'
_RULES: Mapping[str, _Rule] = {
    "width": _SIZE,
    "depth": _SIZE,
    "height": _SIZE,
    "rooms": (lambda value: isinstance(value, Mapping), 'a dictionary of counts by label, such as {"kitchen": 0.5}'),
    "place": (
        lambda value: isinstance(value, Place),
        "AgainstWall(), OnFloor(), Around(hosts), OnTop(hosts), OnWall() or OnCeiling()",
    ),
    "clearance": _LENGTH,
    "hosts": (
        lambda value: _is_names(value) and len(value) >= 1,
        'a tuple of at least one name of a kind, such as ("sofa",)',
    ),
    "beside": _NAMES,
    "above": _NAMES,
    "gap_m": _LENGTH,
    "height_m": (_is_range, f"a range (low, high) with 0 <= low <= high <= {MAX_LENGTH_M:g} m"),
    "spot": _choice(Spot),
    "side": _choice(HostSides),
    "at": _choice(TopPosition),
}
"""For the fields of `Kind` and of its places: a check of the value, and what would be valid."""
