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
from worlds.checks.collisions import overlaps
from worlds.free_space import Obstacles
from worlds.furniture.catalogue import kind_of
from worlds.furniture.kinds import OnCeiling, OnWall
from worlds.furniture.placing.room_plan import FLAT_M
from worlds.house import Furniture, House

_TRIES = 30
"""Number of places that are tried for each piece of furniture."""
_WALL_M = 0.1
"""Least distance of moved furniture from the polygon of its room, which runs along the centre of walls [m]."""
_BODY_M = 0.3
"""Least distance of moved furniture from the part of the path that the body still has to walk [m]."""
_ON_FLOOR_M = 0.02
"""Largest height of the underside of a piece that stands on the floor [m]."""
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

    Moved pieces keep clear of walls, of the areas in which doors swing, and of `path`, the body's later positions in W [m].
    They overlap no other piece, door leaf or window. Objects on a piece move with the piece, and overlap nothing either.
    A piece stays where it is if no free place is found for it. `within_m` is the largest shift [m], and `turn_rad` the
    largest rotation [rad].
    """
    pieces = list(house.furniture)
    movable = [
        i
        for i, piece in enumerate(pieces)
        if piece.solid and _height(house, piece) < _ON_FLOOR_M and piece.kind not in _FIXED
    ]
    # Whether a fault closes doors at the same time must not decide where furniture is: it would move when the doors do.
    leaves = list(built_leaves(house))
    for i in rng.permutation(movable)[: round(share * len(movable))]:
        piece = pieces[i]
        riders = [k for k, other in enumerate(pieces) if k != i and _rides(house, other, piece)]
        still = [other for k, other in enumerate(pieces) if k not in (i, *riders) and other.size[2] > FLAT_M]
        obstacles = Obstacles.around([thing for thing in (*still, *leaves, *house.windows) if thing.storey == piece.storey])
        free = _free_of(house, piece, [leaf.swing for leaf in leaves if leaf.storey == piece.storey], path)
        for _ in range(_TRIES):
            angle, distance, turn = rng.uniform(-math.pi, math.pi), within_m * math.sqrt(rng.random()), rng.uniform(-1, 1)
            shift = (distance * math.cos(angle), distance * math.sin(angle))
            moved = {k: _moved(pieces[k], piece, shift, turn_rad * turn) for k in (i, *riders)}
            if shapely.covers(free, moved[i].footprint) and not _overlap(list(moved.values()), obstacles):
                for k, placed in moved.items():
                    pieces[k] = placed
                break
    return tuple(pieces)


def _height(house: House, piece: Furniture) -> float:
    """Return the height of a piece above the floor of its storey [m]."""
    return piece.position[2] - house.storeys[piece.storey].floor_m


def _rides(house: House, other: Furniture, piece: Furniture) -> bool:
    """Whether a piece stands on another one. What hangs on a wall or a ceiling stays where it is."""
    above = other.storey == piece.storey and _ON_FLOOR_M <= _height(house, other) <= piece.size[2] + _ON_FLOOR_M
    if not above or isinstance(kind_of(other.kind).place, OnWall | OnCeiling):
        return False
    return bool(piece.footprint.covers(shapely.Point(other.position[:2])))


def _overlap(moved: Sequence[Furniture], obstacles: Obstacles) -> bool:
    """Return whether a moved piece or an object on it overlaps an obstacle."""
    return len(overlaps(Obstacles.around(moved), obstacles, 0.0)) > 0


def _free_of(house: House, piece: Furniture, swings: Sequence[Polygon], path: Float64[np.ndarray, "n 3"]) -> Geometry:
    """Return the part of a piece's room, as seen from above, in which the moved piece has to stand.

    `swings` are the areas in which the doors of the storey swing.
    """
    storey, room = house.storeys[piece.storey], house.room_by_id[piece.room].polygon
    low, high = np.reshape(room.bounds, (2, 2)) + [[-_BODY_M], [_BODY_M]]
    here = path[(path[:, 2] > storey.floor_m) & (path[:, 2] < storey.ceiling_m), :2]
    near = here[((here > low) & (here < high)).all(axis=1)]
    within = [swing for swing in swings if swing.intersects(room)]
    taken = shapely.union_all([*within, MultiPoint(near).buffer(_BODY_M, 4)])
    return room.buffer(-_WALL_M).difference(taken)


def _moved(piece: Furniture, about: Furniture, shift: tuple[float, float], turn: float) -> Furniture:
    """Rotate a piece about the centre of `about` (another piece or itself), then shift it."""
    cos, sin = math.cos(turn), math.sin(turn)
    dx, dy = piece.position[0] - about.position[0], piece.position[1] - about.position[1]
    x = about.position[0] + shift[0] + cos * dx - sin * dy
    y = about.position[1] + shift[1] + sin * dx + cos * dy
    return replace(piece, position=(x, y, piece.position[2]), yaw=piece.yaw + turn)
