"""`grow`: houses built from a list of room requests, one after another, for property-based tests.

A request (`RoomRequest`) gives a room's label and size, its place relative to the rooms before it, and its openings:

    row 1  | room | room    |          The first room of a row starts at x = 0, north of the first room of the row below;
    -------+------+---+-----+          the others follow to its east.
    stairs | room     | room|  row 0

`worlds.strategies` draws the requests with Hypothesis. Two properties matter for these draws, and explain the rules below:

- Any list of requests gives a valid house in which every room can be reached, so that no drawn example is thrown away.
- A request never changes the rooms before it, so that Hypothesis can shrink a failing house by leaving rooms out.

A storey below another storey covers at least the bounding rectangle of the storey above. All arithmetic is in whole
decimetres, so that walls meet exactly.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.rectangles import overlap
from worlds.spec import PASSABLE, HouseSpec, LeafSpec, OpeningKind, OpeningSpec, Point, RoomSpec, StoreySpec

Start = Literal["beside", "row", "storey"]
Shape = Literal["rectangle", "L", "T"]
DoorState = Literal["no leaf", "open", "ajar", "closed"]
MIN_SIZE_DM = 20
"""Least width and depth of a room, and the width of the stairs' room on each storey [dm]."""
MIN_WIDTH_DM, MAX_DOOR_DM = 8, 10
"""Least width of any opening that one can walk through, and greatest width of a door or arch [dm]."""
_MIN_CONTACT_DM = 7
"""Least length of the wall between two rooms that touch [dm]; where a wall of this length is removed, a body can pass."""
_MIN_GAP_DM = 4
"""Least difference between the depths of a row and of a room in the row [dm]; closer depths are made equal."""
_MIN_STEM_DM = 12
"""Least length of a wall that has room for a door [dm]."""
_ROW_DM, _STACK_DM = 240, 360
"""If a row is at least `_ROW_DM` wide, the next room starts a new row. If a storey is at least `_STACK_DM` deep, requests
for a new row are ignored [dm]."""
_MARGIN_DM = 2
"""Least distance of an opening from the ends of its wall [dm]."""
_STAIRS_DM = 34
"""Length of the stairs' room on each storey [dm]."""
_ANGLES: dict[DoorState, float] = {"open": math.pi / 2, "ajar": 0.5, "closed": 0.0}
RectDm = tuple[int, int, int, int]
"""A rectangle of the plan: x0, y0, x1, y1 [dm]."""


@dataclass(frozen=True)
class OpeningRequest:
    """A request for an opening in the wall between a room and a neighbour."""

    kind: OpeningKind | None = "door"
    """Kind of the opening; None: no opening."""
    width_dm: int = MIN_WIDTH_DM
    """Requested width, reduced if the wall is too short [dm]. The kind "open" ignores it and removes the whole wall."""
    offset_dm: int = 0
    """Requested distance from the western or southern end of the wall [dm]; reduced if the wall is too short."""
    leaf: DoorState = "no leaf"
    """State of the door's leaf; a leaf that would hit something is left out."""
    hinge: Literal["start", "end"] = "start"
    """End of the opening at which the leaf hangs; the opening starts at its western or southern end."""
    into_first: bool = True
    """Whether the leaf swings into the room that was requested earlier, and not into the other room."""


@dataclass(frozen=True)
class RoomRequest:
    """A request for a room: its label, size, place and openings."""

    label: str
    width_dm: int = MIN_SIZE_DM
    depth_dm: int = MIN_SIZE_DM
    """Requested depth [dm]. The first room of a row sets the depth of the row, and no other room of the row is deeper."""
    start: Start = "beside"
    """Whether the room stands beside the previous room, or starts a new row or a new storey."""
    shape: Shape = "rectangle"
    height_m: float = 2.6
    """Height of the ceiling above the floor [m]; only the first room of a storey decides it."""
    way_in: OpeningRequest = OpeningRequest()
    """Opening to an earlier room, in the west or in the row below; if nobody can walk through the opening, a door is added
    beside it."""
    other: OpeningRequest = OpeningRequest(None)
    """Opening to the second neighbour, if rooms exist both in the west and in the row below; `way_in` leads to the first."""
    from_south: bool = False
    """Whether `way_in` leads to the row below and not to the room in the west, if rooms exist in both places."""


