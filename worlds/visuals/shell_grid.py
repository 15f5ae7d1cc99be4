"""`ShellGrid`: an irregular grid of cells that marks the solid parts of a house (walls, slabs, roof).

The planes of the grid are the faces of walls, floors and ceilings, so every cell is entirely solid or entirely free. A face
of the shell lies wherever a solid cell touches a free one, so the shell is closed by construction.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int
from shapely.geometry import Polygon

from worlds.arches import arch_rise
from worlds.house import House
from worlds.labels import STAIRS
from worlds.rectangles import cells_inside
from worlds.spec import OpeningSpec
from worlds.walls import HALF_WALL_M, Boundary

NOTHING = -1
"""Value of `ShellGrid.owner` for cells below the ground, where no surface is visible."""
_MARGIN_M = 1.0
_DECIMALS = 6
_TOLERANCE_M = 1e-6
_Cells = tuple[slice, slice, slice]
_Box = tuple[float, float, float, float, float, float]
"""Bounds x0, y0, x1, y1, z0, z1 [m]."""


@dataclass(frozen=True, eq=False)
class ShellGrid:
    """An irregular grid that divides the space around a house into box-shaped cells, each of them solid or free.

    The cells lie between consecutive `planes`, which are perpendicular to the x, y and z axes.
    """

    planes: tuple[Float64[np.ndarray, "px"], Float64[np.ndarray, "py"], Float64[np.ndarray, "pz"]]
    """Coordinates of the planes perpendicular to x, y and z [m], ascending."""
    solid: Bool[np.ndarray, "nx ny nz"]
    """Whether a cell is inside a wall or slab. Openings are free."""
    slab: Bool[np.ndarray, "nz"]
    """For each layer of cells along z, whether it is at the height of a slab: between two storeys, below the lowest storey,
    or above the highest storey."""
    arch: Int[np.ndarray, "nx ny nz"]
    """Whether the curve of an arch passes through a cell: 0 if not, 1 in a wall along x, 2 in a wall along y."""
    owner: Int[np.ndarray, "nx ny nz"]
    """Index into `house.rooms` of the room that a free cell is in; `len(house.rooms)` for cells outside of all rooms, and
    `NOTHING` for cells below the ground."""
    reveal: Int[np.ndarray, "nx ny nz"]
    """Like `owner`, but all cells of an opening belong to one room. The reveals of the opening (its inner faces, which span
    the thickness of the wall) therefore get one texture."""


def shell_grid(house: House) -> ShellGrid:
    """Build the grid that says which cells of a house are solid, and to which room each free cell belongs.

    1. Divide space into cells along all faces of walls, openings, floors and ceilings.
    2. Fill the slabs and the walls as solid.
    3. Assign every cell of a storey to a room, to the outside or to the ground.
    4. Give each opening to one room, and mark the cells through which the curve of an arch passes.
    """
    walls = [(*wall.bounds, wall.bottom_m, wall.top_m) for wall in house.walls if not wall.spandrel]
    gaps = list(_gaps(house))
    planes = _planes(house, [*walls, *(gap.box for gap in gaps), *(gap.curve for gap in gaps)])
    plans = [_plan(house, level, planes) for level in range(len(house.storeys))]
    solid, slab = _slabs(house, planes, plans, walls)
    for cells in _cells(planes, walls):
        solid[cells] = True
    owner = _owners(house, planes, plans)
    reveal, arch = owner.copy(), np.zeros(owner.shape, np.int8)
    for gap, cells, curve in zip(
        gaps, _cells(planes, [gap.box for gap in gaps]), _cells(planes, [gap.curve for gap in gaps]), strict=True
    ):
        reveal[cells] = gap.room
        arch[curve] = np.where(solid[curve], 0, 1 + gap.axis)
    return ShellGrid(planes, solid, slab, arch, owner, reveal)


@dataclass(frozen=True)
class _Gap:
    axis: int
    room: int
    box: _Box
    curve: _Box
    """For an arch, the upper part of `box`, which contains the curve. For other kinds of openings, a part of zero height."""


def _gaps(house: House) -> Iterator[_Gap]:
    index = {room.id: i for i, room in enumerate(house.rooms)}
    for level, pieces in enumerate(house.boundaries):
        for boundary, opening in pieces:
            if opening is not None and opening.kind != "open":
                room = next(name for name in boundary.rooms if name is not None)
                yield _gap(house, level, boundary, opening, index[house.room_by_id[room].id])


def _gap(house: House, level: int, boundary: Boundary, opening: OpeningSpec, room: int) -> _Gap:
    floor, height = house.storeys[level].floor_m, house.wall_height(level, boundary)
    low, high = opening.gap_m(height)
    high = min(high, height)
    low = min(low, high)
    spring = min(opening.height_m - arch_rise(opening.width_m), high) if opening.kind == "arch" else high
    (x0, y0), (x1, y1) = boundary.point(boundary.low), boundary.point(boundary.high)
    dx, dy = (0.0, HALF_WALL_M) if boundary.axis == 0 else (HALF_WALL_M, 0.0)
    plan = x0 - dx, y0 - dy, x1 + dx, y1 + dy
    return _Gap(boundary.axis, room, (*plan, floor + low, floor + high), (*plan, floor + spring, floor + high))


def _planes(
    house: House, boxes: Sequence[_Box]
) -> tuple[Float64[np.ndarray, "px"], Float64[np.ndarray, "py"], Float64[np.ndarray, "pz"]]:
    table = np.array(boxes).reshape(-1, 6)
    corners = np.array([corner for storey in house.spec.storeys for room in storey.rooms for corner in room.polygon_m])
    heights = [z for storey in house.storeys for z in (storey.floor_m, storey.ceiling_m)]
    heights += [house.storeys[0].floor_m - house.spec.slab_m, house.storeys[-1].ceiling_m + house.spec.slab_m]
    x, y, z = (
        np.unique(np.round(np.concatenate([table[:, columns].ravel(), more]), _DECIMALS))
        for columns, more in (([0, 2], corners[:, 0]), ([1, 3], corners[:, 1]), ([4, 5], heights))
    )
    return _with_margin(x), _with_margin(y), _with_margin(z)


def _with_margin(planes: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "_"]:
    return np.concatenate([planes[:1] - _MARGIN_M, planes, planes[-1:] + _MARGIN_M])


def _cells(planes: Sequence[Float64[np.ndarray, "_"]], boxes: Sequence[_Box]) -> Iterator[_Cells]:
    """Yield the cells inside each box, as slices along x, y and z. The faces of the boxes must lie on planes of the grid."""
    table = np.round(np.array(boxes).reshape(-1, 6), _DECIMALS)
    x, y, z = (np.searchsorted(p, table[:, c]) for p, c in zip(planes, ([0, 2], [1, 3], [4, 5]), strict=True))
    for (i0, i1), (j0, j1), (k0, k1) in zip(x.tolist(), y.tolist(), z.tolist(), strict=True):
        yield slice(i0, i1), slice(j0, j1), slice(k0, k1)


def _plan(house: House, level: int, planes: Sequence[Float64[np.ndarray, "_"]]) -> Int[np.ndarray, "nx ny"]:
    """Return, for each cell of a storey's plan, the index of the room that covers the cell; `len(house.rooms)` for none."""
    plan = np.full((len(planes[0]) - 1, len(planes[1]) - 1), len(house.rooms), np.int16)
    index = {room.id: i for i, room in enumerate(house.rooms)}
    for spec in house.spec.storeys[level].rooms:
        room = house.room_by_id[spec.id]
        plan[_covered(room.polygon, planes)] = index[room.id]
    return plan


