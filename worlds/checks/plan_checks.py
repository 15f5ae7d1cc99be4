"""Checks of the plan: rooms do not overlap, gaps are not too narrow, upper rooms are supported, and stairs join storeys."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64, Int

from worlds.checks.plan_grid import NO_ROOM, PlanGrid
from worlds.house import House
from worlds.labels import OUTDOOR_LABELS, STAIRS

MIN_APART_M = 0.3
"""Least distance between two rooms that do not touch [m]: nothing could be built in a narrower gap."""
MIN_SUPPORT = 0.9
"""Least share of an upper indoor room's floor area that must lie above indoor rooms of the storey below."""
_TOLERANCE_M, _TOLERANCE_M2 = 1e-6, 1e-3


def plan_problems(house: House, grid: PlanGrid) -> Iterator[str]:
    """Yield a message for every rule of the floor plan that a room breaks. The message names the room."""
    yield from overlap_problems(grid)
    yield from _narrow_gaps(grid)
    yield from _unsupported(grid)
    for room in house.rooms:
        if room.label == STAIRS and room.ceiling_m == house.storeys[room.storey].ceiling_m:
            yield f"stairs {room.id!r} join no storeys; they need stairs with the same corners above or below"


def overlap_problems(grid: PlanGrid) -> Iterator[str]:
    """Yield a message for every pair of rooms on one storey that overlap."""
    for a, b, area in grid.clashes:
        if area > _TOLERANCE_M2:
            yield (
                f"storeys[{grid.level_of_room[a]}]: rooms {grid.rooms[a].id!r} and {grid.rooms[b].id!r} overlap by "
                f"{area:.2f} m²; rooms may only touch"
            )


def _narrow_gaps(grid: PlanGrid) -> Iterator[str]:
    """Yield a message for every pair of rooms with a gap between them that is narrower than `MIN_APART_M`."""
    for level, owner in enumerate(grid.owner):
        for axis, (cells, along, across) in enumerate(((owner.T, grid.x, grid.y), (owner, grid.y, grid.x))):
            # `cells` is transposed for x, so that its rows run along the axis in both cases.
            for row, column, pair, width_m in _gaps_along(cells, along):
                a, b = (grid.rooms[k].id for k in pair)
                place = (along[column], across[row]) if axis == 0 else (across[row], along[column])
                gap = f"{width_m:.3g} m near ({place[0]:.2f}, {place[1]:.2f}) m"
                if a == b:
                    yield f"storeys[{level}]: room {a!r} has a slot of {gap}; slots are at least {MIN_APART_M} m wide"
                else:
                    apart = f"rooms touch or are at least {MIN_APART_M} m apart"
                    yield f"storeys[{level}]: rooms {a!r} and {b!r} leave a gap of {gap}; {apart}"


def _gaps_along(
    cells: Int[np.ndarray, "rows columns"], along: Float64[np.ndarray, "_"]
) -> Iterator[tuple[int, int, tuple[int, int], float]]:
    """Yield the narrow gaps along the rows of a grid: row and column of an empty cell, the rooms on both sides, and width.

    Each pair of rooms is yielded once. `along` holds the coordinates of the cells' ends [m], and the width is in metres.
    """
    number, count = np.arange(cells.shape[1]), cells.shape[1]
    before = np.maximum.accumulate(np.where(cells != NO_ROOM, number, -1), axis=1)
    after = np.minimum.accumulate(np.where(cells != NO_ROOM, number, count)[:, ::-1], axis=1)[:, ::-1]
    between = (cells == NO_ROOM) & (before >= 0) & (after < count)
    width_m = along[np.minimum(after, count)] - along[before + 1]
    seen = set()
    for row, column in np.argwhere(between & (width_m < MIN_APART_M - _TOLERANCE_M)).tolist():
        pair = int(cells[row, before[row, column]]), int(cells[row, after[row, column]])
        if pair not in seen:
            seen.add(pair)
            yield row, column, pair, float(width_m[row, column])


def _unsupported(grid: PlanGrid) -> Iterator[str]:
    """Yield a message for every upper indoor room of which too little area lies above indoor rooms of the storey below."""
    indoor = np.array([*(room.label not in OUTDOOR_LABELS for room in grid.rooms), False])
    area, rooms = grid.area.ravel(), len(grid.rooms)
    for level in range(1, len(grid.owner)):
        above, below = grid.owner[level].ravel(), indoor[grid.owner[level - 1].ravel()]
        of_room = np.where(above == NO_ROOM, rooms, above)
        whole, borne = (np.bincount(of_room, weights, rooms + 1)[:rooms] for weights in (area, area * below))
        for k in np.flatnonzero(indoor[:-1] & (borne < MIN_SUPPORT * whole)).tolist():
            yield (
                f"storeys[{level}]: only {100 * borne[k] / whole[k]:.0f} % of room {grid.rooms[k].id!r} stand on indoor "
                f"rooms of the storey below; valid: at least {100 * MIN_SUPPORT:.0f} %"
            )