def grow(
    requests: Sequence[RoomRequest], *, max_storeys: int = 1, min_openness: float = 0.0, clutter: float | None = None
) -> HouseSpec:
    """Build the house described by a list of room requests.

    1. The list is split into at most `max_storeys` storeys, at the requests that start a new storey.
    2. The storeys are planned from the top down, because a storey has to be at least as large as the storey above it.
    3. Each plan becomes a storey: rooms, stairs in the west if there are several storeys, and openings in the walls where
       rooms touch.

    `clutter` says how much furniture is filled in; None: the house stays empty. `min_openness` is the least openness of
    every storey, in [0, 1]: at most the share 1 - `min_openness` of the length of all inner walls stays closed. A wall that
    would exceed this share is removed along its whole length.
    """
    floors: list[list[RoomRequest]] = []
    for request in requests:
        if not floors or (request.start == "storey" and len(floors) < max_storeys):
            floors.append([])
        floors[-1].append(request)
    bare = {"furniture": ()} if clutter is None else {}
    plans: list[_Plan] = []
    for level in reversed(range(len(floors))):
        first_number = 1 + sum(map(len, floors[:level]))
        plans.insert(0, _Plan.of(floors[level], first_number, plans[0].extent if plans else (0, 0)))
    storeys = [plan.storey(level, len(plans), min_openness, bare) for level, plan in enumerate(plans)]
    return HouseSpec(name="grown", clutter=1.0 if clutter is None else clutter, storeys=tuple(storeys))


@dataclass(frozen=True)
class _Placed:
    """A room with its position: a box [dm] with notches in its northern corners if it is L- or T-shaped."""

    id: str
    request: RoomRequest
    box: RectDm
    notch_east: bool
    notch_west: bool

    @property
    def notch(self) -> tuple[int, int]:
        """Width and depth of a notch: a third of the box's width and a third of its depth [dm]."""
        x0, y0, x1, y1 = self.box
        return (x1 - x0) // 3, (y1 - y0) // 3

    @property
    def top(self) -> tuple[int, int]:
        """West and east end (x) of the northernmost wall [dm]."""
        x0, _, x1, _ = self.box
        return x0 + self.notch_west * self.notch[0], x1 - self.notch_east * self.notch[0]

    @property
    def sides(self) -> tuple[int, int]:
        """North ends (y) of the western and of the eastern wall [dm]."""
        y1 = self.box[3]
        return y1 - self.notch_west * self.notch[1], y1 - self.notch_east * self.notch[1]

    @property
    def polygon(self) -> tuple[Point, ...]:
        """The corners, counter-clockwise [m]."""
        x0, y0, x1, y1 = self.box
        (left, right), (west, east) = self.top, self.sides
        corners = [(x0, y0), (x1, y0)]
        corners += [(x1, east), (right, east), (right, y1)] if self.notch_east else [(x1, y1)]
        corners += [(left, y1), (left, west), (x0, west)] if self.notch_west else [(x0, y1)]
        return tuple(_metres(corner) for corner in corners)

    def has_room_for(self, box: RectDm) -> bool:
        """Return whether a box [dm] lies in the room, at least 1 dm away from the notches."""
        x0, y0, x1, y1 = box
        (left, right), (west, east) = self.top, self.sides
        inside = self.box[0] <= x0 and self.box[1] <= y0 and x1 <= self.box[2] and y1 <= self.box[3]
        hits_east = self.notch_east and x1 + 1 > right and y1 + 1 > east
        hits_west = self.notch_west and x0 - 1 < left and y1 + 1 > west
        return inside and not hits_east and not hits_west


