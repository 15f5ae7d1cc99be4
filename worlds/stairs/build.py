"""`build_stairs`: all flights of a house, each checked to be walkable.

The rooms of a staircase are called its cells. They cover the same rectangle of the plan on consecutive storeys. A flight
joins each storey to the next. An opening of the lower cell leads to the foot of the flight, and an opening of the upper cell
to its head. The sides of the rectangle in which these two openings lie decide the kind of stairs: U-shaped stairs for the
same side, straight stairs for opposite sides, L-shaped stairs for adjacent sides.

For every flight, `build_stairs`

1. finds the two openings, and from them the kind of stairs and the coordinate frame of the cell (`worlds.stairs.cells`),
2. fits steps, landings and railings into the cell (`worlds.stairs.flights`), and checks their size,
3. checks that the openings are wide, high and near enough for a person to reach the flight,
4. turns everything into boxes in W (`worlds.stairs.geometry`).

The head room between flights is checked last, when all flights are known.

Cells may also have spiral stairs (`worlds.stairs.spirals`) or a lift (`worlds.stairs.shafts`). A cell of this kind has
one opening on every storey, so that no opening needs to say where it leads.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from worlds.errors import HouseError
from worlds.parts import Part
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec
from worlds.stairs.cells import (
    APPROACH_M,
    BODY_HALF_M,
    MIN_HEAD_ROOM_M,
    CellFrame,
    cell_frame,
    cell_on,
    flight_places,
    frame_along,
    is_same_cell,
    opening_that_leads,
)
from worlds.stairs.flights import MIN_RUN_WIDTH_M, Point, StairsKind, StairsLayout, cell_needed, fit_stairs
from worlds.stairs.geometry import SLAB_THICKNESS_M, floor_beside_flight, rail_parts, slab_parts
from worlds.stairs.shafts import check_shafts, entrance, lift_line
from worlds.stairs.spirals import Spiral, least_cell

_TOLERANCE_M = 1e-6


@dataclass(frozen=True, eq=False)
class Stairs:
    """The stairs, or the lift, from one storey to the next, as boxes in W."""

    room: str
    """Id of the stairs' room on the lower storey."""
    storey: int
    """Index of the lower storey."""
    kind: StairsKind | Literal["spiral", "lift"]
    treads: tuple[Part, ...]
    """Steps and landings, from the lowest to the highest; a lift has none, nor has it floors and a railing."""
    floors: tuple[Part, ...]
    """Level pieces of floor in the stairs' room. One piece lies behind the last riser. Another piece lies in front of the
    first riser; only the lowest flight of a staircase needs none, because it begins on the floor of the storey. Further
    pieces lie beside the flight, if an opening is wider than the flight behind it."""
    railing: tuple[Part, ...]
    walking_line: Float64[np.ndarray, "k 3"]
    """Path up the stairs in W [m]. It begins in front of the stairs on the lower storey, and ends in front of them on the
    upper storey. It is straight along every run of steps, and passes the middle of each tread at the tread's height. In a
    lift it rises vertically."""

    @property
    def parts(self) -> tuple[Part, ...]:
        """All visible boxes of the stairs."""
        return self.treads + self.floors + self.railing


def build_stairs(spec: HouseSpec, floors_m: Sequence[float]) -> tuple[Stairs, ...]:
    """Build all flights of a house whose storeys have their floors at the heights `floors_m` in W [m].

    Raises `HouseError` if it is not clear which opening leads to which flight, if a flight cannot be reached through its
    openings, if a room of stairs is too small, or if there is too little head room. The message names the stairs and what
    they need.
    """
    check_shafts(spec)
    stairs = tuple(_stairs(spec, floors_m, level, cell) for level, cell in flight_places(spec))
    _check_head_room([flight for flight in stairs if flight.kind not in ("spiral", "lift")])
    return stairs


def _stairs(spec: HouseSpec, floors_m: Sequence[float], level: int, cell: RoomSpec) -> Stairs:
    """Build the flight, spiral or lift up from storeys[`level`] in `cell`."""
    match cell.climb:
        case "flights":
            return _Site.of(spec, floors_m, level, cell).stairs()
        case "spiral":
            return _spiral(spec, floors_m, level, cell)
        case "lift":
            heights = floors_m[level], floors_m[level + 1]
            line = lift_line(spec, level, (cell, _above(spec, level, cell)), heights)
            return Stairs(cell.id, level, "lift", treads=(), floors=(), railing=(), walking_line=line)


