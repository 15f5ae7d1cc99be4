"""`with_storey_on_top`: a house with one more storey, which repeats the plan of the top storey."""

import re
import zlib
from collections.abc import Mapping
from dataclasses import replace
from itertools import count

from pydantic import ValidationError

from worlds.errors import WorldsError
from worlds.labels import STAIRS
from worlds.openings.door_swings import hang_leaf, is_in_front
from worlds.openings.opening_draft import OpeningDraft, shared_walls
from worlds.spec import (
    MAX_ID_LENGTH,
    MAX_STOREYS,
    PASSABLE,
    HouseSpec,
    OpeningSpec,
    RoomSpec,
    StoreySpec,
    json_schema,
)
from worlds.spec_errors import explain, mistakes_error
from worlds.stairs.cells import cell_on, opening_that_leads
from worlds.walls import opening_span

_GARAGE, _STORAGE = "garage", "storage room"
_NUMBERED = re.compile(r"(.*) \d{1,9}\.(\d{1,9})")
_FRONT_M = 0.9
"""Least distance between a door leaf and the foot of a flight of stairs [m]."""
_MIN_SHARED_M = 0.7
"""Least width of the opening at the foot of the new flight of stairs [m], unless the opening to the flight below is
narrower."""


def with_storey_on_top(spec: HouseSpec) -> HouseSpec:
    """Return the house with another storey on top, to which the stairs continue.

    The new storey is a copy of the top storey without gardens; garages become storage rooms.

    1. Each staircase of flights gets an opening on the old top storey to the new flight, straight above the opening at the
       foot of the flight below, so that the new flight has the shape of that flight.
    2. Door leaves that would stand in front of these openings are hung differently, or removed.
    3. The copy gets new room ids, and with them furniture and finishes of its own; on a bare storey it is bare, too. Twin
       rooms (with equal seeds) stay twins.

    Raises `WorldsError` if no stairs reach the top storey, if no room lies at the foot of a new flight, if the house has
    `MAX_STOREYS` storeys already, or if the new house has more than `MAX_ROOMS` rooms.
    """
    top, below = spec.storeys[-1], spec.storeys[-2] if len(spec.storeys) > 1 else None
    cells = [room for room in top.rooms if room.label == STAIRS]
    if below is None or not cells:
        raise WorldsError("no stairs lead to the top storey, so none can lead on; valid: houses of two storeys or more")
    if len(spec.storeys) == MAX_STOREYS:
        raise WorldsError(f"the house has {MAX_STOREYS} storeys, the most that a house can have; valid: fewer")
    flights = [room for room in cells if room.climb == "flights"]
    ups = [_foot(spec, cell) for cell in flights]
    old = _leading_down(top, {cell.id for cell in flights})
    storeys = (*spec.storeys[:-1], _with_feet(old, ups), _copy(spec, top))
    data = spec.model_copy(update={"storeys": storeys}).model_dump(by_alias=True)
    try:
        return HouseSpec.model_validate(data)
    except ValidationError as error:
        raise mistakes_error("the house with one more storey", explain(error, data, json_schema())) from None


def _foot(spec: HouseSpec, cell: RoomSpec) -> OpeningSpec:
    """Return the opening on the top storey to the new flight of stairs, straight above the foot of the flight below.

    `cell` is the stairs' room on the top storey. Raises `WorldsError` if there is no flight below, or no room in front of
    the new opening.
    """
    level, top = len(spec.storeys) - 1, spec.storeys[-1]
    if (lower := cell_on(spec, level - 1, cell)) is None:
        raise WorldsError(f"stairs {cell.id!r} do not come from the storey below, so there is no flight to repeat")
    foot = opening_that_leads(spec, level - 1, lower, "up")
    axis, at, low, high = opening_span(foot)
    for room in top.rooms:
        for wall in shared_walls(cell, room) if room.id != cell.id else ():
            start, stop = max(low, wall.low), min(high, wall.high)
            if (wall.axis, wall.at) == (axis, at) and stop - start >= min(_MIN_SHARED_M, high - low) - 1e-6:
                ends = {"start_m": wall.point(start), "end_m": wall.point(stop)}
                # A leaf would swing into a room of the storey below.
                return foot.model_copy(update={"rooms": (room.id, cell.id), "leads": "up", "leaf": None, **ends})
    raise WorldsError(f"stairs {cell.id!r}: on storeys[{level}] no room lies in front of the foot of the new flight")


