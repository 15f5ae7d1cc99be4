"""Steps that make a house simpler: each takes the spec of a house and yields smaller specs, the most simplified first.

Houses have to list their furniture and windows (`worlds.variant.explicit`). The results need not be valid: a room may have
become unreachable, for example. The caller has to validate the results. The rooms and pieces of furniture that a step
leaves in a house keep their ids. Rooms, windows and furniture also keep their shapes and positions; the steps that move
walls are in `wall_reductions`.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import TypeVar

from shapely.geometry import Polygon

from sim.harness.shrinking.house_edits import by_storey, keep_furniture, keep_rooms, rooms_of, with_storey, with_storeys
from worlds.labels import OUTDOOR_LABELS, ROOM_LABELS, STAIRS
from worlds.spec import PASSABLE, HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.stairs.cells import cell_on

HouseStep = Callable[[HouseSpec], Iterator[HouseSpec]]
DOOR_M = 0.9
"""Width of the door that replaces a wider opening [m]."""
EPS_M = 1e-6
_T = TypeVar("_T")


def fewer_storeys(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with each storey alone, then without the highest storey, and without the lowest storey.

    Stairs to a dropped storey are dropped as well.
    """
    for kept in dict.fromkeys(_storey_choices(len(spec.storeys))):
        yield from _if_any(keep_rooms(spec, {room.id for k in kept for room in spec.storeys[k].rooms}))


def _storey_choices(count: int) -> list[tuple[int, ...]]:
    if count == 1:
        return []
    return [*((k,) for k in range(count)), tuple(range(count - 1)), tuple(range(1, count))]