def _spiral(spec: HouseSpec, floors_m: Sequence[float], level: int, cell: RoomSpec) -> Stairs:
    """Build the spiral up from storeys[`level`] in `cell`. Raises `HouseError` if the room or an entrance is unsuitable."""
    floor_m = floors_m[level]
    foot = entrance(spec, level, cell, floor_m)
    head = entrance(spec, level + 1, _above(spec, level, cell), floors_m[level + 1])
    if (foot.inward != head.inward).any():
        raise HouseError(f"spiral {cell.id!r}: its openings are in different sides; valid: all in one side of its room")
    x, y = foot.inward[:2].tolist()
    frame = frame_along("U", cell, (x, y), (-y, x))
    spiral = Spiral(frame.length, frame.width, floors_m[level + 1] - floor_m)
    _check_spiral(cell.id, spiral)
    goes_on = any(is_same_cell(cell, other) for storey in spec.storeys[level + 2 :] for other in storey.rooms)
    line = spiral.line(*(frame.plan(*end.middle[:2])[1] for end in (foot, head)))
    return Stairs(
        cell.id,
        level,
        "spiral",
        spiral.steps(frame, floor_m),
        slab_parts(spiral.floors(), frame, floor_m),
        rail_parts(spiral.rails(goes_on), frame, floor_m),
        _walking_line(line, frame, floor_m),
    )


def _check_spiral(name: str, spiral: Spiral) -> None:
    """Raise `HouseError` if the room of a spiral is too small, or the next floor too low for a body to walk below it."""
    if not spiral.is_walkable:
        length, width = least_cell(spiral.rise)
        raise HouseError(
            f"spiral {name!r}: {spiral.length:.2f} x {spiral.width:.2f} m is too small to rise {spiral.rise:.2f} m; "
            f"valid: at least {length:.2f} m away from its openings and {width:.2f} m across"
        )
    if (head_room := spiral.rise - SLAB_THICKNESS_M) < MIN_HEAD_ROOM_M:
        valid = f"a rise of at least {MIN_HEAD_ROOM_M + SLAB_THICKNESS_M:.2f} m"
        raise HouseError(f"spiral {name!r}: the floor above leaves {head_room:.2f} m of head room; valid: {valid}")


def _above(spec: HouseSpec, level: int, cell: RoomSpec) -> RoomSpec:
    """Return the cell (room of stairs) of the same staircase on the storey above storeys[`level`]."""
    return next(other for other in spec.storeys[level + 1].rooms if is_same_cell(cell, other))


@dataclass(frozen=True)
class _Site:
    """A place for a flight: the cell (room) of the flight, and the two storeys and the two openings that it has to join."""

    room: str
    storey: int
    heights_m: tuple[float, float]
    """Heights of the lower and the upper storey from floor to ceiling [m]."""
    floor_m: float
    """Height of the floor at the flight's foot in W [m]."""
    rise_m: float
    """Height from the lower floor to the upper floor [m]."""
    is_lowest: bool
    """Whether the flight stands on solid ground: no flight of the same staircase is below it."""
    foot: OpeningSpec
    """The opening on the lower storey that leads to the flight."""
    head: OpeningSpec
    """The opening on the upper storey that leads to the flight."""
    frame: CellFrame

    @staticmethod
    def of(spec: HouseSpec, floors_m: Sequence[float], level: int, cell: RoomSpec) -> "_Site":
        """Return the place for the flight up from storeys[`level`] in `cell`."""
        lower, upper = spec.storeys[level], spec.storeys[level + 1]
        above = _above(spec, level, cell)
        foot, head = opening_that_leads(spec, level, cell, "up"), opening_that_leads(spec, level + 1, above, "down")
        return _Site(
            cell.id,
            level,
            (lower.height_m, upper.height_m),
            floors_m[level],
            floors_m[level + 1] - floors_m[level],
            cell_on(spec, level - 1, cell) is None,
            foot,
            head,
            cell_frame(level, cell, foot, head),
        )

    def stairs(self) -> Stairs:
        steps = fit_stairs(self.frame.kind, self.frame.length, self.frame.width, self.rise_m, above_void=not self.is_lowest)
        self._check_size(steps)
        self._check_opening(self.foot, steps.line[0], 0)
        self._check_opening(self.head, steps.line[-1], 1)
        beside = floor_beside_flight(self.head, steps.head, self.frame)
        floors = [steps.head, *(slab for slab, _ in beside)]
        if not self.is_lowest:
            extra = floor_beside_flight(self.foot, steps.foot, self.frame)
            beside, floors = beside + extra, [*floors, steps.foot, *(slab for slab, _ in extra)]
        return Stairs(
            self.room,
            self.storey,
            self.frame.kind,
            slab_parts(steps.treads, self.frame, self.floor_m),
            slab_parts(floors, self.frame, self.floor_m),
            rail_parts([*steps.rails, *(rail for _, rail in beside)], self.frame, self.floor_m),
            _walking_line(steps.line, self.frame, self.floor_m),
        )

    def _check_size(self, steps: StairsLayout) -> None:
        if steps.is_walkable:
            return
        kind = self.frame.kind
        width_m = MIN_RUN_WIDTH_M if kind == "L" else max(MIN_RUN_WIDTH_M, steps.width_m)
        length, _ = cell_needed(kind, self.rise_m, width_m=width_m)
        _, width = cell_needed(kind, self.rise_m)
        raise HouseError(
            f"stairs {self.room!r}: {self.frame.length:.2f} x {self.frame.width:.2f} m is too small for {kind} stairs "
            f"that rise {self.rise_m:.2f} m from storeys[{self.storey}]; valid: at least {length:.2f} m along the first "
            f"run of steps and {width:.2f} m across it, between the walls' centre lines"
        )

    def _check_opening(self, opening: OpeningSpec, place: Point, end: int) -> None:
        """Raise `HouseError` unless a body fits through an opening on the middle line of its flight, with head room.

        `place` is where the walking line goes through the opening, in the cell's coordinates; `end` is 0 for the foot of the
        flight and 1 for its head.
        """
        level = self.storey + end
        a, b = (math.dist(self.frame.plan(*corner), place[:2]) for corner in (opening.start_m, opening.end_m))
        if a + b > opening.width_m + 1e-3 or min(a, b) < BODY_HALF_M - 1e-3:
            x, y = self.frame.world(*place[:2])
            raise HouseError(
                f"stairs {self.room!r}: on storeys[{level}] the middle of the flight is at ({x:.2f}, {y:.2f}) m, but a body "
                f"cannot pass the opening there; valid: one that reaches at least {BODY_HALF_M} m to either side of it"
            )
        if (top := opening.gap_m(self.heights_m[end])[1]) < MIN_HEAD_ROOM_M - _TOLERANCE_M:
            raise HouseError(
                f"stairs {self.room!r}: the opening that leads to them on storeys[{level}] is {top:.2f} m high, too low to "
                f"walk through; valid: at least {MIN_HEAD_ROOM_M} m"
            )


