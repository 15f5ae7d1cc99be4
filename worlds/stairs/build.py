"""Stairs of a house: flights between the storeys of a cell, each rule of a walkable stair checked.

A cell is a rectangle that stands on itself from storey to storey. On every storey one opening leads to the flight up and one
to the flight from below. The sides of the cell that the two ends of a flight lie in decide the kind: the same side U,
opposite sides straight, adjacent sides L.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from worlds.errors import HouseError
from worlds.parts import Part
from worlds.spec import HouseSpec, OpeningSpec
from worlds.stairs.cells import CellFrame, cell_frame, cell_on, flights, is_same_cell, opening_that_leads
from worlds.stairs.flights import MIN_WIDTH_M, Climb, Point, StairsKind, cell_needed, climb
from worlds.stairs.geometry import rail_parts, sills, slab_parts

APPROACH_M = 0.4
"""The walking line begins and ends this far outside the cell."""
MIN_HEAD_ROOM_M = 1.95
"""Above every tread and landing, and in the openings."""
BODY_HALF_M = 0.3
"""Openings reach this far to either side of their flight's middle line."""
_TOLERANCE_M = 1e-6


@dataclass(frozen=True, eq=False)
class Stairs:
    """What joins two storeys in one cell; boxes in world coordinates."""

    room: str
    """Id of the stairs' room on the lower storey."""
    storey: int
    """The lower of the two storeys."""
    kind: StairsKind
    treads: tuple[Part, ...]
    """Steps and landings, upwards."""
    floors: tuple[Part, ...]
    """What is level with a storey: before the first riser (unless there is ground) and after the last."""
    railing: tuple[Part, ...]
    walking_line: Float64[np.ndarray, "k 3"]
    """From the lower storey's room in front of the stairs to the upper one's: straight along every flight, at the height of
    each tread above its middle [m]."""

    @property
    def parts(self) -> tuple[Part, ...]:
        """All that is seen."""
        return self.treads + self.floors + self.railing


def build_stairs(spec: HouseSpec, floors_m: Sequence[float]) -> tuple[Stairs, ...]:
    """All flights of a house whose storeys have their floors at `floors_m`.

    Raises `HouseError` where openings do not say which way they lead or lie badly, and where a rule of walkable stairs is
    broken: the message names the stairs and what they need.
    """
    stairs = tuple(_Site.of(spec, floors_m, level, place).stairs() for level, place in flights(spec))
    _check_head_room(stairs)
    return stairs