def _leading_down(top: StoreySpec, flights: set[str]) -> StoreySpec:
    """Return the storey with its openings to stairs marked as leading down, because other openings will lead up.

    `flights` are the ids of the rooms of stairs.
    """
    openings = list(top.openings)
    for i, opening in enumerate(openings):
        if opening.kind in PASSABLE and flights & {*opening.rooms}:
            openings[i] = opening.model_copy(update={"leads": "down"})
    return top.model_copy(update={"openings": tuple(openings)})


def _with_feet(top: StoreySpec, ups: list[OpeningSpec]) -> StoreySpec:
    """Return the storey with the openings `ups`; door leaves in front of these openings are hung differently or removed."""
    rooms = {room.id: room for room in top.rooms}
    openings = [*top.openings, *ups]
    gaps = [OpeningDraft.of(opening, rooms) for opening in openings]
    feet = gaps[len(top.openings) :]
    for k, gap in enumerate(gaps):
        if any(is_in_front(gap, foot, _FRONT_M) for foot in feet):
            gaps[k] = replace(gap, leaf=hang_leaf(gap, gaps, rooms, (0.5, 0.5)))
            openings[k] = gaps[k].spec()
    return top.model_copy(update={"openings": tuple(openings)})


def _copy(spec: HouseSpec, top: StoreySpec) -> StoreySpec:
    """Return the new storey: rooms and openings of the top storey with new ids.

    Windows and furniture are filled in when the house is built, or left out if the top storey has none.
    """
    level = len(spec.storeys)
    rooms = [room for room in top.rooms if room.label != "garden"]
    taken = {room.id for storey in spec.storeys for room in storey.rooms}
    names: dict[str, str] = {}
    for room in rooms:
        is_named_so = room.label == _GARAGE and room.id.startswith(_GARAGE)
        names[room.id] = _new_name(_STORAGE if is_named_so else room.id, level, taken)
        taken.add(names[room.id])
    return StoreySpec(
        height_m=top.height_m,
        rooms=tuple(_copied(room, names[room.id], level) for room in rooms),
        openings=tuple(_renamed(opening, names) for opening in top.openings if set(opening.rooms) <= set(names)),
        windows=() if top.windows == () else None,
        furniture=() if top.furniture == () else None,
    )


def _copied(room: RoomSpec, name: str, level: int) -> RoomSpec:
    """Return the copy of a room on a storey. A garage becomes a storage room, because a pantry may be reached through it."""
    label = _STORAGE if room.label == _GARAGE else room.label
    return room.model_copy(update={"id": name, "label": label, "seed": _new_seed(room.seed, level)})


def _new_name(name: str, level: int, taken: set[str]) -> str:
    """Return an unused id for the copy of a room, such as "bedroom 2.1" for "bedroom 1.1".

    A long name is cut before its number, so that the id has no more than `MAX_ID_LENGTH` characters.
    """
    match = _NUMBERED.fullmatch(name)
    stem = match[1] if match else name
    endings = (f" {level}.{number}" for number in count(int(match[2]) if match else 1))
    names = (stem[: MAX_ID_LENGTH - len(ending)] + ending for ending in endings)
    return next(name for name in names if name not in taken)


def _new_seed(seed: int | None, level: int) -> int | None:
    """Return the seed of a room's copy; None stays None.

    The new seed depends only on the seed of the room and on the storey, so that twins stay twins.
    """
    return None if seed is None else zlib.crc32(f"{seed} {level}".encode())


def _renamed(opening: OpeningSpec, names: Mapping[str, str]) -> OpeningSpec:
    a, b = opening.rooms
    leaf = opening.leaf and opening.leaf.model_copy(update={"into": names[opening.leaf.into]})
    return opening.model_copy(update={"rooms": (names[a], names[b]), "leaf": leaf})
