"""`RoomPlan`: the free space of one room while it is being furnished, as axis-aligned rectangles in the room's own frame."""

from collections import defaultdict
from collections.abc import Iterable, Sequence

from worlds.furniture.kinds import Around, Kind, Size
from worlds.furniture.placing.free_floor import FreeFloor
from worlds.furniture.placing.kept_free import Space, kept_free_of
from worlds.furniture.placing.piece import Piece, Pose
from worlds.furniture.placing.room_shape import EPS_M, RoomShape
from worlds.rectangles import Rectangle, grown
from worlds.spec import RoomSpec, StoreySpec, WindowSpec
from worlds.walls import HALF_WALL_M

FLAT_M = 0.03
"""Greatest height of a flat piece, such as a rug or mat [m]; flat pieces may lie under other furniture."""
_TRIES = 5
"""Greatest number of poses per piece for which the walkable floor is checked; this check is the costly part of placing."""


class RoomPlan:
    """The free floor, walls and space of a room.

    Seen from above, two solid pieces must not overlap. Other pieces may lie above or below each other, but not intersect.
    """

    def __init__(self, room: RoomSpec, storey: StoreySpec, windows: Sequence[WindowSpec] = ()) -> None:
        """Begin the plan of a room of `storey`, as yet without furniture; `windows` are all windows of the storey."""
        self.label, self.height_m = room.label, storey.height_m
        self.shape = RoomShape.of(room)
        ways = kept_free_of(self.shape, room, storey, windows)
        self.runs = ways.runs
        self.at_wall: dict[int | None, list[Piece]] = defaultdict(list)
        """The pieces that stand on the floor against each of the `runs`, by index."""
        self._inside = grown((0.0, 0.0, *self.shape.size), EPS_M - HALF_WALL_M)
        self._notches = [grown(notch, HALF_WALL_M) for notch in self.shape.notches]
        self._zones: list[tuple[Rectangle, Piece | None]] = [(zone, None) for zone in ways.zones]
        self._solids: list[Space] = []
        self._spaces = list(ways.spaces)
        self._flat: list[Rectangle] = []
        self._floor = FreeFloor(self.shape, ways.entries, ways.leaves)

    def claim_first_free(
        self, kind: Kind, size: Size, poses: Iterable[Pose], host: Piece | None, share: float
    ) -> Pose | None:
        """Claim the floor of the first of `poses` at which a piece fits, and return this pose; None if no pose is found.

        All poses must have the same height. A solid piece must leave all passages connected and `share` of the room's area
        walkable; at most `_TRIES` poses are checked for this. Its floor counts as occupied from then on, so that the caller
        has to `add` the piece.
        """
        obstacles: list[Rectangle] | None = None
        tries = _TRIES
        solids = self._notches + [space.rectangle for space in self._solids] if kind.clearance else []
        for pose in poses:
            if obstacles is None:
                obstacles = self._obstacles(kind, pose.z, pose.z + size.height, host)
            place = pose.covers(size)
            if not self._is_free(place, obstacles):
                continue
            if kind.clearance and not self._is_free(pose.ahead(size, kind.clearance), solids):
                continue
            if not kind.solid or self._floor.block(place, share):
                return pose
            tries -= 1
            if tries == 0:
                break
        return None

    def add(self, piece: Piece) -> None:
        """Mark the space of a piece as occupied.

        Other solid pieces keep out of the clearance in front of this piece, except pieces placed around it, such as chairs.
        """
        kind, size, pose = piece.kind, piece.size, piece.pose
        place = pose.covers(size)
        if pose.z + size.height <= FLAT_M:
            self._flat.append(place)
            return
        (self._solids if kind.solid else self._spaces).append(Space(place, pose.z, pose.z + size.height))
        if kind.clearance:
            self._zones.append((pose.ahead(size, kind.clearance), piece))
        if pose.run is not None and pose.z == 0.0:
            self.at_wall[pose.run].append(piece)

    def _obstacles(self, kind: Kind, bottom: float, top: float, host: Piece | None) -> list[Rectangle]:
        """Return the rectangles that a piece of `kind` must not overlap if it reaches from `bottom` to `top` [m]."""
        if top > self.height_m + EPS_M:
            return [self._inside]  # the piece is too high for the room
        if top <= FLAT_M:
            return self._notches + self._flat
        taken = self._notches + _between(self._spaces, bottom, top)
        if not kind.solid:
            return taken + _between(self._solids, bottom, top)
        # A guest (such as a chair at a desk) may stand in the clearance of its host.
        guest_of = host if isinstance(kind.place, Around) else None
        zones = [zone for zone, owner in self._zones if owner is None or owner is not guest_of]
        return taken + [solid.rectangle for solid in self._solids] + zones

    def _is_free(self, place: Rectangle, obstacles: Iterable[Rectangle]) -> bool:
        x0, y0, x1, y1 = place
        left, front, right, rear = self._inside
        x0, y0, x1, y1 = x0 + EPS_M, y0 + EPS_M, x1 - EPS_M, y1 - EPS_M
        if x0 < left or y0 < front or x1 > right or y1 > rear:
            return False
        for a, b, c, d in obstacles:  # noqa: SIM110 - the innermost loop of furnishing
            if x0 < c and x1 > a and y0 < d and y1 > b:
                return False
        return True


def _between(boxes: Sequence[Space], bottom: float, top: float) -> list[Rectangle]:
    """Return the extents in the plan of the boxes that reach into the heights from `bottom` to `top` [m]."""
    return [box.rectangle for box in boxes if box.bottom < top - EPS_M and box.top > bottom + EPS_M]
