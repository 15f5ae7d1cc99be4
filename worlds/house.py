"""`build_house`: from a spec to exact geometry. Deterministic: the same spec always gives the same house.

The steps, in this order because each uses the results of those before it:

1. Floor and ceiling heights of the storeys, from the lowest storey up.
2. Rooms: their polygons are checked, and the rooms of a staircase on all its storeys become one room.
3. A `StoreyPlan` per storey: the pieces of its room boundaries, and its windows.
4. Walls, furniture, door leaves and windows, made from the plans of the storeys; and stairs, made from the spec and the
   heights.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from shapely.geometry import Polygon

from worlds.errors import HouseError, WorldsError
from worlds.furniture.catalogue import kind_of
from worlds.furniture.kinds import Size
from worlds.labels import OUTDOOR_LABELS
from worlds.openings.doors import DoorLeaf
from worlds.openings.windows import Window
from worlds.parts import Part
from worlds.placed import Placed
from worlds.room_polygons import room_polygons
from worlds.spec import FurnitureSpec, HouseSpec
from worlds.stairs.build import Stairs, build_stairs
from worlds.stairs.cells import lowest_cells
from worlds.storey_plan import BoundaryPieces, StoreyPlan, indoor_rooms, wall_height
from worlds.walls import Boundary, Wall


@dataclass(frozen=True)
class Storey:
    """Heights of the floor and the ceiling of a storey, in W [m]."""

    floor_m: float
    ceiling_m: float


@dataclass(frozen=True, eq=False)
class Room:
    """A room instance. A staircase is one room through all the storeys that it joins."""

    id: str
    """The id in the spec; for stairs, the id that the spec gives them on their lowest storey."""
    label: str
    storey: int
    """Index of the storey; for stairs, index of the lowest storey that they join."""
    polygon: Polygon
    """Outline along the wall centre lines [m]."""
    floor_m: float
    """Height of the floor in W; for stairs, the floor of the lowest storey that they join [m]."""
    ceiling_m: float
    """Height of the ceiling in W; for stairs, the ceiling of the highest storey that they join [m]."""
    outdoor: bool


@dataclass(frozen=True, eq=False)
class Furniture(Placed):
    """A piece of furniture with its position in the house."""

    id: str
    kind: str
    room: str
    storey: int
    position: tuple[float, float, float]
    yaw: float
    size: tuple[float, float, float]
    solid: bool
    """Whether the piece blocks a walking person or robot; a rug, for example, does not."""
    seed: int = 0
    """Seed of the piece's colours, variants and material details."""

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The parts in the piece's own frame. Raises `WorldsError` for an unknown kind."""
        return kind_of(self.kind).build(Size(*self.size), np.random.default_rng(self.seed))


@dataclass(frozen=True, eq=False)
class House:
    """A built house: the exact geometry of rooms, walls, openings, stairs and furniture. All coordinates are in W [m]."""

    spec: HouseSpec
    storeys: tuple[Storey, ...]
    rooms: tuple[Room, ...]
    boundaries: tuple[BoundaryPieces, ...]
    """For each storey, the room boundaries cut at the openings: every piece with its opening, or with None for wall."""
    walls: tuple[Wall, ...]
    stairs: tuple[Stairs, ...]
    furniture: tuple[Furniture, ...]
    leaves: tuple[DoorLeaf, ...] = ()
    """Door leaves, as far open as the spec says."""
    windows: tuple[Window, ...] = ()

    @cached_property
    def room_by_id(self) -> dict[str, Room]:
        """Rooms by the ids of the spec. A staircase has one id per storey; all these ids give the same room."""
        by_id = {room.id: room for room in self.rooms}
        return by_id | {cell: by_id[lowest] for cell, lowest in lowest_cells(self.spec).items()}

    def wall_height(self, level: int, boundary: Boundary) -> float:
        """Return the height of the wall on a boundary of `storeys[level]` [m].

        A wall without an indoor room beside it is a fence.
        """
        storey = self.storeys[level]
        return wall_height(boundary, storey.ceiling_m - storey.floor_m, self._indoors)

    @cached_property
    def _indoors(self) -> frozenset[str]:
        return indoor_rooms(self.spec)


def build_house(spec: HouseSpec) -> House:
    """Build the house that `spec` describes. Windows and furniture are added where the spec has None.

    Lists of windows or furniture in the spec, even empty lists, are used as they are. Raises `HouseError` if the house
    cannot be built; the message names the room, opening, stairs or piece at fault.
    """
    storeys = _storeys(spec)
    rooms = _rooms(spec, storeys)
    plans = [StoreyPlan.of(spec, level, storey.floor_m, storey.ceiling_m) for level, storey in enumerate(storeys)]
    house = House(
        spec,
        storeys,
        rooms,
        boundaries=tuple(plan.pieces for plan in plans),
        walls=tuple(wall for plan in plans for wall in plan.standing_walls()),
        stairs=build_stairs(spec, [storey.floor_m for storey in storeys]),
        furniture=tuple(piece for plan in plans for piece in _furniture(plan)),
        leaves=tuple(leaf for plan in plans for leaf in plan.hung_leaves()),
        windows=tuple(window for plan in plans for window in plan.hung_windows()),
    )
    _check_unique_ids(house.furniture)
    return house


def _storeys(spec: HouseSpec) -> tuple[Storey, ...]:
    storeys, floor = [], 0.0
    for storey in spec.storeys:
        storeys.append(Storey(floor, floor + storey.height_m))
        # Rounding keeps the errors of binary sums from piling up over the storeys.
        floor = round(floor + storey.height_m + spec.slab_m, 6)
    return tuple(storeys)


def _rooms(spec: HouseSpec, storeys: Sequence[Storey]) -> tuple[Room, ...]:
    polygons, lowest = room_polygons(spec), lowest_cells(spec)
    rooms: dict[str, Room] = {}
    for level, (storey, heights) in enumerate(zip(spec.storeys, storeys, strict=True)):
        for room in storey.rooms:
            below = lowest.get(room.id, room.id)
            if below in rooms:  # a further cell of a staircase makes the room below it taller
                rooms[below] = replace(rooms[below], ceiling_m=heights.ceiling_m)
                continue
            outdoor = room.label in OUTDOOR_LABELS
            rooms[room.id] = Room(room.id, room.label, level, polygons[room.id], heights.floor_m, heights.ceiling_m, outdoor)
    return tuple(rooms.values())


def _furniture(plan: StoreyPlan) -> Iterator[Furniture]:
    for piece in plan.furniture():
        x, y, z = piece.position_m
        position = x, y, plan.floor_m + z
        size, solid = piece.size_m, _is_solid(piece)
        yield Furniture(piece.id, piece.kind, piece.room, plan.level, position, piece.yaw_rad, size, solid, piece.seed)


def _is_solid(piece: FurnitureSpec) -> bool:
    try:
        return kind_of(piece.kind).solid
    except WorldsError as error:
        raise HouseError(f"furniture {piece.id!r} in {piece.room!r}: {error}") from None


def _check_unique_ids(pieces: Sequence[Furniture]) -> None:
    """Raise `HouseError` if a piece of the spec and a filled-in piece have the same id."""
    repeated = [name for name, times in Counter(piece.id for piece in pieces).items() if times > 1]
    if repeated:
        raise HouseError(
            f"furniture: the spec uses ids of pieces that are filled in on other storeys: {', '.join(repeated)}; "
            "valid: ids that are unique in the house"
        )