def _walking_line(inside: Sequence[Point], frame: CellFrame, floor_m: float) -> Float64[np.ndarray, "k 3"]:
    """Return a walking line in W [m], lengthened at both ends so that it begins and ends outside the cell.

    `inside` has the points of the line in the cell, in the coordinates of `frame` and above the lower floor, which is at the
    height `floor_m` in W [m].
    """
    line = [_outwards(inside[1], inside[0]), *inside, _outwards(inside[-2], inside[-1])]
    # Rounded to the nanometre, so that points on a floor or landing are all at exactly the same height.
    return np.round([(*frame.world(u, v), floor_m + z) for u, v, z in line], 9)


def _outwards(inside: Point, border: Point) -> Point:
    """Return the end of a walking line outside the cell: `APPROACH_M` beyond `border`, on the straight line from `inside`.

    `inside` is a point of the walking line in the cell. `border` is the point at which the line leaves the cell.
    """
    dx, dy = border[0] - inside[0], border[1] - inside[1]
    scale = APPROACH_M / math.hypot(dx, dy)
    return border[0] + scale * dx, border[1] + scale * dy, border[2]


def _check_head_room(stairs: Sequence[Stairs]) -> None:
    """Raise `HouseError` if a flight leaves too little head room over a flight that begins on the storey below."""
    for lower in stairs:
        for upper in stairs:
            if upper.storey != lower.storey + 1:
                continue
            gap = _least_gap(_extents(lower.treads + lower.floors), _extents(upper.treads + upper.floors))
            if gap < MIN_HEAD_ROOM_M - _TOLERANCE_M:
                raise HouseError(
                    f"stairs {upper.room!r}: their flight up from storeys[{upper.storey}] leaves {gap:.2f} m of head room "
                    f"over the flight below; valid: at least {MIN_HEAD_ROOM_M} m (let it begin above where that one begins)"
                )


def _extents(parts: Sequence[Part]) -> Float64[np.ndarray, "2 n 3"]:
    """Return the corner with the least and the corner with the greatest coordinates of every box, in this order [m]."""
    centre, half = np.array([part.centre for part in parts]), np.array([part.size for part in parts]) / 2
    return np.stack([centre - half, centre + half])


def _least_gap(lower: Float64[np.ndarray, "2 n 3"], upper: Float64[np.ndarray, "2 m 3"]) -> float:
    """Return the least head room that boxes of an upper flight leave over boxes of a lower flight [m].

    Both arguments are results of `_extents`. The head room is the height from the top of a lower box to the underside of an
    upper box. Only those pairs of boxes count that overlap in the plan, and whose upper box ends above the lower box. If
    there is no such pair, the result is infinite.
    """
    (low, high), (start, stop) = lower[:, :, None], upper[:, None]
    over = ((low < stop - _TOLERANCE_M) & (start < high - _TOLERANCE_M))[..., :2].all(axis=-1)
    over &= stop[..., 2] > high[..., 2] + _TOLERANCE_M
    return float((start[..., 2] - high[..., 2])[over].min(initial=np.inf))
