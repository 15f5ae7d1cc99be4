"""The visible faces of a house's shell (walls, floors, ceilings, reveals) as quads with texture coordinates in metres.

`surfaces` works in these steps:

1. Find the upright faces, which lie wherever a solid cell of the `ShellGrid` touches a free cell. Add the spandrels: the
   parts of a wall between the curve of an arch and the top of its opening, which are not part of the grid.
2. Unroll the walls of each room side by side onto one flat sheet, so that the texture of the sheet need not repeat.
3. Add the level faces (floors, ceilings, sills, tops of walls) and the curved undersides of arches.
"""

import itertools
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float64, Int

from worlds.house import House
from worlds.visuals.shell_grid import NOTHING, ShellGrid, shell_grid
from worlds.walls import HALF_WALL_M, WALL_THICKNESS_M, Boundary, arch_curve

SurfaceKind = Literal["wall", "floor", "ceiling"]
OUTSIDE = "(outside)"
"""Stands for the outside of the house where a room id is expected. It cannot equal a room id, since no id has brackets."""
SURFACE_KINDS: tuple[SurfaceKind, ...] = get_args(SurfaceKind)
_TOLERANCE_M = 1e-6
_Point = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Surface:
    """A planar quad, visible from the side on which its corners run counter-clockwise."""

    room: str
    """Id of the room that the face bounds, or `OUTSIDE`."""
    kind: SurfaceKind
    corners: Float64[np.ndarray, "4 3"]
    """Corners of the quad in the world frame W [m]."""
    uv: Float64[np.ndarray, "4 2"]
    """Positions of the corners on the flat sheet that carries the faces of this room and kind, without overlaps [m]."""


def surfaces(house: House) -> list[Surface]:
    """Return all faces of the shell. The walls of a room are unrolled onto one flat sheet, with holes where openings are.

    Every solid cell has a face on each side that borders a room or the outside. Only the top of the roof has no faces.
    """
    grid = shell_grid(house)
    planes: dict[_Plane, list[_Outline]] = defaultdict(list)
    for plane, outline in itertools.chain(_upright(grid, 0), _upright(grid, 1), _spandrels(house)):
        planes[plane].append(outline)
    unrolling = _Unrolling(house)
    faces = [face for plane in sorted(planes) for face in unrolling.panels(plane, planes[plane])]
    return [*faces, *_level(house, grid, unrolling), *_undersides(house, unrolling)]


_Plane = tuple[int, int, int, float]
"""An upright plane, seen from one room: index of this room (or the number of rooms, for the outside), axis of the plane's
normal (0: x, 1: y), sign of the normal, and coordinate of the plane on that axis [m]."""
_Outline = tuple[_Point, _Point, _Point, _Point]
"""Corners of a quad in an upright plane, as (x or y along the plane, z) [m]. The corners are counter-clockwise for a viewer
to whom the first coordinate increases to the right."""


class _Unrolling:
    """Lays the wall faces of each room side by side on one flat sheet per room, which gets one texture."""

    def __init__(self, house: House) -> None:
        self._names = [*(room.id for room in house.rooms), OUTSIDE]
        self._floors = [*(room.floor_m for room in house.rooms), house.storeys[0].floor_m]
        self._cursor = [0.0] * len(self._names)

    def panels(self, plane: _Plane, outlines: Sequence[_Outline]) -> Iterator[Surface]:
        """Place the faces in one upright plane on the sheet of their room. Faces that touch also touch on the sheet."""
        room, axis, facing, at = plane
        to_right = (facing > 0) == (axis == 0)
        for low, high, group in _runs(outlines):
            start = self._advance(room, high - low)
            for outline in group:
                ring = outline if to_right else (outline[1], outline[0], outline[3], outline[2])
                corners = [(at, a, z) if axis == 0 else (a, at, z) for a, z in ring]
                uv = [(start + (a - low if to_right else high - a), z - self._floors[room]) for a, z in ring]
                yield Surface(self._names[room], "wall", np.array(corners), np.array(uv))

    def strip(self, room: int, corners: Sequence[tuple[float, float, float]], length: float, width: float) -> Surface:
        """Place a rectangular face at a free position on its room's sheet. Its first edge is `length` [m] long."""
        u = self._advance(room, length)
        uv = np.array([(u, 0.0), (u + length, 0.0), (u + length, width), (u, width)])
        return Surface(self._names[room], "wall", np.array(corners), uv)

    def flat(self, room: int, kind: SurfaceKind, corners: Sequence[tuple[float, float, float]], origin: _Point) -> Surface:
        """Place a rectangle of a floor or ceiling on its sheet: the room's plan, moved so that `origin` is at (0, 0)."""
        points = np.array(corners)
        return Surface(self._names[room], kind, points, points[:, :2] - origin)

    def _advance(self, room: int, length: float) -> float:
        start = self._cursor[room]
        self._cursor[room] += length
        return start


