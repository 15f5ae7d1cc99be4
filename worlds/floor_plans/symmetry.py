"""`Symmetry`: mirrors a house, rotates it by quarter turns and shifts it."""

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from jaxtyping import Float

from worlds.spec import FurnitureSpec, HouseSpec, OpeningSpec, Point, RoomSpec, StoreySpec, WindowSpec

_DIGITS = 9
"""Decimal places to which coordinates in metres are rounded, so that a symmetry and its inverse restore the same numbers."""
_TURNS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
_QUARTER = math.pi / 2
_Gap = TypeVar("_Gap", OpeningSpec, WindowSpec)


@dataclass(frozen=True)
class Symmetry:
    """A symmetry of the plan: negate x if `mirror`, then rotate counter-clockwise about the origin, then shift."""

    mirror: bool = False
    quarter_turns: int = 0
    shift_m: Point = (0.0, 0.0)

    def point(self, point: Point) -> Point:
        """Apply the symmetry to a point of the plan [m]."""
        x, y = (-point[0] if self.mirror else point[0]), point[1]
        cos, sin = _TURNS[self.quarter_turns % 4]
        # Adding zero turns -0.0 into 0.0, which is what files should contain.
        return (
            round(cos * x - sin * y + self.shift_m[0], _DIGITS) + 0.0,
            round(sin * x + cos * y + self.shift_m[1], _DIGITS) + 0.0,
        )

    def points(self, points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
        """Apply the symmetry to points in W [m]; heights do not change."""
        cos, sin = _TURNS[self.quarter_turns % 4]
        x, y = points[:, 0] * (-1.0 if self.mirror else 1.0), points[:, 1]
        return np.stack([cos * x - sin * y + self.shift_m[0], sin * x + cos * y + self.shift_m[1], points[:, 2]], axis=-1)

    def yaw(self, yaw: float) -> float:
        """Return the yaw of an object after the symmetry, in (-pi, pi] [rad].

        The object itself is rotated, but never mirrored. Its front faces the direction to which the symmetry takes the old
        direction of the front.
        """
        start = -yaw if self.mirror else yaw
        quarters = round(start / _QUARTER)
        # Whole quarter turns are counted as integers, so that an object parallel to a wall stays exactly parallel.
        turned, rest = (quarters + self.quarter_turns) % 4, start - quarters * _QUARTER
        if turned == 3 or (turned == 2 and rest > 0.0):
            turned -= 4
        return turned * _QUARTER + rest

    def house(self, spec: HouseSpec) -> HouseSpec:
        """Apply the symmetry to a whole house. Ids, seeds and heights stay; furniture is rotated, but never mirrored."""
        return spec.model_copy(update={"storeys": tuple(self._storey(storey) for storey in spec.storeys)})

    def _storey(self, storey: StoreySpec) -> StoreySpec:
        return storey.model_copy(
            update={
                "rooms": tuple(self._room(room) for room in storey.rooms),
                "openings": tuple(self._ends(opening) for opening in storey.openings),
                "windows": storey.windows and tuple(self._ends(window) for window in storey.windows),
                "furniture": storey.furniture and tuple(self._piece(piece) for piece in storey.furniture),
            }
        )

    def _room(self, room: RoomSpec) -> RoomSpec:
        corners = tuple(self.point(corner) for corner in room.polygon_m)
        return room.model_copy(update={"polygon_m": corners[::-1] if self.mirror else corners})

    def _ends(self, gap: _Gap) -> _Gap:
        # The leaf needs no change: "start" and "end" move with the points, and the room that it swings into is the same.
        return gap.model_copy(update={"start_m": self.point(gap.start_m), "end_m": self.point(gap.end_m)})

    def _piece(self, piece: FurnitureSpec) -> FurnitureSpec:
        x, y, z = piece.position_m
        return piece.model_copy(update={"position_m": (*self.point((x, y)), z), "yaw_rad": self.yaw(piece.yaw_rad)})


def in_place(spec: HouseSpec, mirror: bool = False, quarter_turns: int = 0) -> Symmetry:
    """Return the symmetry of a house whose shift keeps the lower left corner of the plan's bounding box in place.

    With this shift, mirroring a house twice or rotating it four times by a quarter turn gives the same house again.
    """
    bare = Symmetry(mirror, quarter_turns)
    before = [corner for storey in spec.storeys for room in storey.rooms for corner in room.polygon_m]
    after = [bare.point(corner) for corner in before]
    shift = tuple(round(min(p[k] for p in before) - min(p[k] for p in after), _DIGITS) for k in (0, 1))
    return Symmetry(mirror, quarter_turns, (shift[0], shift[1]))
