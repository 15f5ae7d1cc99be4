"""Reachability of rooms on foot: the connected parts of the free floor are found and joined by stairs."""

import cv2
import numpy as np
from jaxtyping import Bool, Float64, Int

from worlds.checks.plan_grid import NO_ROOM, PlanGrid
from worlds.free_space import STAIRS_LINK_M, Obstacles, clearance_on, free_clearance, lattice, solid_obstacles, stair_wells
from worlds.house import House

_RESOLUTION_M = 0.1
"""Spacing of the grid points [m]."""


def unreachable_rooms(house: House, grid: PlanGrid, radius_m: float) -> tuple[str, ...]:
    """Return the ids of the rooms that an upright cylindrical body cannot reach from the largest connected free area.

    Doors count as open: their leaves are no obstacles. In a house without leaves, the result is all rooms except those in
    `Walkable.reachable_rooms`, but it is computed faster here, without a graph:

    1. On a grid of points, find the points at which a body of `radius_m` [m] has space. They are inside a room, and at least
       `free_clearance` from obstacles and stairs.
    2. Number the connected parts of these points on every storey.
    3. Renumber the parts, so that parts that are joined by stairs have the same number.
    4. A room is reachable if the part with most points has a point in the room. The room of a staircase is reachable if the
       staircase leads to or from this part.
    """
    x, y = lattice(house, _RESOLUTION_M)
    solids, wells = solid_obstacles(house, leaves=False), stair_wells(house)
    margin = free_clearance(radius_m, _RESOLUTION_M)
    rooms = grid.lattice(x, y)
    obstacles = [(solids.at_height(s.floor_m), wells.at_height(s.floor_m)) for s in house.storeys]
    clear = np.stack([clearance_on(x, y, groups, margin) >= margin for groups in obstacles])
    parts = _parts((rooms != NO_ROOM) & clear)
    parts, flights = _join(house, x, y, parts, solids, radius_m)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    if not sizes.any():
        return tuple(room.id for room in house.rooms)
    largest = int(np.argmax(sizes))
    reached = {house.room_by_id[grid.rooms[k].id].id for k in np.unique(rooms[parts == largest]).tolist()}
    reached |= {flight for flight, part in flights if part == largest}
    return tuple(room.id for room in house.rooms if room.id not in reached)


def _parts(free: Bool[np.ndarray, "storeys nx ny"]) -> Int[np.ndarray, "storeys nx ny"]:
    """Return the number, from 1, of the connected part of each grid point; 0 for points that are not free.

    Diagonal neighbours count as connected. No part spans several storeys.
    """
    parts, used = [], 0
    for storey in free:
        count, labels = cv2.connectedComponents(storey.astype(np.uint8), connectivity=8)
        parts.append(np.where(labels > 0, labels + used, 0))
        used += count - 1
    return np.stack(parts)


def _join(
    house: House,
    x: Float64[np.ndarray, "nx"],
    y: Float64[np.ndarray, "ny"],
    parts: Int[np.ndarray, "storeys nx ny"],
    solids: Obstacles,
    radius_m: float,
) -> tuple[Int[np.ndarray, "storeys nx ny"], list[tuple[str, int]]]:
    """Renumber the connected parts, so that parts that are joined by stairs have the same number.

    Return the new number at each grid point, and pairs for the flights of stairs: id of the room of the stairs, and number
    of the part that the flight joins.
    """
    number = np.arange(parts.max(initial=0) + 1)
    flights = []
    for stairs in house.stairs:
        ends = [(stairs.storey, stairs.walking_line[0]), (stairs.storey + 1, stairs.walking_line[-1])]
        met = {part for level, end in ends for part in _near(x, y, parts[level], end, solids, radius_m)}
        if met:
            first = min(met)
            number[np.isin(number, number[list(met)])] = number[first]
            flights.append((house.room_by_id[stairs.room].id, first))
    return number[parts], [(room, int(number[part])) for room, part in flights]


def _near(
    x: Float64[np.ndarray, "nx"],
    y: Float64[np.ndarray, "ny"],
    parts: Int[np.ndarray, "nx ny"],
    end: Float64[np.ndarray, "3"],
    solids: Obstacles,
    radius_m: float,
) -> set[int]:
    """Return the numbers of the connected parts that a body can reach from the end of a walking line without a collision."""
    i, j = np.nonzero(np.add.outer((x - end[0]) ** 2, (y - end[1]) ** 2) <= STAIRS_LINK_M**2)
    i, j = i[parts[i, j] > 0], j[parts[i, j] > 0]
    places = np.stack([x[i], y[j], np.full(len(i), end[2])], axis=-1)
    local = solids.within(end[:2], 2 * STAIRS_LINK_M)
    clear = local.clear(np.broadcast_to(end, places.shape), places, radius_m)
    return set(parts[i[clear], j[clear]].tolist())
