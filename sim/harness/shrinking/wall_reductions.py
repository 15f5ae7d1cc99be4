"""Steps that move walls: each takes the spec of a house, and yields houses with rectangular, smaller or narrower rooms.

As in `house_reductions`, the results need not be valid.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

from shapely.geometry import Polygon, box

from sim.harness.shrinking.house_edits import by_storey, rooms_of, with_storey
from sim.harness.shrinking.house_reductions import DOOR_M, EPS_M
from worlds.labels import STAIRS
from worlds.spec import FurnitureSpec, HouseSpec, OpeningSpec, Point, RoomSpec, StoreySpec, WindowSpec
from worlds.stairs.cells import Bounds, bounds

_MIN_SIDE_M = 1.5
"""Least side length of a cropped room [m]."""
_MIN_INTERVAL_M = 1.0
"""Least distance between two walls after `narrower` has halved it [m]."""


def rectangular(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with one non-rectangular room cut down to one of the three largest rectangles inside the room."""
    for level, room in rooms_of(spec):
        if len(room.polygon_m) > 4:
            for rectangle in _rectangles(room)[:3]:
                yield _cut(spec, level, room, rectangle)


def cropped(spec: HouseSpec) -> Iterator[HouseSpec]:
    """Yield the house with one rectangular room cut down to one of its halves, along x or y."""
    for level, room in rooms_of(spec):
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


def _rectangles(room: RoomSpec) -> list[Bounds]:
    """Return the rectangles inside a room whose sides are at coordinates of the room's corners, the largest first."""
    outline = Polygon(room.polygon_m).buffer(EPS_M)
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
    return with_storey(spec, level, changed)


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
    return part if opening.kind == "open" and same_wall and part.width_m >= DOOR_M and _on_side(part, rest) else None


def _on_side(thing: OpeningSpec | WindowSpec, room: Bounds) -> bool:
    """Return whether an opening or a window lies in a side of a rectangle."""
    x0, y0, x1, y1 = room
    ends = (thing.start_m, thing.end_m)
    inside = all(x0 - EPS_M <= x <= x1 + EPS_M and y0 - EPS_M <= y <= y1 + EPS_M for x, y in ends)
    sides = ((0, x0), (0, x1), (1, y0), (1, y1))
    return inside and any(all(abs(end[axis] - at) <= EPS_M for end in ends) for axis, at in sides)


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
    corners = {corner[axis] for _, room in rooms_of(spec, stairs=True) for corner in room.polygon_m}
    openings = [opening for storey in spec.storeys for opening in storey.openings]
    marks = sorted(corners | {end[axis] for opening in openings for end in (opening.start_m, opening.end_m)})
    fixed = [sorted((o.start_m[axis], o.end_m[axis])) for o in openings if o.kind != "open"]
    fixed += [[bounds(r)[axis], bounds(r)[axis + 2]] for _, r in rooms_of(spec, stairs=True) if r.label == STAIRS]
    return [
        (low, high)
        for low, high in pairwise(marks)
        if high - low >= 2 * _MIN_INTERVAL_M and not any(a < high - EPS_M and b > low + EPS_M for a, b in fixed)
    ]


def _squeezed(spec: HouseSpec, axis: int, intervals: Sequence[tuple[float, float]]) -> HouseSpec:
    """Return the house with intervals along an axis halved; everything beyond an interval moves with the wall there."""

    def moved(point: tuple[float, ...]) -> tuple[float, ...]:
        value = point[axis]
        value -= sum(min(max(value - low, 0.0), high - low) / 2 for low, high in intervals)
        return (*point[:axis], round(value, 3), *point[axis + 1 :])

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

    return by_storey(spec, update)
