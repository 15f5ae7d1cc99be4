"""The cells of stairs: which cells are one staircase, which opening leads to which flight, and the frame of each flight.

A cell is a room of stairs on one storey. The cells of a staircase cover the same rectangle on consecutive storeys.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from worlds.errors import HouseError
from worlds.labels import STAIRS
from worlds.spec import PASSABLE, HouseSpec, Leads, OpeningSpec, RoomSpec, StoreySpec
from worlds.stairs.flights import StairsKind

Bounds = tuple[float, float, float, float]
MIN_HEAD_ROOM_M = 1.95
"""Least head room above every tread and landing, and least height of the openings to the stairs [m]."""
APPROACH_M = 0.4
"""Distance from the room of the stairs at which the walking line begins and ends, outside of the room [m]."""
BODY_HALF_M = 0.3
"""Half the width of a body [m]. Openings to a flight must extend at least this far to either side of its middle line."""
_TOLERANCE_M = 1e-6
_SAME_HALF_M = 0.2
"""Least distance between the middles of the two openings of U-shaped stairs [m]. Openings that are closer to each other
count as in the same half of their side of the cell, which is not allowed."""
_INWARD = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Unit vectors that point into a cell from its four sides, in this order: low x, high x, low y, high y."""


def bounds(room: RoomSpec) -> Bounds:
    """Return the bounding box of a room's polygon: x0, y0, x1, y1 [m]."""
    x, y = zip(*room.polygon_m, strict=True)
    return min(x), min(y), max(x), max(y)


def is_same_cell(room: RoomSpec, other: RoomSpec) -> bool:
    """Return whether two rooms are stairs that cover the same rectangle of the plan, with a tolerance of a micrometre.

    All code that needs to know which rooms belong to one staircase uses this function. It compares coordinates with a
    tolerance instead of rounding them, because two nearly equal coordinates may be rounded differently.
    """
    return other.label == room.label == STAIRS and all(
        abs(a - b) <= _TOLERANCE_M for a, b in zip(bounds(room), bounds(other), strict=True)
    )


def cell_on(spec: HouseSpec, level: int, cell: RoomSpec) -> RoomSpec | None:
    """Return the room of stairs on storeys[`level`] that covers the same rectangle as `cell`; None if there is none."""
    if not 0 <= level < len(spec.storeys):
        return None
    return next((room for room in spec.storeys[level].rooms if is_same_cell(room, cell)), None)


def lowest_cells(spec: HouseSpec) -> dict[str, str]:
    """Return, for the id of every room of stairs, the id of the lowest room of the same staircase.

    A room of stairs belongs to the staircase of the room of stairs directly below it. Raises `HouseError` if a staircase
    skips a storey.
    """
    lowest: dict[str, str] = {}
    for level, storey in enumerate(spec.storeys):
        for cell in (room for room in storey.rooms if room.label == STAIRS):
            below = cell_on(spec, level - 1, cell)
            if below is None:
                _check_skips_no_storey(spec, level, cell)
            lowest[cell.id] = cell.id if below is None else lowest[below.id]
    return lowest


def _check_skips_no_storey(spec: HouseSpec, level: int, cell: RoomSpec) -> None:
    for lower in reversed(range(level - 1)):
        if (below := cell_on(spec, lower, cell)) is not None:
            raise HouseError(
                f"stairs {cell.id!r} on storeys[{level}]: stairs {below.id!r} are in the same place on storeys[{lower}], "
                f"but storeys[{level - 1}] has none there; valid: stairs on every storey in between"
            )


def flight_places(spec: HouseSpec) -> Iterator[tuple[int, RoomSpec]]:
    """Yield, for each flight, spiral or lift of a house, the index of its lower storey and its cell on that storey."""
    for level, lower in enumerate(spec.storeys):
        yield from ((level, room) for room in lower.rooms if cell_on(spec, level + 1, room) is not None)


def opening_that_leads(spec: HouseSpec, level: int, cell: RoomSpec, leads: Leads) -> OpeningSpec:
    """Return the opening of `cell` (stairs on storeys[`level`]) that leads to its flight up or down, as `leads` says.

    Raises `HouseError` unless exactly one opening leads to that flight; if flights go up and down from the cell, but an
    opening does not say to which flight it leads; and if an opening leads in a direction in which no flight goes.
    """
    openings = openings_of(spec.storeys[level], cell)
    found = [opening for index, opening in openings if _leads(spec, level, cell, index) == leads]
    if len(found) == 1:
        return found[0]
    flight = "up from" if leads == "up" else "down from"
    raise HouseError(
        f"stairs {cell.id!r} have {len(found) or 'no'} openings to the flight {flight} storeys[{level}]; "
        f'valid: exactly one opening there with "leads": "{leads}"'
    )


def openings_of(storey: StoreySpec, room: RoomSpec) -> Iterator[tuple[int, OpeningSpec]]:
    """Yield the openings of a room that one can walk through, with their indices."""
    for i, opening in enumerate(storey.openings):
        if room.id in opening.rooms and opening.kind in PASSABLE:
            yield i, opening


