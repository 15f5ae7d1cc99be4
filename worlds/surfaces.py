"""The visible faces of a house's shell: walls, floors, ceilings, reveals, as quads with metric texture coordinates."""

import itertools
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64
from shapely.geometry import Polygon

from worlds.house import House, Room
from worlds.labels import STAIRS
from worlds.walls import FENCE_HEIGHT_M, WALL_THICKNESS_M, Boundary

SurfaceKind = Literal["wall", "floor", "ceiling"]
OUTSIDE = "(outside)"
"""Not a possible room id."""
_HALF = WALL_THICKNESS_M / 2


@dataclass(frozen=True, eq=False)
class Surface:
    """A planar quad, visible from the side from which its corners run counter-clockwise."""

    room: str
    """Id of the room that it bounds, or `OUTSIDE`."""
    kind: SurfaceKind
    corners: Float64[np.ndarray, "4 3"]
    """In W [m]."""
    uv: Float64[np.ndarray, "4 2"]
    """Place on the (room, kind)'s own unrolled sheet [m]; no two faces share a place."""


def surfaces(house: House) -> list[Surface]:
    """All faces of the shell, room by room unrolled onto one sheet per (room, kind)."""
    faces = [*_floors_and_ceilings(house)]
    cursor: dict[str, float] = defaultdict(float)
    for level, pieces in enumerate(house.boundaries):
        for boundary, opening in pieces:
            clear = 0.0 if opening is None else _clear_height(house, level, opening.kind, opening.height_m)
            for side in (0, 1):
                faces += _wall_face(house, level, boundary, side, clear, cursor)
            if clear:
                faces += _reveal(house, level, boundary, clear, cursor)
    return faces


def _clear_height(house: House, level: int, kind: str, height_m: float) -> float:
    storey = house.storeys[level]
    return storey.ceiling_m - storey.floor_m if kind == "open" else height_m


def _wall_face(
    house: House, level: int, boundary: Boundary, side: int, clear: float, cursor: dict[str, float]
) -> Iterator[Surface]:
    room = None if (name := boundary.rooms[side]) is None else house.room_by_id[name]
    floor, top = house.storeys[level].floor_m, _face_top(house, level, boundary, room)
    if floor + clear >= top:
        return
    low, high = boundary.low, boundary.high
    if room is not None:
        low, high = _past_reflex_corners(boundary, room)
    # Seen from its own side a face's first corner is on the left.
    ends = (low, high) if (side == 0) == (boundary.axis == 0) else (high, low)
    offset = _HALF if side else -_HALF
    corners = [
        _at(boundary, along, offset, z)
        for along, z in [(ends[0], floor + clear), (ends[1], floor + clear), (ends[1], top), (ends[0], top)]
    ]
    yield _unrolled(room.id if room else OUTSIDE, corners, high - low, (clear, top - floor), cursor)
    if room is None or not room.outdoor:
        return
    if _is_fence(house, boundary) and side == 1:
        cap = [_at(boundary, a, o, top) for a, o in [(low, -_HALF), (high, -_HALF), (high, _HALF), (low, _HALF)]]
        yield _unrolled(room.id, cap if boundary.axis == 0 else cap[::-1], high - low, (0.0, WALL_THICKNESS_M), cursor)


def _reveal(house: House, level: int, boundary: Boundary, clear: float, cursor: dict[str, float]) -> Iterator[Surface]:
    """The wall's thickness as seen in an opening: two jambs and the lintel's underside."""
    name = next(room for room in boundary.rooms if room is not None)
    room, floor = house.room_by_id[name].id, house.storeys[level].floor_m
    for along, first in ((boundary.low, _HALF), (boundary.high, -_HALF)):
        first = first if boundary.axis == 0 else -first
        corners = [
            _at(boundary, along, o, z)
            for o, z in [(first, floor), (-first, floor), (-first, floor + clear), (first, floor + clear)]
        ]
        yield _unrolled(room, corners, WALL_THICKNESS_M, (0.0, clear), cursor)
    z = floor + clear
    under = [
        _at(boundary, a, o, z)
        for a, o in [(boundary.low, -_HALF), (boundary.low, _HALF), (boundary.high, _HALF), (boundary.high, -_HALF)]
    ]
    yield _unrolled(room, under if boundary.axis == 0 else under[::-1], boundary.length, (0.0, WALL_THICKNESS_M), cursor)


def _face_top(house: House, level: int, boundary: Boundary, room: Room | None) -> float:
    storey = house.storeys[level]
    if _is_fence(house, boundary):
        return storey.floor_m + FENCE_HEIGHT_M
    is_top = level + 1 == len(house.storeys)
    if room is not None and not room.outdoor and (room.label != STAIRS or room.ceiling_m <= storey.ceiling_m):
        return storey.ceiling_m
    # Stairs, gardens and the outside also see the edge of the slab above.
    return storey.ceiling_m + house.spec.slab_m if is_top else house.storeys[level + 1].floor_m


def _is_fence(house: House, boundary: Boundary) -> bool:
    return all(name is None or house.room_by_id[name].outdoor for name in boundary.rooms)


def _past_reflex_corners(boundary: Boundary, room: Room) -> tuple[float, float]:
    reflex = _reflex_corners(room.polygon)
    low = boundary.low - (_HALF if boundary.point(boundary.low) in reflex else 0.0)
    return low, boundary.high + (_HALF if boundary.point(boundary.high) in reflex else 0.0)


def _reflex_corners(polygon: Polygon) -> set[tuple[float, float]]:
    ring = np.array(polygon.exterior.coords[:-1])
    into, out = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turns_right = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0] < 0
    return {(float(x), float(y)) for x, y in ring[turns_right]}


def _at(boundary: Boundary, along: float, offset: float, z: float) -> tuple[float, float, float]:
    return (along, boundary.at + offset, z) if boundary.axis == 0 else (boundary.at + offset, along, z)


def _unrolled(
    room: str,
    corners: list[tuple[float, float, float]],
    length: float,
    heights: tuple[float, float],
    cursor: dict[str, float],
) -> Surface:
    u0, u1 = cursor[room], cursor[room] + length
    cursor[room] = u1
    uv = [(u0, heights[0]), (u1, heights[0]), (u1, heights[1]), (u0, heights[1])]
    return Surface(room, "wall", np.array(corners), np.array(uv))


def _floors_and_ceilings(house: House) -> Iterator[Surface]:
    for room in house.rooms:
        x_min, y_min, _, _ = room.polygon.bounds
        for x0, y0, x1, y1 in rectangles(room.polygon):
            plan = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
            uv = plan - (x_min, y_min)
            yield Surface(room.id, "floor", np.column_stack([plan, np.full(4, room.floor_m)]), uv)
            if not room.outdoor:
                yield Surface(
                    room.id, "ceiling", np.column_stack([plan, np.full(4, room.ceiling_m)])[::-1].copy(), uv[::-1].copy()
                )


def rectangles(polygon: Polygon) -> list[tuple[float, float, float, float]]:
    """A rectilinear polygon as rectangles (x0, y0, x1, y1) [m] that tile it."""
    ring = np.array(polygon.exterior.coords)
    xs, ys = np.unique(ring[:, 0]), np.unique(ring[:, 1])
    if len(xs) == len(ys) == 2:
        return [(float(xs[0]), float(ys[0]), float(xs[1]), float(ys[1]))]
    cells = [(x0, y0, x1, y1) for x0, x1 in itertools.pairwise(xs) for y0, y1 in itertools.pairwise(ys)]
    return [tuple(map(float, c)) for c in cells if polygon.contains(Polygon.from_bounds(*c).centroid)]  # type: ignore[misc]