def _runs(outlines: Sequence[_Outline]) -> Iterator[tuple[float, float, list[_Outline]]]:
    """Group outlines in one plane into stretches without gaps. Yield (start [m], end [m], outlines) for each stretch."""
    group: list[_Outline] = []
    low = high = 0.0
    for outline in sorted(outlines, key=lambda o: (o[0][0], o[0][1])):
        if group and outline[0][0] > high + _TOLERANCE_M:
            yield low, high, group
            group = []
        low, high = (low, max(high, outline[1][0])) if group else (outline[0][0], outline[1][0])
        group.append(outline)
    if group:
        yield low, high, group


def _upright(grid: ShellGrid, axis: int) -> Iterator[tuple[_Plane, _Outline]]:
    # A cell with the curve of an arch counts as solid along the wall's own direction, where it may touch another opening.
    # Across the wall it gets no grid face, because `_spandrels` draws the exact shape.
    solid, free = grid.solid | (grid.arch == 1 + axis), ~grid.solid & (grid.arch == 0)
    solid, free, room = (np.moveaxis(cells, axis, 0) for cells in (solid, free, grid.reveal))
    across, along, z = grid.planes[axis], grid.planes[1 - axis], grid.planes[2]
    for facing, inner, outer in ((1, slice(None, -1), slice(1, None)), (-1, slice(1, None), slice(None, -1))):
        labels = np.where(solid[inner] & free[outer], room[outer], NOTHING)
        for plane, a0, a1, b0, b1, label in _rectangles(labels):
            ends, heights = (float(along[a0]), float(along[a1])), (float(z[b0]), float(z[b1]))
            yield (label, axis, facing, float(across[plane + 1])), _rectangle(ends, heights)


def _rectangle(x: _Point, y: _Point) -> _Outline:
    return (x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])


def _rectangles(labels: Int[np.ndarray, "p a b"]) -> Iterator[tuple[int, int, int, int, int, int]]:
    """Cover the cells of every layer by rectangles of equal labels, except for cells with the label `NOTHING`.

    Yield (layer, a0, a1, b0, b1, label): the rectangle covers the cells `labels[layer, a0:a1, b0:b1]`. Stretches of equal
    labels along a are found first. Equal stretches at consecutive b are then merged into one rectangle.
    """
    edge = np.full((labels.shape[0], 1, labels.shape[2]), NOTHING, labels.dtype)
    padded = np.concatenate([edge, labels, edge], axis=1).swapaxes(1, 2)
    changes = padded[:, :, 1:] != padded[:, :, :-1]
    starts, ends = (np.argwhere(changes & (side != NOTHING)) for side in (padded[:, :, 1:], padded[:, :, :-1]))
    values = labels.swapaxes(1, 2)[tuple(starts.T)].tolist()
    growing: dict[tuple[int, int, int, int], tuple[int, int]] = {}
    for (layer, b, a0), a1, label in zip(starts.tolist(), ends[:, 2].tolist(), values, strict=True):
        run = (layer, a0, a1, label)
        first, last = growing.get(run, (b, b))
        if last < b:
            yield layer, a0, a1, first, last, label
            first = b
        growing[run] = first, b + 1
    for (layer, a0, a1, label), (first, last) in growing.items():
        yield layer, a0, a1, first, last, label