@dataclass(frozen=True)
class _Contact:
    """A stretch of wall between a room and a room that was placed before it, and the opening requested there."""

    rooms: tuple[_Placed, _Placed]
    """The two rooms; the first one was requested earlier."""
    along_x: bool
    """Whether the wall runs along x; otherwise along y."""
    at: int
    """The coordinate that is constant along the wall [dm]."""
    low: int
    """Lower end of the stretch along the wall [dm]."""
    high: int
    """Upper end of the stretch along the wall [dm]."""
    way: OpeningRequest
    needed: bool
    """Whether the room requested later is entered here, so that one must be able to walk through the opening."""

    @property
    def length(self) -> int:
        return self.high - self.low


@dataclass(frozen=True)
class _Plan:
    """The rooms of a storey with their positions, and the stretches of wall between them."""

    rooms: tuple[_Placed, ...]
    contacts: tuple[_Contact, ...]
    height_m: float

    @staticmethod
    def of(requests: Sequence[RoomRequest], first_number: int, bears: tuple[int, int]) -> "_Plan":
        """Plan a storey. `bears` is the width and depth of the storey above it [dm]; (0, 0): this is the top storey.

        Rooms are numbered from `first_number` on. The last room of each row and the last row are enlarged until they reach
        as far as the storey above.
        """
        rows: list[list[_Placed]] = []
        contacts: list[_Contact] = []
        y0, number, grouped = 0, first_number, _split_into_rows(requests)
        for row in grouped:
            depth = row[0].depth_dm if row is not grouped[-1] else max(row[0].depth_dm, bears[1] - y0)
            below = [room for room in rows[-1] if room.box[3] == y0] if rows else []
            rows.append([])
            for request in row:
                x0 = rows[-1][-1].box[2] if rows[-1] else 0
                least = bears[0] if request is row[-1] else 0
                box = (x0, y0, _east(max(x0 + request.width_dm, least), below), y0 + depth)
                room = _placed(f"{request.label} {number}", request, box, solid=bears > (0, 0), first=not rows[-1])
                contacts += _contacts(room, rows[-1][-1] if rows[-1] else None, below)
                rows[-1].append(room)
                number += 1
            y0 += depth
        return _Plan(tuple(room for row in rows for room in row), tuple(contacts), requests[0].height_m)

    @property
    def extent(self) -> tuple[int, int]:
        """Width and depth of the storey [dm]."""
        return max(room.box[2] for room in self.rooms), max(room.box[3] for room in self.rooms)

    def storey(self, level: int, levels: int, min_openness: float, more: Mapping[str, object]) -> StoreySpec:
        """Return the storey as a spec; `more` holds further fields of the spec.

        At least the share `min_openness` of the length of all walls between indoor rooms has to be open. The walls are
        visited in order and get the openings requested for them. If a wall's closed part would bring the total closed length
        above the limit, the wall is removed along its whole length instead. With `min_openness` 0, there is no limit.
        """
        rooms = [RoomSpec(id=room.id, label=room.request.label, polygon_m=room.polygon) for room in self.rooms]
        openings: list[OpeningSpec] = []
        swings: list[RectDm] = []
        if levels > 1:
            cell, ways = _stairs(level, levels, self.rooms[0].id)
            rooms.append(cell)
            openings += ways
            # No leaf may swing in front of the stairs.
            swings.append((0, 0, 2 * MAX_DOOR_DM, MIN_SIZE_DM))
        inner = [contact for contact in self.contacts if not _outdoor(contact)]
        closed_dm = (1.0 - min_openness) * sum(contact.length for contact in inner)
        for contact in self.contacts:
            here = _openings(contact, swings)
            if contact in inner and min_openness > 0.0:
                closed = contact.length - sum(_gap_dm(opening, self.height_m) for opening in here)
                if closed > closed_dm:
                    here, closed = [_opening(contact, "open", contact.low, contact.high)], 0.0
                closed_dm -= closed
            openings += here
        return StoreySpec(height_m=self.height_m, rooms=tuple(rooms), openings=tuple(openings), **more)  # type: ignore[arg-type]