def fewer_rooms(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with some of its rooms: first with few rooms, and at last with all rooms but one.

    At first, only a staircase, the rooms beside it and the rooms below these rooms are kept. Then half of all rooms are
    kept, and then three quarters: a room and the rooms nearest to it, by the number of openings and stairs on the way, so
    that the kept rooms are connected. Finally, single rooms are dropped, from the highest storey down and large rooms first.
    A staircase is dropped as a whole.
    """
    near = _nearest_first(spec)
    count = len(near)
    sizes = [size for size in dict.fromkeys((count // 2, 3 * count // 4)) if 1 <= size < count - 1]
    kept = [ids for ids in _staircases(spec) if len(ids) < count - 1]
    kept += [frozenset(order[:size]) for size in sizes for order in near.values()]
    for level in reversed(range(len(spec.storeys))):
        rooms = sorted(spec.storeys[level].rooms, key=lambda room: -Polygon(room.polygon_m).area)
        kept += [frozenset(near) - _cells_of(spec, level, room) for room in rooms]
    for ids in dict.fromkeys(kept):
        yield from _if_any(keep_rooms(spec, ids))


def less_furniture(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with less furniture.

    All furniture is left out first, then each half of the pieces, each quarter, and so on down to each single piece.
    """
    ids = [piece.id for storey in spec.storeys for piece in storey.furniture or ()]
    for kept in without_parts(ids):
        yield keep_furniture(spec, set(kept))


def fewer_windows(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with fewer windows.

    All windows are left out first, then each half of the windows, each quarter, and so on down to each single window.
    """
    places = [(level, k) for level, storey in enumerate(spec.storeys) for k in range(len(storey.windows or ()))]
    for kept in without_parts(places):
        yield with_storeys(spec, [_keep_windows(storey, level, kept) for level, storey in enumerate(spec.storeys)])


def fewer_openings(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house without one opening, for each opening. A closed wall between the two rooms takes its place."""
    for level, storey in enumerate(spec.storeys):
        for k in range(len(storey.openings)):
            yield _with_openings(spec, level, (*storey.openings[:k], *storey.openings[k + 1 :]))


def simpler_openings(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with one opening replaced by a doorway without a door leaf, in the middle of the opening."""
    for level, storey in enumerate(spec.storeys):
        for k, opening in enumerate(storey.openings):
            if opening_rank(opening):
                yield _with_openings(spec, level, (*storey.openings[:k], _doorway(opening), *storey.openings[k + 1 :]))


def opening_rank(opening: OpeningSpec) -> int:
    """Return a number for the complexity of an opening; the simplest opening, a doorway without a door leaf, has 0."""
    ranks = ("door", "cased", "arch", "half wall", "counter", "open")
    return 2 * ranks.index(opening.kind) + (opening.leaf is not None)


def simpler_labels(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with all rooms of one label renamed to the simplest label that no room has.

    Simple labels come first in `ROOM_LABELS`. Labels of rooms with furniture stay: a bedroom that is called a kitchen would
    fail for another reason.
    """
    furnished = {piece.room for storey in spec.storeys for piece in storey.furniture or ()}
    fixed = {STAIRS, *OUTDOOR_LABELS, *(room.label for _, room in rooms_of(spec) if room.id in furnished)}
    present = set(spec.room_labels)
    for label in reversed(spec.room_labels):
        simplest = next(each for each in ROOM_LABELS if each not in present or each == label)
        if simplest != label and label not in fixed:
            yield _relabelled(spec, label, simplest)


def plain_appearance(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with daylight and rich textures, unless it has both."""
    plain = spec.appearance.model_copy(update={"light": "day", "texture": "rich"})
    if plain != spec.appearance:
        yield spec.model_copy(update={"appearance": plain})


def without_parts(items: Sequence[_T]) -> Iterator[list[_T]]:
    """Yield shortened copies of a list.

    All items are left out first, then each half of the items, each quarter, and so on down to each single item.
    """
    size = len(items)
    while size:
        yield from ([*items[:start], *items[start + size :]] for start in range(0, len(items), size))
        size = size // 2 if size < len(items) else (size + 1) // 2 if size > 1 else 0


def _keep_windows(storey: StoreySpec, level: int, places: Collection[tuple[int, int]]) -> StoreySpec:
    kept = tuple(window for k, window in enumerate(storey.windows or ()) if (level, k) in places)
    return storey.model_copy(update={"windows": kept})


def _relabelled(spec: HouseSpec, old: str, new: str) -> HouseSpec:
    def label(room: RoomSpec) -> RoomSpec:
        return room.model_copy(update={"label": new}) if room.label == old else room

    return by_storey(spec, lambda storey: {"rooms": tuple(map(label, storey.rooms))})


def _if_any(spec: HouseSpec | None) -> Iterator[HouseSpec]:
    if spec is not None:
        yield spec


def _with_openings(spec: HouseSpec, level: int, openings: Sequence[OpeningSpec]) -> HouseSpec:
    return with_storey(spec, level, spec.storeys[level].model_copy(update={"openings": tuple(openings)}))


def _cells_of(spec: HouseSpec, level: int, room: RoomSpec) -> frozenset[str]:
    """Return the id of a room in a set; for a room of stairs, the ids of the staircase's rooms on all storeys."""
    cells = [cell_on(spec, k, room) for k in range(len(spec.storeys))] if room.label == STAIRS else []
    return frozenset({room.id, *(cell.id for cell in cells if cell is not None)})


def _staircases(spec: HouseSpec) -> Iterator[frozenset[str]]:
    """Yield a set of room ids for each staircase.

    The set contains the rooms of the staircase on all storeys, the rooms that open into the staircase, and all rooms below
    these rooms.
    """
    openings = [opening.rooms for storey in spec.storeys for opening in storey.openings]
    for level, room in rooms_of(spec, stairs=True):
        if room.label == STAIRS:
            cells = _cells_of(spec, level, room)
            yield _with_support(spec, cells.union(*(rooms for rooms in openings if cells & set(rooms))))


def _with_support(spec: HouseSpec, ids: frozenset[str]) -> frozenset[str]:
    """Return the ids of some rooms together with the ids of all rooms below them, down to the lowest storey."""
    for level in range(len(spec.storeys) - 1, 0, -1):
        above = [Polygon(room.polygon_m) for room in spec.storeys[level].rooms if room.id in ids]
        below = ((room.id, Polygon(room.polygon_m)) for room in spec.storeys[level - 1].rooms)
        ids |= {room for room, floor in below if any(floor.intersection(each).area > EPS_M for each in above)}
    return ids


def _nearest_first(spec: HouseSpec) -> dict[str, list[str]]:
    """Return, for every room, the ids of all rooms that can be reached from it, the nearest first.

    The distance is the number of openings and stairs on the way.
    """
    beside: dict[str, list[str]] = {room.id: [] for _, room in rooms_of(spec, stairs=True)}
    pairs = [o.rooms for storey in spec.storeys for o in storey.openings if o.kind in PASSABLE]
    for level, room in rooms_of(spec, stairs=True):
        above = cell_on(spec, level + 1, room)
        pairs += [] if above is None else [(room.id, above.id)]
    for a, b in pairs:
        beside[a].append(b)
        beside[b].append(a)
    orders = {}
    for start in beside:
        order = [start]
        for room_id in order:  # grows while it is read: breadth first
            order += [other for other in dict.fromkeys(beside[room_id]) if other not in order]
        orders[start] = order
    return orders


def _doorway(opening: OpeningSpec) -> OpeningSpec:
    share = min(1.0, DOOR_M / opening.width_m) / 2
    (x0, y0), (x1, y1) = opening.start_m, opening.end_m
    ends = [(round(x0 + (x1 - x0) * t, 3), round(y0 + (y1 - y0) * t, 3)) for t in (0.5 - share, 0.5 + share)]
    return OpeningSpec(rooms=opening.rooms, kind="door", start_m=ends[0], end_m=ends[1], leads=opening.leads)
