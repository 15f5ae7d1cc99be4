"""A storey's plan before it has doors: rooms, and which of them are to be joined how."""

from dataclasses import dataclass

from worlds.spec import OpeningKind, OpeningSpec, RoomSpec


@dataclass(frozen=True)
class Link:
    """Two neighbouring rooms to be joined by an opening."""

    rooms: tuple[str, str]
    """Ids."""
    kind: OpeningKind = "door"
    seed: int | None = None
    """Of where the opening is and what it is like; links of twin rooms have the same. None: as it comes."""


@dataclass(frozen=True)
class StoreyLayout:
    """The rooms of a storey and their links."""

    rooms: tuple[RoomSpec, ...]
    links: tuple[Link, ...]
    openings: tuple[OpeningSpec, ...] = ()
    """Those that have their place already: of stairs."""
    height_m: float = 2.6
    """Floor to ceiling [m]."""
