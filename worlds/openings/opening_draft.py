"""`OpeningDraft`: an opening while its position is being planned.

A draft gives the opening by its extent along its wall, which is easier to compute with than the end points of an
`OpeningSpec`. Variables that hold drafts are called gaps.
"""

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from worlds.rectangles import Rectangle
from worlds.spec import Leads, LeafSpec, OpeningKind, OpeningSpec, RoomSpec
from worlds.walls import Boundary, opening_span, room_edges

LEAF_THICKNESS_M = 0.04
"""Thickness of door leaves [m]."""
_TOLERANCE_M = 1e-6


@dataclass(frozen=True)
class LeafDraft:
    """The leaf of a door."""

    at_low: bool
    """Whether the hinge is at the lower end of the opening, the end with the smaller coordinate."""
    into: str
    """Id of the room that the leaf swings into."""
    angle: float
    """Opening angle of the leaf; 0: closed [rad]."""

    def spec(self) -> LeafSpec:
        """Return the leaf as a spec, for an `OpeningSpec` that starts at the opening's lower end."""
        return LeafSpec(hinge="start" if self.at_low else "end", into=self.into, angle_rad=self.angle)


@dataclass(frozen=True)
class OpeningDraft:
    """An opening in a wall that runs along `axis` (0: x, 1: y), from `low` to `high` on that axis [m]."""

    rooms: tuple[str, str]
    """Ids of the rooms on both sides: first the room at smaller coordinates across the wall, then the other room."""
    kind: OpeningKind
    axis: int
    at: float
    """Coordinate of the wall's centre line across the axis [m]."""
    low: float
    """Lower end of the opening along the wall's axis [m]."""
    high: float
    """Upper end of the opening along the wall's axis [m]."""
    height: float = 2.05
    """Height of the upper end above the floor [m]."""
    sill: float = 1.0
    """Height of the lower end above the floor, for half walls and counters only [m]."""
    leaf: LeafDraft | None = None
    leads: Leads | None = None
    """For an opening to stairs: whether it leads to the flight up or down; None if the spec does not say this."""

    @property
    def width(self) -> float:
        """Clear width of the opening [m]."""
        return self.high - self.low

    @property
    def larger_side(self) -> str:
        """Id of the room at larger coordinates across the wall."""
        return self.rooms[1]

    def around(self, depth_m: float) -> Rectangle:
        """Return a rectangle as long as the opening that reaches `depth_m` to both sides of the wall's centre line [m]."""
        cross = self.at - depth_m, self.at + depth_m
        return (self.low, cross[0], self.high, cross[1]) if self.axis == 0 else (cross[0], self.low, cross[1], self.high)

    def spec(self) -> OpeningSpec:
        """Return the opening as a spec, which starts at the lower end."""
        ends = [(v, self.at) if self.axis == 0 else (self.at, v) for v in (self.low, self.high)]
        return OpeningSpec(
            rooms=self.rooms,
            kind=self.kind,
            start_m=ends[0],
            end_m=ends[1],
            height_m=self.height,
            sill_m=self.sill,
            leaf=None if self.leaf is None else self.leaf.spec(),
            leads=self.leads,
        )

    @staticmethod
    def of(opening: OpeningSpec, rooms: dict[str, RoomSpec]) -> "OpeningDraft":
        """Convert the spec of an opening to a draft. Raises `HouseError` if the opening runs along neither x nor y."""
        axis, at, low, high = opening_span(opening)
        # A spec may name its two rooms in any order; a draft needs them by their sides of the wall.
        sides = opening.rooms
        for wall in shared_walls(rooms[sides[0]], rooms[sides[1]]):
            if (wall.axis, wall.at) == (axis, at) and wall.low < high and low < wall.high:
                sides = str(wall.rooms[0]), str(wall.rooms[1])
        leaf = None
        if opening.leaf is not None:
            at_low = (opening.leaf.hinge == "start") == (opening.start_m <= opening.end_m)
            leaf = LeafDraft(at_low, opening.leaf.into, opening.leaf.angle_rad)
        sizes = opening.height_m, opening.sill_m
        return OpeningDraft(sides, opening.kind, axis, at, low, high, *sizes, leaf, opening.leads)


def shared_walls(a: RoomSpec, b: RoomSpec) -> list[Boundary]:
    """Return the stretches of wall with room `a` on one side and room `b` on the other."""
    return join_stretches(_facing(a, b))


def join_stretches(pieces: Iterable[Boundary]) -> list[Boundary]:
    """Sort pieces of boundary, and merge pieces that touch on one line and lie between the same rooms."""
    joined: list[Boundary] = []
    for piece in sorted(pieces, key=lambda wall: (wall.axis, wall.at, wall.low)):
        last = joined[-1] if joined else None
        same_line = last is not None and (last.axis, last.at, last.rooms) == (piece.axis, piece.at, piece.rooms)
        if last is not None and same_line and piece.low <= last.high + _TOLERANCE_M:
            joined[-1] = Boundary(last.axis, last.at, last.low, max(last.high, piece.high), last.rooms)
        else:
            joined.append(piece)
    return joined


def _facing(a: RoomSpec, b: RoomSpec) -> Iterator[Boundary]:
    """Yield every stretch where an edge of one room lies on an edge of the other room, with the rooms on opposite sides."""
    for (axis, at, low, high, side), (axis_b, at_b, low_b, high_b, side_b) in itertools.product(
        room_edges(a), room_edges(b)
    ):
        start, stop = max(low, low_b), min(high, high_b)
        if axis == axis_b and side != side_b and abs(at - at_b) < _TOLERANCE_M and stop - start > _TOLERANCE_M:
            yield Boundary(axis, at, start, stop, (a.id, b.id) if side == 0 else (b.id, a.id))
