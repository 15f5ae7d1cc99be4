"""`StoreyLayout`: the plan of a storey before its doors have positions: the rooms, and which of them are to be connected.

A link is a request: these two rooms get an opening of this kind. `worlds.openings.placement` decides where in their shared
wall the opening lies.
"""

from dataclasses import dataclass

from worlds.spec import OpeningKind, OpeningSpec, RoomSpec


@dataclass(frozen=True)
class Link:
    """A request for an opening between two neighbouring rooms."""

    rooms: tuple[str, str]
    """Ids of the two rooms."""
    kind: OpeningKind = "door"
    seed: int | None = None
    """Seed of the opening's position and size; links of twin rooms share one. None: the storey's generator draws them."""


@dataclass(frozen=True)
class StoreyLayout:
    """The rooms of a storey and their links."""

    rooms: tuple[RoomSpec, ...]
    links: tuple[Link, ...]
    openings: tuple[OpeningSpec, ...] = ()
    """Openings that have a position already: those to the stairs."""
    height_m: float = 2.6
    """Height of the ceiling above the floor [m]."""
