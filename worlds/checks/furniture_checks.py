"""Checks of furniture and door leaves: furniture collides with nothing, and nothing stands where a door leaf swings."""

import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Int

from worlds.checks.collisions import outlines_over, overlaps
from worlds.checks.plan_grid import PlanGrid
from worlds.free_space import Obstacles
from worlds.furniture.placing.room_plan import FLAT_M
from worlds.house import Furniture, House
from worlds.labels import STAIRS
from worlds.openings.doors import DoorLeaf
from worlds.walls import Wall, opening_span

_TOLERANCE_M = 2e-3
_HEIGHT_TOLERANCE_M = 1e-3
_AT_ONCE = 64
"""Number of boxes that are compared with all others in one step, to limit the memory."""


def furniture_problems(house: House, grid: PlanGrid) -> Iterator[str]:
    """Yield a message for every rule that furniture or a door leaf breaks. The message names the piece or leaf."""
    pieces, leaves = house.furniture, house.leaves
    boxes, hung, walls = Obstacles.around(pieces), Obstacles.around(leaves), Obstacles.of_walls(house.walls)
    yield from _out_of_storey(house)
    outside = _outside_their_room(house, grid, boxes)
    for i in sorted(outside):
        yield f"{piece_name(pieces[i])} sticks out of its room {pieces[i].room!r}"
    for i, j in overlaps(boxes, walls, _TOLERANCE_M).tolist():
        if i not in outside:
            yield f"{piece_name(pieces[i])} in {pieces[i].room!r} stands in {_wall_name(house.walls[j])}"
    thick = np.array([piece.size[2] > FLAT_M for piece in pieces], bool)
    for i, j in _clashes(boxes):
        if thick[i] and thick[j]:
            yield f"{piece_name(pieces[i])} and {piece_name(pieces[j])} in {pieces[i].room!r} run into each other"
    yield from _on_the_stairs(house, boxes)
    for i, j in overlaps(boxes, hung, _TOLERANCE_M).tolist():
        if thick[i]:
            yield f"{piece_name(pieces[i])} in {pieces[i].room!r} runs into {_leaf_name(house, leaves[j])} as it stands"
    for i, j in overlaps(boxes, Obstacles.around(house.windows), _TOLERANCE_M).tolist():
        yield f"{piece_name(pieces[i])} in {pieces[i].room!r} runs into {house.windows[j].id}"
    yield from _swings(house, boxes, hung, walls)


def _clashes(boxes: Obstacles) -> Iterator[tuple[int, int]]:
    """Yield each pair of boxes that overlap, as two ascending indices.

    Only a few boxes are tested at a time, because many boxes in one place form more pairs than fit in memory.
    """
    for first in range(0, len(boxes.yaw), _AT_ONCE):
        for i, j in overlaps(boxes.chosen(slice(first, first + _AT_ONCE)), boxes, _TOLERANCE_M).tolist():
            if first + i < j:
                yield first + i, j


def _out_of_storey(house: House) -> Iterator[str]:
    for piece in house.furniture:
        storey, bottom = house.storeys[piece.storey], piece.position[2]
        top = bottom + piece.size[2]
        if not storey.floor_m - _HEIGHT_TOLERANCE_M <= bottom <= top <= storey.ceiling_m + _HEIGHT_TOLERANCE_M:
            yield (
                f"{piece_name(piece)} reaches from {bottom:.2f} to {top:.2f} m; valid: {storey.floor_m:.2f} ... "
                f"{storey.ceiling_m:.2f} m, floor to ceiling"
            )


def _outside_their_room(house: House, grid: PlanGrid, boxes: Obstacles) -> set[int]:
    """Return the indices of the pieces whose centre is not in their room, or that cross a side of their room."""
    index = {room.id: k for k, room in enumerate(grid.rooms)}
    own = np.array([index[piece.room] for piece in house.furniture], int)
    level = np.array([piece.storey for piece in house.furniture], int)
    away = np.flatnonzero(grid.owner_at(level, boxes.centre) != own)
    sides, room_of_side = _sides(grid)
    i, j = overlaps(boxes, sides, _TOLERANCE_M).T
    return set(away.tolist()) | set(i[own[i] == room_of_side[j]].tolist())


