"""`Piece`: a piece of furniture with its pose in a room."""

from dataclasses import dataclass
from typing import NamedTuple

from worlds.furniture.kinds import Kind, Size
from worlds.furniture.placing.room_shape import AXES, Point
from worlds.rectangles import Rectangle


class Pose(NamedTuple):
    """The position and rotation of a piece, in the room's coordinates."""

    x: float
    """x of the centre of the footprint [m]."""
    y: float
    """y of the centre of the footprint [m]."""
    turn: int
    """Rotation in quarter turns, 0 ... 3: the piece's x axis points along `AXES[turn]`, its front along the next axis."""
    z: float = 0.0
    """Height of the underside above the floor [m]."""
    run: int | None = None
    """Index into `RoomPlan.runs` of the wall at the back of the piece; None if there is no wall."""

    def moved(self, x: float, y: float) -> Point:
        """Convert a point (x, y) from the piece's frame to the room's coordinates [m]."""
        (tx, ty), (nx, ny) = AXES[self.turn], AXES[self.turn - 3]
        return self.x + x * tx + y * nx, self.y + x * ty + y * ny

    def covers(self, size: Size) -> Rectangle:
        """Return the footprint of a piece of `size` in this pose [m]."""
        half_x, half_y = (size.depth / 2, size.width / 2) if self.turn % 2 else (size.width / 2, size.depth / 2)
        return self.x - half_x, self.y - half_y, self.x + half_x, self.y + half_y

    def ahead(self, size: Size, depth: float) -> Rectangle:
        """Return the rectangle of floor in front of a piece of `size`, as wide as the piece and `depth` deep [m]."""
        (ax, ay), (bx, by) = self.moved(-size.width / 2, size.depth / 2), self.moved(size.width / 2, size.depth / 2 + depth)
        return min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A piece that has been placed."""

    kind: Kind
    size: Size
    pose: Pose
    key: int
    """Key of the piece's random stream; the keys of the pieces at, on or above this piece are derived from it."""
    seed: int
    """Seed of the piece's colours and variants."""
    since: float
    """Least clutter at which the piece is present."""
