"""`build_house`: from a spec to exact geometry. Deterministic: the same spec is always the same house."""

import functools
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from shapely import affinity
from shapely.geometry import Polygon, box

from worlds.errors import HouseError, WorldsError
from worlds.furniture.placement import furnish, is_solid, parts_of
from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.parts import Part
from worlds.seeds import room_rng
from worlds.spec import FurnitureSpec, HouseSpec, OpeningSpec, RoomSpec
from worlds.stairs import Stairs, build_stairs
from worlds.walls import FENCE_HEIGHT_M, WALL_THICKNESS_M, Boundary, Wall, boundaries, split_at_openings


@dataclass(frozen=True)
class Storey:
    """Heights of a storey in W [m]."""

    floor_m: float
    ceiling_m: float


@dataclass(frozen=True, eq=False)
class Room:
    """A room instance. Stairs are one room through all the storeys that they join."""

    id: str
    label: str
    storey: int
    """The lowest it stands on."""
    polygon: Polygon
    """Of the wall centre lines [m]."""
    floor_m: float
    ceiling_m: float
    outdoor: bool


@dataclass(frozen=True, eq=False)
class Furniture:
    """A piece of furniture in its place."""

    id: str
    kind: str
    room: str
    storey: int
    position: tuple[float, float, float]
    """Centre of the underside in W [m]."""
    yaw: float
    """[rad]"""
    size: tuple[float, float, float]
    """Width, depth, height [m]."""
    parts: tuple[Part, ...]
    """In the piece's own frame."""
    solid: bool
    """Whether it blocks the way."""
    seed: int = 0
    """Of its colours, variants and the details of its materials."""

    @cached_property
    def footprint(self) -> Polygon:
        """What it covers of the plan [m]."""
        x, y, _ = self.position
        w, d, _ = self.size
        return affinity.rotate(box(x - w / 2, y - d / 2, x + w / 2, y + d / 2), self.yaw, origin=(x, y), use_radians=True)


@dataclass(frozen=True, eq=False)
class House:
    """A house with nothing left to decide: all in W, metres."""

    spec: HouseSpec
    storeys: tuple[Storey, ...]
    rooms: tuple[Room, ...]
    boundaries: tuple[tuple[tuple[Boundary, OpeningSpec | None], ...], ...]
    """Per storey: every stretch of room boundary and the opening in it."""
    walls: tuple[Wall, ...]
    stairs: tuple[Stairs, ...]
    furniture: tuple[Furniture, ...]

    @cached_property
    def room_by_id(self) -> dict[str, Room]:
        """Rooms by the ids of the spec; the cells of one staircase all lead to the same room."""
        by_id = {room.id: room for room in self.rooms}
        by_cell = {_cell(room.polygon): room for room in self.rooms if room.label == STAIRS}
        for storey in self.spec.storeys:
            for room in storey.rooms:
                if room.id not in by_id:
                    by_id[room.id] = by_cell[_cell(Polygon(room.polygon_m))]
        return by_id


def build_house(spec: HouseSpec) -> House:
    """Build the house that `spec` describes; furniture is filled in where the spec has none. Raises `HouseError`."""
    storeys = _storeys(spec)
    rooms = _rooms(spec, storeys)
    stretches = tuple(
        tuple(piece for line in boundaries(storey) for piece in split_at_openings(line, storey.openings))
        for storey in spec.storeys
    )
    walls = tuple(_walls(storeys, rooms, stretches))
    return House(spec, storeys, rooms, stretches, walls, tuple(_stairs(spec, storeys)), tuple(_furniture(spec, storeys)))


def _storeys(spec: HouseSpec) -> tuple[Storey, ...]:
    storeys, floor = [], 0.0
    for storey in spec.storeys:
        storeys.append(Storey(floor, floor + storey.height_m))
        floor = round(floor + storey.height_m + spec.slab_m, 6)
    return tuple(storeys)


