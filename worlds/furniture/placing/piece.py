"""`Piece`: a piece of furniture in its place in a room."""

from dataclasses import dataclass
from typing import NamedTuple

from worlds.furniture.kinds import Kind, Size
from worlds.furniture.placing.room_shape import AXES, Point, Rectangle


class Pose(NamedTuple):
    """A place for a piece, in the room's coordinates."""

    x: float
    """Centre of the foot print [m]."""
    y: float
    turn: int
    """Quarter turns: the piece's x axis is `AXES[turn]`, its front faces the next of them; -3 ... 3."""
    z: float = 0.0
    """Of the underside, above the floor [m]."""
    run: int | None = None
    """The wall at its back, an index into `RoomPlan.runs`."""

    def moved(self, x: float, y: float) -> Point:
        """The room coordinates of (x, y) in the piece's frame [m]."""
        (tx, ty), (nx, ny) = AXES[self.turn], AXES[self.turn - 3]
        return self.x + x * tx + y * nx, self.y + x * ty + y * ny

    def covers(self, size: Size) -> Rectangle:
        """The foot print of a piece of `size` [m]."""
        half_x, half_y = (size.depth / 2, size.width / 2) if self.turn % 2 else (size.width / 2, size.depth / 2)
        return self.x - half_x, self.y - half_y, self.x + half_x, self.y + half_y

    def ahead(self, size: Size, depth: float) -> Rectangle:
        """The floor `depth` deep in front of that [m]."""
        (ax, ay), (bx, by) = self.moved(-size.width / 2, size.depth / 2), self.moved(size.width / 2, size.depth / 2 + depth)
        return min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A piece that has found its place."""

    kind: Kind
    size: Size
    pose: Pose
    key: int
    """Of the streams of what stands at, on or under it."""
    seed: int
    """Of its colours and variants."""
    since: float
    """The clutter from which on it is there."""
