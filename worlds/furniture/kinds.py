"""`Kind`: what a piece of furniture is, where it belongs and how it is built."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from numpy.random import Generator

from worlds.errors import WorldsError
from worlds.labels import ROOM_LABELS
from worlds.parts import Part

Range = tuple[float, float]
Parts = tuple[Part, ...]


@dataclass(frozen=True)
class Hoarded:
    """What only a cluttered room has."""

    per_clutter: float
    """Expected number for every step of clutter above 1; of what stands on the floor, in a room of 12 m²."""


Count = float | tuple[int, int] | Hoarded
"""An expected number; or an inclusive range of what the room always has; or what clutter brings."""


class Size(NamedTuple):
    """A piece's extents [m] and the intervals that they span in the piece's frame."""

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
        """The whole width [m]."""
        return self.left, self.right

    @property
    def y(self) -> Range:
        """The whole depth [m]."""
        return self.back, self.front

    @property
    def z(self) -> Range:
        """The whole height [m]."""
        return 0.0, self.height


@dataclass(frozen=True)
class AgainstWall:
    """On the floor, its back to a wall."""

    beside: tuple[str, ...] = ()
    """Kinds that it stands next to where it can."""
    corner: bool = False
    """Whether it prefers the end of a wall."""


@dataclass(frozen=True)
class OnFloor:
    """On the floor, away from the walls."""

    spot: Literal["centre", "anywhere"] = "anywhere"


@dataclass(frozen=True)
class Around:
    """On the floor, facing a piece of one of `hosts`; the count is per host."""

    hosts: tuple[str, ...]
    side: Literal["all", "front"] = "all"
    gap_m: float = 0.03


@dataclass(frozen=True)
class OnTop:
    """On the top face of a piece of one of `hosts`; the count is per host."""

    hosts: tuple[str, ...]
    at: Literal["back", "middle", "front", "anywhere"] = "anywhere"


@dataclass(frozen=True)
class OnWall:
    """On a wall, its underside at a height in `height_m` [m]."""

    height_m: Range = (1.25, 1.6)
    above: tuple[str, ...] = ()
    """Kinds that it hangs over, one to each; if none is named it hangs on any free wall."""


@dataclass(frozen=True)
class OnCeiling:
    """Under the ceiling."""


Place = AgainstWall | OnFloor | Around | OnTop | OnWall | OnCeiling
Build = Callable[[Size, Generator], Parts]


@dataclass(frozen=True)
class Kind:
    """A kind of furniture, as declared in the catalogue."""

    name: str
    width: Range
    """[m]"""
    depth: Range
    """[m]"""
    height: Range
    """[m]"""
    rooms: Mapping[str, Count]
    """Room label -> how many."""
    build: Build
    """The parts of a piece of a given size, all inside its box."""
    place: Place = AgainstWall()
    solid: bool = True
    """Whether it blocks the way."""
    clearance: float = 0.0
    """Depth of the floor that stays free in front of it [m]."""

    def __post_init__(self) -> None:
        unknown = sorted(set(self.rooms) - set(ROOM_LABELS))
        if unknown:
            raise WorldsError(
                f"kind {self.name!r} names unknown rooms {', '.join(unknown)}; valid: {', '.join(ROOM_LABELS)}"
            )
        for axis, (low, high) in zip(("width", "depth", "height"), (self.width, self.depth, self.height), strict=True):
            if not 0.0 < low <= high:
                raise WorldsError(f"kind {self.name!r}: {axis} {low} ... {high} m is not a range of positive lengths")