def _rooms(spec: HouseSpec, storeys: Sequence[Storey]) -> tuple[Room, ...]:
    rooms: list[Room] = []
    for level, (storey, heights) in enumerate(zip(spec.storeys, storeys, strict=True)):
        for room in storey.rooms:
            polygon = _polygon(room)
            below = next((r for r in rooms if r.label == room.label == STAIRS and _cell(r.polygon) == _cell(polygon)), None)
            if below is None:
                rooms.append(
                    Room(
                        room.id, room.label, level, polygon, heights.floor_m, heights.ceiling_m, room.label in OUTDOOR_LABELS
                    )
                )
            else:
                if below.ceiling_m != storeys[level - 1].ceiling_m:
                    raise HouseError(
                        f"stairs {room.id!r} on storeys[{level}] stand on {below.id!r}, but storeys[{level - 1}] has none "
                        "there; stairs skip no storey"
                    )
                taller = Room(below.id, below.label, below.storey, polygon, below.floor_m, heights.ceiling_m, below.outdoor)
                rooms[rooms.index(below)] = taller
    return tuple(rooms)


def _polygon(room: RoomSpec) -> Polygon:
    polygon = Polygon(room.polygon_m)
    if not polygon.is_valid or not polygon.exterior.is_ccw:
        raise HouseError(f"room {room.id!r}: its polygon must be simple (no self-crossing) and counter-clockwise")
    if room.label == STAIRS and not math.isclose(polygon.area, box(*polygon.bounds).area):
        raise HouseError(f"stairs {room.id!r}: their polygon must be a rectangle")
    return polygon


def _cell(polygon: Polygon) -> tuple[float, ...]:
    return tuple(round(bound, 6) for bound in polygon.bounds)


def _walls(
    storeys: Sequence[Storey], rooms: Sequence[Room], stretches: Sequence[Sequence[tuple[Boundary, OpeningSpec | None]]]
) -> list[Wall]:
    outdoor = {room.id for room in rooms if room.outdoor}
    walls = []
    for level, (heights, pieces) in enumerate(zip(storeys, stretches, strict=True)):
        for boundary, opening in pieces:
            fence = all(room is None or room in outdoor for room in boundary.rooms)
            top = heights.floor_m + FENCE_HEIGHT_M if fence else heights.ceiling_m
            bottom = heights.floor_m if opening is None else heights.floor_m + _clear_height(opening)
            if bottom < top:
                walls.append(Wall(level, boundary, bottom, top))
    return walls


def _clear_height(opening: OpeningSpec) -> float:
    return math.inf if opening.kind == "open" else opening.height_m


def _stairs(spec: HouseSpec, storeys: Sequence[Storey]) -> list[Stairs]:
    stairs = []
    for level, (lower, upper) in enumerate(zip(spec.storeys, spec.storeys[1:], strict=False)):
        cells_above = {_cell(Polygon(room.polygon_m)) for room in upper.rooms if room.label == STAIRS}
        for room in lower.rooms:
            if room.label != STAIRS or _cell(Polygon(room.polygon_m)) not in cells_above:
                continue
            foot = next((opening for opening in lower.openings if room.id in opening.rooms), None)
            if foot is None:
                raise HouseError(f"stairs {room.id!r} have no opening on storeys[{level}]; give the first flight one")
            floors = storeys[level].floor_m, storeys[level + 1].floor_m
            stairs.append(build_stairs(room.id, level, Polygon(room.polygon_m), foot, floors, WALL_THICKNESS_M / 2))
    return stairs


def _furniture(spec: HouseSpec, storeys: Sequence[Storey]) -> list[Furniture]:
    rng_of = functools.partial(room_rng, spec, purpose="furniture")
    pieces = []
    for level, (storey, heights) in enumerate(zip(spec.storeys, storeys, strict=True)):
        given = storey.furniture
        specs = furnish(storey, rng_of, spec.clutter, f"{level}", storey.windows or ()) if given is None else given
        pieces += [_place(piece, level, heights.floor_m) for piece in specs]
    repeated = [name for name, times in Counter(piece.id for piece in pieces).items() if times > 1]
    if repeated:
        raise HouseError(f"furniture ids are unique in a house, but given and filled in are both {', '.join(repeated)}")
    return pieces


def _place(piece: FurnitureSpec, storey: int, floor_m: float) -> Furniture:
    x, y, z = piece.position_m
    try:
        solid = is_solid(piece.kind)
    except WorldsError as error:
        raise HouseError(f"furniture {piece.id!r} in {piece.room!r}: {error}") from None
    return Furniture(
        piece.id,
        piece.kind,
        piece.room,
        storey,
        (x, y, floor_m + z),
        piece.yaw_rad,
        piece.size_m,
        parts_of(piece),
        solid,
        piece.seed,
    )