@dataclass(frozen=True)
class _Site:
    """One storey of a cell, ready for its flights."""

    room: str
    storey: int
    heights_m: tuple[float, float]
    """Floor to ceiling, of the two storeys."""
    floor_m: float
    rise_m: float
    is_lowest: bool
    foot: OpeningSpec
    head: OpeningSpec
    frame: CellFrame

    @staticmethod
    def of(spec: HouseSpec, floors_m: Sequence[float], level: int, place: int) -> "_Site":
        """`place`: index of the stairs' room on storeys[`level`]."""
        lower, upper, room = spec.storeys[level], spec.storeys[level + 1], spec.storeys[level].rooms[place]
        above = next(other for other in upper.rooms if is_same_cell(room, other))
        foot, head = opening_that_leads(spec, level, room, "up"), opening_that_leads(spec, level + 1, above, "down")
        return _Site(
            room.id,
            level,
            (lower.height_m, upper.height_m),
            floors_m[level],
            floors_m[level + 1] - floors_m[level],
            cell_on(spec, level - 1, room) is None,
            foot,
            head,
            cell_frame(level, room, foot, head),
        )

    def stairs(self) -> Stairs:
        steps = climb(self.frame.kind, self.frame.length, self.frame.width, self.rise_m, above_void=not self.is_lowest)
        self._check_size(steps)
        self._check_opening(self.foot, steps.line[0], 0)
        self._check_opening(self.head, steps.line[-1], 1)
        beside = sills(self.head, steps.head, self.frame)
        floors = [steps.head, *(slab for slab, _ in beside)]
        if not self.is_lowest:
            extra = sills(self.foot, steps.foot, self.frame)
            beside, floors = beside + extra, [*floors, steps.foot, *(slab for slab, _ in extra)]
        line = [_outwards(steps.line[1], steps.line[0]), *steps.line, _outwards(steps.line[-2], steps.line[-1])]
        return Stairs(
            self.room,
            self.storey,
            self.frame.kind,
            slab_parts(steps.treads, self.frame, self.floor_m),
            slab_parts(floors, self.frame, self.floor_m),
            rail_parts([*steps.rails, *(rail for _, rail in beside)], self.frame, self.floor_m),
            # To the nanometre: floors are floors to the last bit, and level is level.
            np.round([(*self.frame.world(u, v), self.floor_m + z) for u, v, z in line], 9),
        )

    def _check_size(self, steps: Climb) -> None:
        if steps.is_walkable:
            return
        kind, cell = self.frame.kind, self.frame
        width_m = MIN_WIDTH_M if kind == "L" else max(MIN_WIDTH_M, steps.width_m)
        length, _ = cell_needed(kind, self.rise_m, width_m=width_m)
        _, width = cell_needed(kind, self.rise_m)
        raise HouseError(
            f"stairs {self.room!r}: {cell.length:.2f} x {cell.width:.2f} m is too small for {kind} stairs that rise "
            f"{self.rise_m:.2f} m from storeys[{self.storey}]; they need at least {length:.2f} m along the first flight and "
            f"{width:.2f} m across it, between the walls' centre lines"
        )

    def _check_opening(self, opening: OpeningSpec, place: Point, end: int) -> None:
        """It lets a body through on the middle line of its flight, with head room."""
        level = self.storey + end
        a, b = (math.dist(self.frame.plan(*corner), place[:2]) for corner in (opening.start_m, opening.end_m))
        if a + b > opening.width_m + 1e-3 or min(a, b) < BODY_HALF_M - 1e-3:
            x, y = self.frame.world(*place[:2])
            raise HouseError(
                f"stairs {self.room!r}: on storeys[{level}] the middle of the flight is at ({x:.2f}, {y:.2f}) m; the "
                f"opening that leads there has to reach at least {BODY_HALF_M} m to either side of it"
            )
        if (top := opening.gap_m(self.heights_m[end])[1]) < MIN_HEAD_ROOM_M - _TOLERANCE_M:
            raise HouseError(
                f"stairs {self.room!r}: the opening that leads to them on storeys[{level}] is {top:.2f} m high; head room "
                f"needs {MIN_HEAD_ROOM_M} m"
            )


def _outwards(inside: Point, border: Point) -> Point:
    """A place beyond the border of the cell, on the level."""
    dx, dy = border[0] - inside[0], border[1] - inside[1]
    scale = APPROACH_M / math.hypot(dx, dy)
    return border[0] + scale * dx, border[1] + scale * dy, border[2]


def _check_head_room(stairs: Sequence[Stairs]) -> None:
    """Nothing of a flight hangs low over any part of the one below it."""
    for lower in stairs:
        for upper in stairs:
            if upper.storey != lower.storey + 1:
                continue
            gap = _least_gap(_extents(lower.treads + lower.floors), _extents(upper.treads + upper.floors))
            if gap < MIN_HEAD_ROOM_M - _TOLERANCE_M:
                raise HouseError(
                    f"stairs {upper.room!r}: their flight up from storeys[{upper.storey}] leaves {gap:.2f} m of head room "
                    f"over the flight below; it needs {MIN_HEAD_ROOM_M} m. Let it begin above where the lower one begins"
                )


def _extents(parts: Sequence[Part]) -> Float64[np.ndarray, "2 n 3"]:
    """Least and greatest corners of upright boxes [m]."""
    centre, half = np.array([part.centre for part in parts]), np.array([part.size for part in parts]) / 2
    return np.stack([centre - half, centre + half])


def _least_gap(lower: Float64[np.ndarray, "2 n 3"], upper: Float64[np.ndarray, "2 m 3"]) -> float:
    """From the tops of lower boxes up to the undersides of the upper ones that are above them, the least [m]."""
    (low, high), (start, stop) = lower[:, :, None], upper[:, None]
    over = ((low < stop - _TOLERANCE_M) & (start < high - _TOLERANCE_M))[..., :2].all(axis=-1)
    over &= stop[..., 2] > high[..., 2] + _TOLERANCE_M
    return float((start[..., 2] - high[..., 2])[over].min(initial=np.inf))
