"""`Kind`: the declaration of a kind of furniture: sizes, rooms, how it is placed and how it is built."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from numpy.random import Generator

from worlds.errors import WorldsError
from worlds.labels import ROOM_LABELS
from worlds.parts import Part
from worlds.spec import ID_PATTERN

MAX_NAME_LENGTH = 40
"""Largest number of characters of a kind's name. The ids of its pieces consist of three numbers and this name."""
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
"""Number of pieces in a room, declared as an expected number, as an inclusive range (least, most) that always holds, or as
a number that grows with the clutter."""


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


@dataclass(frozen=True)
class AgainstWall:
    """Placement of a piece on the floor, with its back to a wall."""

    beside: tuple[str, ...] = ()
    """Kinds of furniture that the piece is preferably placed next to."""
    corner: bool = False
    """Whether the piece is preferably placed at the end of a wall."""


@dataclass(frozen=True)
class OnFloor:
    """Placement of a piece on the floor, independently of the walls."""

    spot: Literal["centre", "anywhere"] = "anywhere"


@dataclass(frozen=True)
class Around:
    """Placement on the floor, facing another piece (the host) of a kind in `hosts`. `Kind.rooms` counts pieces per host."""

    hosts: tuple[str, ...]
    side: Literal["all", "front"] = "all"
    """The sides of the host at which the piece can stand."""
    gap_m: float = 0.03
    """Distance from the host [m]."""


@dataclass(frozen=True)
class OnTop:
    """Placement on top of another piece (the host) of a kind in `hosts`. `Kind.rooms` counts pieces per host."""

    hosts: tuple[str, ...]
    at: Literal["back", "middle", "front", "anywhere"] = "anywhere"


@dataclass(frozen=True)
class OnWall:
    """Placement of a piece that hangs on a wall, with the underside at a height drawn from `height_m` [m]."""

    height_m: Range = (1.25, 1.6)
    above: tuple[str, ...] = ()
    """Kinds of furniture (the hosts) that the piece hangs above; if empty, the piece hangs on a free stretch of wall."""


@dataclass(frozen=True)
class OnCeiling:
    """Placement of a piece that hangs from the ceiling near the centre of the room."""


Place = AgainstWall | OnFloor | Around | OnTop | OnWall | OnCeiling
Build = Callable[[Size, Generator], Parts]


@dataclass(frozen=True)
class Kind:
    """A kind of furniture, as declared in the catalogue."""

    name: str
    """Name of the kind, of up to `MAX_NAME_LENGTH` characters. It is a part of ids, and may have the same characters."""
    width: Range
    """Range of widths [m]."""
    depth: Range
    """Range of depths [m]."""
    height: Range
    """Range of heights [m]."""
    rooms: Mapping[str, Count]
    """Number of pieces in a room, by the room's label. Rooms with other labels have no such piece."""
    build: Build
    """Function (size, generator) -> parts of a piece; all parts must lie inside the box of the given size."""
    place: Place = AgainstWall()
    solid: bool = True
    """Whether the piece blocks a walking person; a rug, for example, does not."""
    clearance: float = 0.0
    """Depth of the floor in front of the piece that stays free [m]."""

    def __post_init__(self) -> None:
        """Raise `WorldsError` for a name, a room or a range that is not valid."""
        if len(self.name) > MAX_NAME_LENGTH or not re.fullmatch(ID_PATTERN, self.name):
            raise WorldsError(
                f"furniture kind {self.name[:80]!r} has a name that cannot be written into a house; valid: up to "
                f"{MAX_NAME_LENGTH} letters a to z, digits, blanks and _ . ' -, beginning with a letter or a digit"
            )
        unknown = sorted(set(self.rooms) - set(ROOM_LABELS))
        if unknown:
            raise WorldsError(
                f"kind {self.name!r} names unknown rooms {', '.join(unknown)}; valid: {', '.join(ROOM_LABELS)}"
            )
        for axis, (low, high) in zip(("width", "depth", "height"), (self.width, self.depth, self.height), strict=True):
            if not 0.0 < low <= high:
                raise WorldsError(f"kind {self.name!r}: {axis} {low} ... {high} m is not a range; valid: 0 < low <= high")
