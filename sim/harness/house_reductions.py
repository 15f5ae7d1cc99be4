"""Steps that make a house simpler: each takes the spec of a house and yields smaller specs, the most simplified first.

Houses have to list their furniture and windows (`worlds.variant.explicit`). The results need not be valid: a room may have
become unreachable, for example. The caller has to validate the results. The rooms and pieces of furniture that a step
leaves in a house keep their ids. Rooms, windows and furniture also keep their shapes and positions, except in the steps
`rectangular`, `cropped` and `narrower`.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import combinations, pairwise
from typing import TypeVar

from shapely.geometry import Polygon, box

from worlds.labels import OUTDOOR_LABELS, ROOM_LABELS, STAIRS
from worlds.spec import PASSABLE, FurnitureSpec, HouseSpec, OpeningSpec, Point, RoomSpec, StoreySpec, WindowSpec
from worlds.stairs.cells import Bounds, bounds, cell_on

HouseStep = Callable[[HouseSpec], Iterator[HouseSpec]]
_DOOR_M = 0.9
"""Width of the door that replaces a wider opening [m]."""
_MIN_SIDE_M = 1.5
"""Least side length of a cropped room [m]."""
_MIN_INTERVAL_M = 1.0
"""Least distance between two walls after `narrower` has halved it [m]."""
_EPS_M = 1e-6
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
        yield _with_storeys(spec, [_keep_windows(storey, level, kept) for level, storey in enumerate(spec.storeys)])


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


def rectangular(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with one non-rectangular room cut down to one of the three largest rectangles inside the room."""
    for level, room in _rooms(spec):
        if len(room.polygon_m) > 4:
            for rectangle in _rectangles(room)[:3]:
                yield _cut(spec, level, room, rectangle)


