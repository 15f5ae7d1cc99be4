"""`StoreyLayout`: the rooms of a storey and the pairs of rooms to be connected, before the openings have positions.

A link is the request to connect two rooms by an opening of a certain kind. `worlds.openings.placement` decides where in the
shared wall of the two rooms the opening lies.
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
    """Seed of the opening's position and size, the same for links of twin rooms. None: the storey's generator draws them."""


@dataclass(frozen=True)
class StoreyLayout:
    """The rooms of a storey and their links."""

    rooms: tuple[RoomSpec, ...]
    links: tuple[Link, ...]
    openings: tuple[OpeningSpec, ...] = ()
    """Openings that already have a position, which are the openings to the stairs."""
    height_m: float = 2.6
    """Height of the ceiling above the floor [m]."""