def _covered(polygon: Polygon, planes: Sequence[Float64[np.ndarray, "_"]]) -> Bool[np.ndarray, "nx ny"]:
    """Return which cells of the plan are inside a rectilinear polygon."""
    x, y = (np.round(np.asarray(c)[:-1], _DECIMALS) for c in polygon.exterior.coords.xy)
    size = len(planes[0]) - 1, len(planes[1]) - 1
    return cells_inside(np.searchsorted(planes[0], x), np.searchsorted(planes[1], y), size)


def _layers(planes: Sequence[Float64[np.ndarray, "_"]], low: float, high: float) -> slice:
    return slice(*np.searchsorted(planes[2], np.round([low, high], _DECIMALS)).tolist())


def _owners(
    house: House, planes: Sequence[Float64[np.ndarray, "_"]], plans: Sequence[Int[np.ndarray, "nx ny"]]
) -> Int[np.ndarray, "nx ny nz"]:
    owner = np.full((*plans[0].shape, len(planes[2]) - 1), len(house.rooms), np.int16)
    tops = [storey.floor_m for storey in house.storeys[1:]] + [house.storeys[-1].ceiling_m + house.spec.slab_m]
    for storey, top, plan in zip(house.storeys, tops, plans, strict=True):
        owner[:, :, _layers(planes, storey.floor_m, top)] = plan[:, :, None]
    owner[:, :, : _layers(planes, house.storeys[0].floor_m, tops[-1]).start] = NOTHING
    return owner


def _slabs(
    house: House,
    planes: Sequence[Float64[np.ndarray, "_"]],
    plans: Sequence[Int[np.ndarray, "nx ny"]],
    walls: Sequence[_Box],
) -> tuple[Bool[np.ndarray, "nx ny nz"], Bool[np.ndarray, "nz"]]:
    """Return whether each cell belongs to a slab, and whether each layer of cells along z is at the height of a slab.

    There is a slab below every room and above every indoor room. It reaches to the outer faces of the walls, and has a hole
    where a staircase passes through it.
    """
    solid, slab = np.zeros((*plans[0].shape, len(planes[2]) - 1), bool), np.zeros(len(planes[2]) - 1, bool)
    nothing = np.full_like(plans[0], len(house.rooms))
    indoors = np.array([*(not room.outdoor for room in house.rooms), False])
    tops = [*(storey.floor_m for storey in house.storeys), house.storeys[-1].ceiling_m + house.spec.slab_m]
    for below, above, top in zip([nothing, *plans], [*plans, nothing], tops, strict=True):
        bottom = top - house.spec.slab_m
        wells = [i for i, r in enumerate(house.rooms) if r.label == STAIRS and r.floor_m < bottom < top < r.ceiling_m]
        layers = _layers(planes, bottom, top)
        slab[layers] = True
        covered = (indoors[below] | (above != len(house.rooms))) & ~np.isin(below, wells)
        solid[:, :, layers] |= covered[:, :, None]
        touching = [w for w in walls if abs(w[5] - bottom) < _TOLERANCE_M or abs(w[4] - top) < _TOLERANCE_M]
        for i, j, _ in _cells(planes, touching):
            solid[i, j, layers] = True
    return solid, slab
