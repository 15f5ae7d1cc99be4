"""Exact truth about a house: who is where. Everything here is a function of the house's polygons and heights."""

import numpy as np
import shapely
from jaxtyping import Bool, Float, Int
from shapely.geometry import LineString

from worlds.house import House

AMBIGUITY_BAND_M = 0.75
NOWHERE = -1


def room_at(house: House, points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
    """Index into `house.rooms` of the room that holds each point of W [m], `NOWHERE` outside of all.

    Walls are split at their centre lines, of which a point right on one belongs to the later room of `house.rooms`; a room
    reaches from its floor to the next one's.
    """
    owner = np.full(len(points), NOWHERE)
    for i, room in enumerate(house.rooms):
        in_height = (points[:, 2] >= room.floor_m) & (points[:, 2] < room.ceiling_m + house.spec.slab_m)
        owner[in_height & shapely.intersects_xy(room.polygon, points[:, 0], points[:, 1])] = i
    return owner


def floor_at(house: House, points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n"]:
    """Storey of each point: the one with the highest floor that is not above it."""
    floors = np.array([storey.floor_m for storey in house.storeys])
    return np.clip(np.searchsorted(floors, points[:, 2], side="right") - 1, 0, None)


def ambiguity_at(
    house: House, points: Float[np.ndarray, "n 3"], band_m: float = AMBIGUITY_BAND_M
) -> Bool[np.ndarray, "n rooms"]:
    """Which rooms' labels count as right at each point.

    The room that holds the point always does; within `band_m` [m] of a boundary without a wall both sides do.
    """
    owner, storey = room_at(house, points), floor_at(house, points)
    allowed = owner[:, None] == np.arange(len(house.rooms))
    index_of = {room.id: i for i, room in enumerate(house.rooms)}
    xy = shapely.points(points[:, :2])
    for level, pieces in enumerate(house.boundaries):
        for boundary, opening in pieces:
            if opening is None or opening.kind != "open":
                continue
            gap = LineString([boundary.point(boundary.low), boundary.point(boundary.high)])
            sides = [index_of[house.room_by_id[name].id] for name in boundary.rooms if name is not None]
            near = (storey == level) & (shapely.distance(xy, gap) <= band_m) & np.isin(owner, sides)
            allowed[np.ix_(near, sides)] = True
    return np.asarray(allowed)


def openness(house: House) -> float:
    """Share of the boundary length between rooms that has no wall, in [0, 1]; doors and cased openings count as open."""
    inner = [(b.length, o is not None) for pieces in house.boundaries for b, o in pieces if None not in b.rooms]
    total = sum(length for length, _ in inner)
    return sum(length for length, is_open in inner if is_open) / total if total else 0.0


def floor_area(house: House) -> float:
    """Indoor area of all storeys, to the wall centre lines [m²]."""
    storeys = house.spec.storeys
    return float(
        sum(house.room_by_id[r.id].polygon.area for s in storeys for r in s.rooms if not house.room_by_id[r.id].outdoor)
    )
