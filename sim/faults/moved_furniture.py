"""`with_furniture_moved`: moves furniture to other free places in its room."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from jaxtyping import Float64
from shapely import Geometry
from shapely.geometry import MultiPoint, Polygon

from sim.faults.closing_doors import built_leaves
from worlds.house import Furniture, House

_TRIES = 30
"""Number of places that are tried for each piece of furniture."""
_WALL_M = 0.1
"""Least distance of moved furniture from the polygon of its room, which runs along the centre of walls [m]."""
_BODY_M = 0.3
"""Least distance of moved furniture from the part of the path that the body still has to walk [m]."""
_ON_FLOOR_M = 0.02
"""Largest height of the underside of a piece that stands on the floor [m]."""
_FLAT_M = 0.05
"""Largest thickness of a piece, such as a rug, on which moved furniture may stand [m]."""
_FIXED = frozenset(
    (
        *("kitchen counter", "kitchen sink", "kitchen island", "stove", "dishwasher", "washing machine", "utility sink"),
        *("bathtub", "shower", "toilet bowl", "washbasin", "hand basin", "vanity", "radiator", "boiler", "fireplace"),
        *("tree", "hedge", "flower bed", "sandpit", "garden shed", "swing", "fume hood", "lab bench", "wall bars"),
    )
)
"""Kinds of furniture that are never moved, because they are fixed in place."""


def with_furniture_moved(
    house: House,
    path: Float64[np.ndarray, "n 3"],
    share: float,
    within_m: float,
    turn_rad: float,
    rng: np.random.Generator,
) -> tuple[Furniture, ...]:
    """Move a share of the loose furniture on the floor, and return all furniture of the house.

    Moved pieces keep clear of walls, of other pieces at their height, of the areas in which doors swing, and of `path`, the
    body's later positions in W [m]. `within_m` is the largest shift [m], and `turn_rad` the largest rotation [rad]. Objects
    on a piece move with the piece. A piece stays where it is if no free place is found for it.
    """
    pieces = list(house.furniture)
    movable = [
        i
        for i, piece in enumerate(pieces)
        if piece.solid and _height(house, piece) < _ON_FLOOR_M and piece.kind not in _FIXED
    ]
    # Whether a fault closes doors at the same time must not decide where furniture is: it would move when the doors do.
    swings = [(leaf.storey, leaf.swing) for leaf in built_leaves(house)]
    for i in rng.permutation(movable)[: round(share * len(movable))]:
        piece = pieces[i]
        riders = [k for k, other in enumerate(pieces) if k != i and _rides(house, other, piece)]
        others = [other for k, other in enumerate(pieces) if k not in (i, *riders) and _is_in_the_way(other, piece)]
        free = _free_of(house, piece, others, swings, path)
        for _ in range(_TRIES):
            angle, distance, turn = rng.uniform(-math.pi, math.pi), within_m * math.sqrt(rng.random()), rng.uniform(-1, 1)
            shift = (distance * math.cos(angle), distance * math.sin(angle))
            moved = _moved(piece, piece, shift, turn_rad * turn)
            if shapely.covers(free, moved.footprint):
                for k in (i, *riders):
                    pieces[k] = _moved(pieces[k], piece, shift, turn_rad * turn)
                break
    return tuple(pieces)


def _height(house: House, piece: Furniture) -> float:
    """Return the height of a piece above the floor of its storey [m]."""
    return piece.position[2] - house.storeys[piece.storey].floor_m


def _rides(house: House, other: Furniture, piece: Furniture) -> bool:
    above = other.storey == piece.storey and _ON_FLOOR_M <= _height(house, other) <= piece.size[2] + _ON_FLOOR_M
    return above and bool(piece.footprint.covers(shapely.Point(other.position[:2])))


def _is_in_the_way(other: Furniture, piece: Furniture) -> bool:
    """Return whether `piece` may not be moved to where `other` is: both are on one storey, and overlap in height."""
    low, high = max(other.position[2], piece.position[2]), min(each.position[2] + each.size[2] for each in (other, piece))
    return other.storey == piece.storey and other.size[2] > _FLAT_M and low < high


def _free_of(
    house: House,
    piece: Furniture,
    others: Sequence[Furniture],
    swings: Sequence[tuple[int, Polygon]],
    path: Float64[np.ndarray, "n 3"],
) -> Geometry:
    """Return the free area of a piece's room in the plan. The footprint of the moved piece has to lie inside this area.

    `swings` are the storeys and areas in which doors swing.
    """
    storey, room = house.storeys[piece.storey], house.room_by_id[piece.room].polygon
    low, high = np.reshape(room.bounds, (2, 2)) + [[-_BODY_M], [_BODY_M]]
    here = path[(path[:, 2] > storey.floor_m) & (path[:, 2] < storey.ceiling_m), :2]
    near = here[((here > low) & (here < high)).all(axis=1)]
    shapes = [*(other.footprint for other in others), *(swing for level, swing in swings if level == piece.storey)]
    within = [shape for shape in shapes if shape.intersects(room)]
    taken = shapely.union_all([*within, MultiPoint(near).buffer(_BODY_M, 4)])
    return room.buffer(-_WALL_M).difference(taken)


def _moved(piece: Furniture, about: Furniture, shift: tuple[float, float], turn: float) -> Furniture:
    """Rotate a piece about the centre of `about` (another piece or itself), then shift it."""
    cos, sin = math.cos(turn), math.sin(turn)
    dx, dy = piece.position[0] - about.position[0], piece.position[1] - about.position[1]
    x = about.position[0] + shift[0] + cos * dx - sin * dy
    y = about.position[1] + shift[1] + sin * dx + cos * dy
    return replace(piece, position=(x, y, piece.position[2]), yaw=piece.yaw + turn)