def cropped(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with one rectangular room cut down to one of its halves, along x or y."""
    for level, room in _rooms(spec):
        if len(room.polygon_m) == 4:
            for half in _halves(bounds(room)):
                yield _cut(spec, level, room, half)


def narrower(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with halved distances between walls along x or y.

    First, all distances that can be halved are halved together, then each of them alone. Stairs keep their size, and
    openings their width. Only openings of the kind "open", which are removed walls, shrink.
    """
    for axis in (0, 1):
        loose = _loose_intervals(spec, axis)
        for chosen in [loose, *([interval] for interval in loose if len(loose) > 1)]:
            if chosen:
                yield _squeezed(spec, axis, chosen)


def simpler_labels(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with all rooms of one label renamed to the simplest label that no room has.

    Simple labels come first in `ROOM_LABELS`. Labels of rooms with furniture stay: a bedroom that is called a kitchen would
    fail for another reason.
    """
    furnished = {piece.room for storey in spec.storeys for piece in storey.furniture or ()}
    fixed = {STAIRS, *OUTDOOR_LABELS, *(room.label for _, room in _rooms(spec) if room.id in furnished)}
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


def keep_furniture(spec: HouseSpec, ids: Collection[str]) -> HouseSpec:
    """Return the house with only the furniture of the given ids."""
    return _by_storey(spec, lambda storey: {"furniture": tuple(p for p in storey.furniture or () if p.id in ids)})


def keep_rooms(spec: HouseSpec, ids: Collection[str]) -> HouseSpec | None:
    """Return the house with only the rooms of the given ids, and their openings, windows and furniture.

    Stairs that lead nowhere any more are dropped, and so are empty storeys at the top or the bottom. The result is None if
    no room is left, or if a storey between two others is empty.
    """
    spec = _with_storeys(spec, [_kept(storey, ids) for storey in spec.storeys])
    levels = [level for level, storey in enumerate(spec.storeys) if storey.rooms]
    if not levels or len(levels) != levels[-1] - levels[0] + 1:
        return None
    spec = _with_storeys(spec, spec.storeys[levels[0] : levels[-1] + 1])
    alone = {
        room.id
        for level, storey in enumerate(spec.storeys)
        for room in storey.rooms
        if room.label == STAIRS and not any(cell_on(spec, level + step, room) for step in (-1, 1))
    }
    if alone:
        return keep_rooms(spec, {room.id for _, room in _rooms(spec, stairs=True)} - alone)
    return _with_storeys(
        spec,
        [
            storey.model_copy(update={"openings": tuple(o for o in storey.openings if _leads_somewhere(spec, level, o))})
            for level, storey in enumerate(spec.storeys)
        ],
    )


def _kept(storey: StoreySpec, ids: Collection[str]) -> StoreySpec:
    return storey.model_copy(
        update={
            "rooms": tuple(room for room in storey.rooms if room.id in ids),
            "openings": tuple(opening for opening in storey.openings if set(opening.rooms) <= set(ids)),
            "windows": None if storey.windows is None else tuple(w for w in storey.windows if w.room in ids),
            "furniture": None if storey.furniture is None else tuple(p for p in storey.furniture if p.room in ids),
        }
    )


def _keep_windows(storey: StoreySpec, level: int, places: Collection[tuple[int, int]]) -> StoreySpec:
    kept = tuple(window for k, window in enumerate(storey.windows or ()) if (level, k) in places)
    return storey.model_copy(update={"windows": kept})


def _relabelled(spec: HouseSpec, old: str, new: str) -> HouseSpec:
    def label(room: RoomSpec) -> RoomSpec:
        return room.model_copy(update={"label": new}) if room.label == old else room

    return _by_storey(spec, lambda storey: {"rooms": tuple(map(label, storey.rooms))})


def _leads_somewhere(spec: HouseSpec, level: int, opening: OpeningSpec) -> bool:
    if opening.leads is None:
        return True
    step = 1 if opening.leads == "up" else -1
    cells = [room for room in spec.storeys[level].rooms if room.id in opening.rooms and room.label == STAIRS]
    return any(cell_on(spec, level + step, cell) for cell in cells)


def _if_any(spec: HouseSpec | None) -> Iterator[HouseSpec]:
    if spec is not None:
        yield spec


def _with_storeys(spec: HouseSpec, storeys: Sequence[StoreySpec]) -> HouseSpec:
    return spec.model_copy(update={"storeys": tuple(storeys)})


def _by_storey(spec: HouseSpec, update: Callable[[StoreySpec], dict[str, object]]) -> HouseSpec:
    return _with_storeys(spec, [storey.model_copy(update=update(storey)) for storey in spec.storeys])


def _with_openings(spec: HouseSpec, level: int, openings: Sequence[OpeningSpec]) -> HouseSpec:
    return _with_storey(spec, level, spec.storeys[level].model_copy(update={"openings": tuple(openings)}))


def _with_storey(spec: HouseSpec, level: int, storey: StoreySpec) -> HouseSpec:
    return _with_storeys(spec, (*spec.storeys[:level], storey, *spec.storeys[level + 1 :]))


def _rooms(spec: HouseSpec, stairs: bool = False) -> Iterator[tuple[int, RoomSpec]]:
    """Yield the level and the room for all rooms; `stairs` says whether stairs are included."""
    for level, storey in enumerate(spec.storeys):
        yield from ((level, room) for room in storey.rooms if stairs or room.label != STAIRS)


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
    for level, room in _rooms(spec, stairs=True):
        if room.label == STAIRS:
            cells = _cells_of(spec, level, room)
            yield _with_support(spec, cells.union(*(rooms for rooms in openings if cells & set(rooms))))


def _with_support(spec: HouseSpec, ids: frozenset[str]) -> frozenset[str]:
    """Return the ids of some rooms together with the ids of all rooms below them, down to the lowest storey."""
    for level in range(len(spec.storeys) - 1, 0, -1):
        above = [Polygon(room.polygon_m) for room in spec.storeys[level].rooms if room.id in ids]
        below = ((room.id, Polygon(room.polygon_m)) for room in spec.storeys[level - 1].rooms)
        ids |= {room for room, floor in below if any(floor.intersection(each).area > _EPS_M for each in above)}
    return ids


def _nearest_first(spec: HouseSpec) -> dict[str, list[str]]:
    """Return, for every room, the ids of all rooms that can be reached from it, the nearest first.

    The distance is the number of openings and stairs on the way.
    """
    beside: dict[str, list[str]] = {room.id: [] for _, room in _rooms(spec, stairs=True)}
    pairs = [o.rooms for storey in spec.storeys for o in storey.openings if o.kind in PASSABLE]
    for level, room in _rooms(spec, stairs=True):
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
    share = min(1.0, _DOOR_M / opening.width_m) / 2
    (x0, y0), (x1, y1) = opening.start_m, opening.end_m
    ends = [(_rounded(x0 + (x1 - x0) * t), _rounded(y0 + (y1 - y0) * t)) for t in (0.5 - share, 0.5 + share)]
    return OpeningSpec(rooms=opening.rooms, kind="door", start_m=ends[0], end_m=ends[1], leads=opening.leads)


def _rounded(value: float) -> float:
    return round(value, 3)


def _rectangles(room: RoomSpec) -> list[Bounds]:
    """Return the rectangles inside a room whose sides are at coordinates of the room's corners, the largest first."""
    outline = Polygon(room.polygon_m).buffer(_EPS_M)
    xs, ys = (sorted(set(values)) for values in zip(*room.polygon_m, strict=True))
    found = [(x0, y0, x1, y1) for x0, x1 in combinations(xs, 2) for y0, y1 in combinations(ys, 2)]
    inside = [each for each in found if outline.contains(box(*each))]
    return sorted(inside, key=lambda b: -(b[2] - b[0]) * (b[3] - b[1]))


def _halves(room: Bounds) -> Iterator[Bounds]:
    x0, y0, x1, y1 = room
    x, y = round((x0 + x1) / 2, 2), round((y0 + y1) / 2, 2)
    if x1 - x0 >= 2 * _MIN_SIDE_M:
        yield from ((x0, y0, x, y1), (x, y0, x1, y1))
    if y1 - y0 >= 2 * _MIN_SIDE_M:
        yield from ((x0, y0, x1, y), (x0, y, x1, y1))


def _cut(spec: HouseSpec, level: int, room: RoomSpec, rest: Bounds) -> HouseSpec:
    """Return the house with a room cut down to the rectangle `rest`. Openings, windows and furniture outside are dropped."""
    x0, y0, x1, y1 = rest
    storey = spec.storeys[level]
    smaller = room.model_copy(update={"polygon_m": ((x0, y0), (x1, y0), (x1, y1), (x0, y1))})
    openings = [_clipped(o, rest) if room.id in o.rooms else o for o in storey.openings]
    windows = [w for w in storey.windows or () if w.room != room.id or _on_side(w, rest)]
    furniture = [p for p in storey.furniture or () if p.room != room.id or _stands_in(p, rest)]
    changed = storey.model_copy(
        update={
            "rooms": tuple(smaller if each.id == room.id else each for each in storey.rooms),
            "openings": tuple(opening for opening in openings if opening is not None),
            "windows": None if storey.windows is None else tuple(windows),
            "furniture": None if storey.furniture is None else tuple(furniture),
        }
    )
    return _with_storey(spec, level, changed)


def _clipped(opening: OpeningSpec, rest: Bounds) -> OpeningSpec | None:
    """Return the part of an opening that lies in a side of the rectangle `rest`.

    An opening that lies there completely stays as it is. Only a removed wall (kind "open") may be shortened. The result is
    None if nothing remains, or if the remaining part is narrower than a door.
    """
    if _on_side(opening, rest):
        return opening
    x0, y0, x1, y1 = rest

    def clip(point: Point) -> Point:
        return min(max(point[0], x0), x1), min(max(point[1], y0), y1)

    part = opening.model_copy(update={"start_m": clip(opening.start_m), "end_m": clip(opening.end_m)})
    same_wall = any(opening.start_m[k] == opening.end_m[k] == part.start_m[k] for k in (0, 1))
    return part if opening.kind == "open" and same_wall and part.width_m >= _DOOR_M and _on_side(part, rest) else None


def _on_side(thing: OpeningSpec | WindowSpec, room: Bounds) -> bool:
    """Return whether an opening or a window lies in a side of a rectangle."""
    x0, y0, x1, y1 = room
    ends = (thing.start_m, thing.end_m)
    inside = all(x0 - _EPS_M <= x <= x1 + _EPS_M and y0 - _EPS_M <= y <= y1 + _EPS_M for x, y in ends)
    sides = ((0, x0), (0, x1), (1, y0), (1, y1))
    return inside and any(all(abs(end[axis] - at) <= _EPS_M for end in ends) for axis, at in sides)


def _stands_in(piece: FurnitureSpec, room: Bounds) -> bool:
    """Return whether a piece of furniture is in a rectangle.

    A piece that stands on the floor counts as a circle as wide as its longer side. A piece that hangs counts as its centre
    alone.
    """
    (x, y, z), (width, depth, _) = piece.position_m, piece.size_m
    reach = 0.0 if z else max(width, depth) / 2
    return room[0] <= x - reach and x + reach <= room[2] and room[1] <= y - reach and y + reach <= room[3]


def _loose_intervals(spec: HouseSpec, axis: int) -> list[tuple[float, float]]:
    """Return the intervals (low, high) along an axis (0: x, 1: y) that may be halved [m].

    An interval lies between neighbouring coordinates of walls and ends of openings.
    """
    corners = {corner[axis] for _, room in _rooms(spec, stairs=True) for corner in room.polygon_m}
    openings = [opening for storey in spec.storeys for opening in storey.openings]
    marks = sorted(corners | {end[axis] for opening in openings for end in (opening.start_m, opening.end_m)})
    fixed = [sorted((o.start_m[axis], o.end_m[axis])) for o in openings if o.kind != "open"]
    fixed += [[bounds(r)[axis], bounds(r)[axis + 2]] for _, r in _rooms(spec, stairs=True) if r.label == STAIRS]
    return [
        (low, high)
        for low, high in pairwise(marks)
        if high - low >= 2 * _MIN_INTERVAL_M and not any(a < high - _EPS_M and b > low + _EPS_M for a, b in fixed)
    ]


def _squeezed(spec: HouseSpec, axis: int, intervals: Sequence[tuple[float, float]]) -> HouseSpec:
    """Return the house with intervals along an axis halved; everything beyond an interval moves with the wall there."""

    def moved(point: tuple[float, ...]) -> tuple[float, ...]:
        value = point[axis]
        value -= sum(min(max(value - low, 0.0), high - low) / 2 for low, high in intervals)
        return (*point[:axis], _rounded(value), *point[axis + 1 :])

    def ends(thing: OpeningSpec | WindowSpec) -> dict[str, object]:
        return {"start_m": moved(thing.start_m), "end_m": moved(thing.end_m)}

    def update(s: StoreySpec) -> dict[str, object]:
        pieces = [p.model_copy(update={"position_m": moved(p.position_m)}) for p in s.furniture or ()]
        windows = [w.model_copy(update=ends(w)) for w in s.windows or ()]
        return {
            "rooms": tuple(r.model_copy(update={"polygon_m": tuple(map(moved, r.polygon_m))}) for r in s.rooms),
            "openings": tuple(o.model_copy(update=ends(o)) for o in s.openings),
            "windows": None if s.windows is None else tuple(windows),
            "furniture": None if s.furniture is None else tuple(pieces),
        }

    return _by_storey(spec, update)