def _sides(grid: PlanGrid) -> tuple[Obstacles, Int[np.ndarray, "n"]]:
    """Return the sides of all rooms, as boxes of no thickness and unlimited height, and the number of each side's room."""
    rings = [np.array(room.polygon_m) for room in grid.rooms]
    start, end = np.concatenate(rings), np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    span = np.broadcast_to([-math.inf, math.inf], (len(start), 2))
    sides = Obstacles((start + end) / 2, np.abs(end - start), np.zeros(len(start)), span)
    return sides, np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])


def _on_the_stairs(house: House, boxes: Obstacles) -> Iterator[str]:
    """Yield a message for each piece that runs into a step, and for each solid piece in a room of stairs.

    A body follows the walking line of stairs and does not walk around anything, so there has to be nothing in its way.
    """
    rooms, steps = _stairs(house)
    hits = {(i, rooms[j]): None for i, j in overlaps(boxes, steps, _TOLERANCE_M).tolist()}
    for i, stairs in hits:
        piece = house.furniture[i]
        yield f"{piece_name(piece)} in {piece.room!r} stands on the stairs {stairs!r}"
    on_steps = {i for i, _ in hits}
    for i, piece in enumerate(house.furniture):
        if piece.solid and house.room_by_id[piece.room].label == STAIRS and i not in on_steps:
            yield f"{piece_name(piece)} stands in the stairs {piece.room!r}; stairs hold no furniture that blocks a body"


def _stairs(house: House) -> tuple[list[str], Obstacles]:
    """Return all parts of all stairs as boxes, and for each part the room of its stairs."""
    parts = [(flight.room, part) for flight in house.stairs for part in flight.parts]
    poses = ((part.centre, part.size, part.yaw) for _, part in parts)
    rows = [(x, y, width, depth, yaw, z - height / 2, z + height / 2) for (x, y, z), (width, depth, height), yaw in poses]
    return [room for room, _ in parts], Obstacles.of(rows)


def _swings(house: House, boxes: Obstacles, hung: Obstacles, walls: Obstacles) -> Iterator[str]:
    """Yield a message for each thing that is in the way of a swinging door leaf.

    The thing is a piece of furniture, another leaf, stairs, or a wall other than the wall in which the door is. Pieces that
    lie on the floor and do not block a body, such as shoes, do not block a leaf either.
    """
    leaves = house.leaves
    if not leaves:
        return
    sectors = np.array([leaf.swing.exterior.coords[:-1] for leaf in leaves])
    for i, j in outlines_over(sectors, hung.span, boxes, _TOLERANCE_M).tolist():
        piece = house.furniture[j]
        hangs = piece.position[2] > house.storeys[piece.storey].floor_m + FLAT_M
        if (piece.solid or hangs) and piece.size[2] > FLAT_M:
            yield f"{piece_name(piece)} in {piece.room!r} is in the way of {_leaf_name(house, leaves[i])}"
    for i, j in outlines_over(sectors, hung.span, hung, _TOLERANCE_M).tolist():
        if i != j:
            yield f"{_leaf_name(house, leaves[j])} as it stands is in the way of {_leaf_name(house, leaves[i])}"
    rooms, steps = _stairs(house)
    met = outlines_over(sectors, hung.span, steps, _TOLERANCE_M).tolist()
    for i, room in dict.fromkeys((i, rooms[j]) for i, j in met):
        yield f"the stairs {room!r} are in the way of {_leaf_name(house, leaves[i])}"
    for i, j in outlines_over(sectors, hung.span, walls, _TOLERANCE_M).tolist():
        axis, at, *_ = opening_span(house.spec.storeys[leaves[i].storey].openings[leaves[i].opening])
        boundary = house.walls[j].boundary
        if (boundary.axis, boundary.at) != (axis, at):
            yield f"{_wall_name(house.walls[j])} is in the way of {_leaf_name(house, leaves[i])}"


def piece_name(piece: Furniture) -> str:
    """Return the id and the kind of a piece of furniture, for messages."""
    return f"furniture {piece.id!r} ({piece.kind})"


def _wall_name(wall: Wall) -> str:
    a, b = ("the outside" if room is None else repr(room) for room in wall.rooms)
    return f"the wall between {a} and {b}"


def _leaf_name(house: House, leaf: DoorLeaf) -> str:
    opening = house.spec.storeys[leaf.storey].openings[leaf.opening]
    return f"the door leaf of storeys[{leaf.storey}].openings[{leaf.opening}] ({opening.rooms[0]} - {opening.rooms[1]})"