def _level(house: House, grid: ShellGrid, unrolling: _Unrolling) -> Iterator[Surface]:
    """Yield all level faces: floors, ceilings, roofs of lower storeys, and the tops and undersides of walls and sills."""
    x, y, z = grid.planes
    origins = [*(room.polygon.bounds[:2] for room in house.rooms), (float(x[0]), float(y[0]))]
    for facing in (1, -1):
        for plane, a0, a1, b0, b1, label in _rectangles(_level_labels(house, grid, facing)):
            room, kind = divmod(label, len(SURFACE_KINDS))
            plan = _rectangle((float(x[a0]), float(x[a1])), (float(y[b0]), float(y[b1])))
            width, depth = x[a1] - x[a0], y[b1] - y[b0]
            corners = [(*point, float(z[plane + 1])) for point in plan][::facing]
            if SURFACE_KINDS[kind] != "wall":
                yield unrolling.flat(room, SURFACE_KINDS[kind], corners, origins[room])
            elif width >= depth:
                yield unrolling.strip(room, corners, float(width), float(depth))
            else:
                yield unrolling.strip(room, [*corners[1:], corners[0]], float(depth), float(width))


def _level_labels(house: House, grid: ShellGrid, facing: int) -> Int[np.ndarray, "p a b"]:
    """Return a label for the level face in each plane across z at each cell of the plan; `NOTHING` where there is no face.

    A label stands for the room and the kind of the face: index of the room * number of kinds + index of the kind. `facing`
    is 1 for faces that look up, -1 for faces that look down.
    """
    solid, free = grid.solid | (grid.arch > 0), ~grid.solid & (grid.arch == 0)
    if facing < 0:
        solid = grid.solid
    inner, outer = (slice(None, -1), slice(1, None)) if facing > 0 else (slice(1, None), slice(None, -1))
    owner, z, outside = grid.owner[:, :, outer], grid.planes[2][1:-1], len(house.rooms)
    heights = [r.floor_m if facing > 0 else np.inf if r.outdoor else r.ceiling_m for r in house.rooms]
    own = np.abs(np.array([*heights, np.inf, np.inf])[owner] - z) < _TOLERANCE_M
    kind = np.where(own, 1 if facing > 0 else 2, 0)
    seen = solid[:, :, inner] & free[:, :, outer] & (owner != NOTHING)
    if facing > 0:
        roof = (owner == outside) & grid.slab[inner]
        kind[roof] = 1
        seen &= ~(roof & (z >= z[-1] - _TOLERANCE_M))
    room = np.where(kind == 0, grid.reveal[:, :, outer], owner).astype(int)
    return np.moveaxis(np.where(seen, len(SURFACE_KINDS) * room + kind, NOTHING), 2, 0)


def _arches(house: House) -> Iterator[tuple[Boundary, list[_Point], float]]:
    """Yield three values for each arch: its boundary, its curve and the z of its crown in W [m].

    The curve is a list of points (x or y along the boundary, z) in W [m].
    """
    for level, pieces in enumerate(house.boundaries):
        floor = house.storeys[level].floor_m
        for boundary, opening in pieces:
            if opening is not None and opening.kind == "arch":
                top = min(opening.height_m, house.wall_height(level, boundary))
                yield boundary, [(a, floor + z) for a, z in arch_curve(boundary, opening, top)], floor + top


def _room_on(house: House, boundary: Boundary, side: int) -> int:
    name = boundary.rooms[side]
    return len(house.rooms) if name is None else house.rooms.index(house.room_by_id[name])


def _spandrels(house: House) -> Iterator[tuple[_Plane, _Outline]]:
    for boundary, curve, top in _arches(house):
        for side, facing in ((0, -1), (1, 1)):
            plane = _room_on(house, boundary, side), 1 - boundary.axis, facing, round(boundary.at + facing * HALF_WALL_M, 6)
            for (a0, z0), (a1, z1) in itertools.pairwise(curve):
                if min(z0, z1) < top:
                    yield plane, ((a0, z0), (a1, z1), (a1, top), (a0, top))


def _undersides(house: House, unrolling: _Unrolling) -> Iterator[Surface]:
    """Yield the faces on the underside of each arch, which span the thickness of the wall."""
    for boundary, curve, _ in _arches(house):
        room = _room_on(house, boundary, 0 if boundary.rooms[0] is not None else 1)
        near, far = (boundary.at + s * HALF_WALL_M for s in ((1, -1) if boundary.axis == 0 else (-1, 1)))
        for (a0, z0), (a1, z1) in itertools.pairwise(curve):
            ring = [(a0, near, z0), (a1, near, z1), (a1, far, z1), (a0, far, z0)]
            corners = ring if boundary.axis == 0 else [(c, a, z) for a, c, z in ring]
            yield unrolling.strip(room, corners, float(np.hypot(a1 - a0, z1 - z0)), WALL_THICKNESS_M)