def _split_into_rows(requests: Sequence[RoomRequest]) -> list[list[RoomRequest]]:
    """Split the requests of a storey into rows; `_ROW_DM` and `_STACK_DM` limit how long rows and how deep storeys get."""
    rows: list[list[RoomRequest]] = []
    for request in requests:
        full = bool(rows) and sum(room.width_dm for room in rows[-1]) >= _ROW_DM
        deep = sum(row[0].depth_dm for row in rows) >= _STACK_DM
        if not rows or full or (request.start == "row" and not deep):
            rows.append([])
        rows[-1].append(request)
    return rows


def _east(x1: int, below: Sequence["_Placed"]) -> int:
    """Return the x of the east end of a room: `x1`, or a position a little farther east [dm].

    The end is moved east until every wall end in the row below is either at the same x or at least `_MIN_CONTACT_DM` away.
    Two rooms then share either no wall or enough wall for an opening.
    """
    ends = [end for room in below for end in room.top]
    while any(0 < abs(x1 - end) < _MIN_CONTACT_DM for end in ends):
        x1 += 1
    return x1


def _placed(name: str, request: RoomRequest, box: RectDm, *, solid: bool, first: bool) -> _Placed:
    """Return a room with its position and notches, for a place `box` [dm] in a row.

    The first room of a row is as deep as the row, because the next row begins on top of it. On a storey below another storey
    (`solid`), all rooms are as deep as the row and have no notches, because the storey above needs support everywhere.
    """
    x0, y0, x1, y1 = box
    if solid:
        return _Placed(name, request, box, notch_east=False, notch_west=False)
    if not first and y1 - (y0 + request.depth_dm) >= _MIN_GAP_DM:
        y1 = y0 + request.depth_dm
    stem = (x1 - x0) - 2 * ((x1 - x0) // 3)
    is_t = request.shape == "T" and not first and stem >= _MIN_STEM_DM
    return _Placed(name, request, (x0, y0, x1, y1), notch_east=request.shape == "L" or is_t, notch_west=is_t)


def _contacts(room: _Placed, west: _Placed | None, below: Sequence[_Placed]) -> list[_Contact]:
    """Return the stretches of wall that a room shares with the room `west` of it and with rooms in the row `below`.

    The opening `way_in` goes to one of these two sides; the opening `other` goes to the second side, if rooms are on both.
    If several rooms of the row below touch the room, only the longest of these stretches gets an opening.
    """
    x0, y0, x1, _ = room.box
    spans = [(other, max(x0, other.top[0]), min(x1, other.top[1])) for other in below]
    south = sorted((span for span in spans if span[2] > span[1]), key=lambda span: span[1] - span[2])
    from_south = bool(south) and (west is None or (room.request.from_south and south[0][2] - south[0][1] >= _MIN_STEM_DM))
    contacts = []
    if west is not None:
        way = room.request.other if from_south else room.request.way_in
        contacts.append(_Contact((west, room), False, x0, y0, min(west.sides[1], room.sides[0]), way, not from_south))
    for k, (other, low, high) in enumerate(south):
        way = OpeningRequest(None) if k else room.request.way_in if from_south else room.request.other
        contacts.append(_Contact((other, room), True, y0, low, high, way, from_south and k == 0))
    return contacts


def _openings(contact: _Contact, swings: list[RectDm]) -> list[OpeningSpec]:
    """Return the openings in a stretch of wall; the swing areas of their leaves are added to `swings`."""
    way, low, high = contact.way, contact.low, contact.high
    if way.kind == "open":
        return [_opening(contact, "open", low, high)]
    openings = []
    if contact.needed and way.kind not in PASSABLE:
        openings.append(_opening(contact, "door", low + _MARGIN_DM, low + _MARGIN_DM + MIN_WIDTH_DM))
        low += _MARGIN_DM + MIN_WIDTH_DM
    width = min(way.width_dm, high - low - 2 * _MARGIN_DM)
    if way.kind in ("door", "arch"):
        width = min(width, MAX_DOOR_DM)
    if way.kind is None or width < MIN_WIDTH_DM:
        return openings
    start = low + _MARGIN_DM + min(way.offset_dm, high - low - 2 * _MARGIN_DM - width)
    leaf = _leaf(contact, start, start + width, swings) if way.kind == "door" else None
    return [*openings, _opening(contact, way.kind, start, start + width, leaf)]


def _leaf(contact: _Contact, start: int, stop: int, swings: list[RectDm]) -> LeafSpec | None:
    """Return the leaf requested for a door; None if no leaf was requested or its swing area is not free."""
    way, width = contact.way, stop - start
    if way.leaf == "no leaf":
        return None
    room = contact.rooms[0] if way.into_first else contact.rooms[1]
    near, far = (contact.at - width, contact.at) if way.into_first else (contact.at, contact.at + width)
    swing = (start, near, stop, far) if contact.along_x else (near, start, far, stop)
    if not room.has_room_for(swing) or any(overlap(swing, other) for other in swings):
        return None
    swings.append(swing)
    return LeafSpec(hinge=way.hinge, into=room.id, angle_rad=_ANGLES[way.leaf])


def _opening(contact: _Contact, kind: OpeningKind, low: int, high: int, leaf: LeafSpec | None = None) -> OpeningSpec:
    a, b = (low, contact.at), (high, contact.at)
    start, end = (a, b) if contact.along_x else (a[::-1], b[::-1])
    rooms = contact.rooms[0].id, contact.rooms[1].id
    return OpeningSpec(rooms=rooms, kind=kind, start_m=_metres(start), end_m=_metres(end), leaf=leaf)


def _gap_dm(opening: OpeningSpec, ceiling_m: float) -> float:
    """Return the length that an opening would have if it had the same area but reached from floor to ceiling [dm].

    Doors and arches count as 0. For arches this is too little, so the house becomes more open than requested, never less.
    """
    if opening.kind in ("door", "arch"):
        return 0.0
    low, high = opening.gap_m(ceiling_m)
    return 10.0 * opening.width_m * (high - low) / ceiling_m


def _outdoor(contact: _Contact) -> bool:
    return any(room.request.label in OUTDOOR_LABELS for room in contact.rooms)


def _stairs(level: int, levels: int, hall: str) -> tuple[RoomSpec, list[OpeningSpec]]:
    """Return the room of the stairs on a storey, to the west of the storey's first room `hall`, and its openings to `hall`.

    In the wall that both rooms share, the opening to the flight up is in the southern half, and the opening to the flight
    down is in the northern half.
    """
    name, depth = f"{STAIRS} {level}", MIN_SIZE_DM / 10
    corners = ((-_STAIRS_DM / 10, 0.0), (0.0, 0.0), (0.0, depth), (-_STAIRS_DM / 10, depth))
    ends = {"up": (0.05, depth / 2), "down": (depth / 2, depth - 0.05)}
    there = {"up": level + 1 < levels, "down": level > 0}
    openings = [
        OpeningSpec(rooms=(hall, name), kind="open", start_m=(0.0, low), end_m=(0.0, high), leads=leads)  # type: ignore[arg-type]
        for leads, (low, high) in ends.items()
        if there[leads]
    ]
    return RoomSpec(id=name, label=STAIRS, polygon_m=corners), openings


def _metres(point: tuple[int, int]) -> Point:
    return point[0] / 10, point[1] / 10