def _leads(spec: HouseSpec, level: int, cell: RoomSpec, index: int) -> Leads:
    """Return the direction of the flight to which the opening with the given `index` leads.

    Raises `HouseError` if flights go up and down and the spec does not state the direction, or if no flight goes in the
    stated direction.
    """
    opening = spec.storeys[level].openings[index]
    goes = {
        "up": cell_on(spec, level + 1, cell) is not None,
        "down": cell_on(spec, level - 1, cell) is not None,
    }
    where = f"storeys[{level}].openings[{index}] ({opening.rooms[0]} - {opening.rooms[1]})"
    if opening.leads is None:
        if goes["up"] and goes["down"]:
            raise HouseError(f'{where}: stairs go up and down from here; valid: "leads": "up" or "leads": "down"')
        return "up" if goes["up"] else "down"
    if not goes[opening.leads]:
        raise HouseError(f"{where}: leads {opening.leads}, but stairs {cell.id!r} do not go {opening.leads} from here")
    return opening.leads


@dataclass(frozen=True)
class CellFrame:
    """Coordinates (u, v) in a cell, the room of a flight of stairs: u points inwards from the side where the flight begins.

    v is horizontal and perpendicular to u. The origin is a corner of the cell. L- and U-shaped stairs begin at low v and end
    at high v.
    """

    kind: StairsKind
    origin: tuple[float, float]
    u_axis: tuple[float, float]
    v_axis: tuple[float, float]
    length: float
    """Extent of the cell along u, between wall centre lines [m]."""
    width: float
    """Extent of the cell along v, between wall centre lines [m]."""

    def world(self, u: float, v: float) -> tuple[float, float]:
        """Convert the point (u, v) of the cell to coordinates (x, y) in W [m]."""
        (ux, uy), (vx, vy), (x, y) = self.u_axis, self.v_axis, self.origin
        return x + u * ux + v * vx, y + u * uy + v * vy

    def plan(self, x: float, y: float) -> tuple[float, float]:
        """Convert the point (x, y) in W to coordinates (u, v) in the cell [m]."""
        dx, dy = x - self.origin[0], y - self.origin[1]
        return dx * self.u_axis[0] + dy * self.u_axis[1], dx * self.v_axis[0] + dy * self.v_axis[1]


def cell_frame(level: int, cell: RoomSpec, foot: OpeningSpec, head: OpeningSpec) -> CellFrame:
    """Return the coordinate frame of a cell (a room of stairs) for the flight between two openings, and the kind of stairs.

    `foot` is the opening on storeys[`level`], `head` the opening on the storey above. Raises `HouseError` if an opening is
    in no side of the cell, or if both openings are in the same half of one side.
    """
    u, from_head = inward(level, cell, foot), inward(level + 1, cell, head)
    v = (-u[1], u[0])
    facing, turning = _dot(u, from_head), _dot(v, from_head)
    (fx, fy), (hx, hy) = foot.middle_m, head.middle_m
    apart = _dot(v, (hx - fx, hy - fy))
    if facing > 0 and abs(apart) < _SAME_HALF_M:
        raise HouseError(
            f"stairs {cell.id!r}: the opening to the flight up on storeys[{level}] and the one to the flight down on "
            f"storeys[{level + 1}] are in the same half of the same side; valid: one in each half, for U-shaped stairs"
        )
    kind: StairsKind = "U" if facing > 0 else "straight" if facing < 0 else "L"
    if (apart if kind == "U" else -turning) < 0:
        v = (-v[0], -v[1])
    return frame_along(kind, cell, u, v)


def frame_along(kind: StairsKind, cell: RoomSpec, u: tuple[float, float], v: tuple[float, float]) -> CellFrame:
    """Return the coordinate frame of a cell with the unit vectors u and v, which point along its sides."""
    x0, y0, x1, y1 = bounds(cell)
    length, width = (x1 - x0, y1 - y0) if u[0] else (y1 - y0, x1 - x0)
    corner = (x0 if u[0] + v[0] > 0 else x1, y0 if u[1] + v[1] > 0 else y1)
    return CellFrame(kind, corner, u, v, length, width)


def _dot(a: tuple[float, float], b: tuple[float, float]) -> float:
    return a[0] * b[0] + a[1] * b[1]


def inward(level: int, cell: RoomSpec, opening: OpeningSpec) -> tuple[float, float]:
    """Return the unit vector into a cell from the side with the opening. Raises `HouseError` if it is in no side."""
    x0, y0, x1, y1 = bounds(cell)
    x, y = opening.middle_m
    gaps = (abs(x - x0), abs(x1 - x), abs(y - y0), abs(y1 - y))
    if min(gaps) > _TOLERANCE_M:
        raise HouseError(
            f"storeys[{level}]: the opening {opening.rooms[0]!r} - {opening.rooms[1]!r} at ({x:.2f}, {y:.2f}) m is in no "
            f"side of the stairs {cell.id!r}; valid: an opening in one of the four sides of their rectangle"
        )
    return _INWARD[gaps.index(min(gaps))]
