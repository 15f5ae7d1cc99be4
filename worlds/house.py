"""`build_house`: from a spec to exact geometry. Deterministic: the same spec is always the same house."""

import functools
import itertools
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import Polygon

from worlds.errors import HouseError, WorldsError
from worlds.furniture.catalogue import kind_of
from worlds.furniture.kinds import Size
from worlds.furniture.placing.furnish import furnish, is_solid
from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.openings.doors import DoorLeaf, hang_leaves
from worlds.openings.windows import Window, hang_windows, sample_windows
from worlds.parts import Part
from worlds.placed import Placed
from worlds.seeds import room_rng
from worlds.spec import FurnitureSpec, HouseSpec, OpeningSpec, WindowSpec
from worlds.stairs.build import Stairs, build_stairs
from worlds.stairs.cells import lowest_cells
from worlds.walls import (
    FENCE_HEIGHT_M,
    Boundary,
    Wall,
    arch_curve,
    boundaries,
    corners,
    extent,
    split_at_openings,
    wall_spans,
)

_Pieces = tuple[tuple[Boundary, OpeningSpec | None], ...]


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
class Furniture(Placed):
    """A piece of furniture in its place."""

    id: str
    kind: str
    room: str
    storey: int
    position: tuple[float, float, float]
    yaw: float
    size: tuple[float, float, float]
    solid: bool
    """Whether it blocks the way."""
    seed: int = 0
    """Of its colours, variants and the details of its materials."""

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """In the piece's own frame. Raises `WorldsError` for an unknown kind."""
        return kind_of(self.kind).build(Size(*self.size), np.random.default_rng(self.seed))


@dataclass(frozen=True, eq=False)
class House:
    """A house with nothing left to decide: all in W, metres."""

    spec: HouseSpec
    storeys: tuple[Storey, ...]
    rooms: tuple[Room, ...]
    boundaries: tuple[_Pieces, ...]
    """Per storey: every stretch of room boundary and the opening in it."""
    walls: tuple[Wall, ...]
    stairs: tuple[Stairs, ...]
    furniture: tuple[Furniture, ...]
    leaves: tuple[DoorLeaf, ...] = ()
    """Of doors, as they stand."""
    windows: tuple[Window, ...] = ()

    @cached_property
    def room_by_id(self) -> dict[str, Room]:
        """Rooms by the ids of the spec; the cells of one staircase all lead to the same room."""
        by_id = {room.id: room for room in self.rooms}
        return by_id | {cell: by_id[lowest] for cell, lowest in lowest_cells(self.spec).items()}

    def wall_height(self, level: int, boundary: Boundary) -> float:
        """How high a wall along a boundary of a storey is: to the ceiling, or a fence's height where all is outdoors [m]."""
        return _wall_height(self.storeys[level], boundary, self._indoors)

    @cached_property
    def _indoors(self) -> frozenset[str]:
        return _indoors(self.spec)


def build_house(spec: HouseSpec) -> House:
    """Build the house that `spec` describes; windows and furniture are filled in where it has none. Raises `HouseError`."""
    storeys = _storeys(spec)
    rooms = _rooms(spec, storeys)
    stretches = tuple(
        tuple(piece for line in boundaries(storey) for piece in split_at_openings(line, storey.openings))
        for storey in spec.storeys
    )
    outer = [_outer_walls(pieces) for pieces in stretches]
    windows = [_windows(spec, level, walls) for level, walls in enumerate(outer)]
    return House(
        spec,
        storeys,
        rooms,
        stretches,
        walls=tuple(_walls(spec, storeys, stretches)),
        stairs=build_stairs(spec, [storey.floor_m for storey in storeys]),
        furniture=tuple(_furniture(spec, storeys, windows)),
        leaves=tuple(_leaves(spec, storeys, stretches)),
        windows=tuple(_hung(spec, storeys, windows, outer)),
    )


def _storeys(spec: HouseSpec) -> tuple[Storey, ...]:
    storeys, floor = [], 0.0
    for storey in spec.storeys:
        storeys.append(Storey(floor, floor + storey.height_m))
        floor = round(floor + storey.height_m + spec.slab_m, 6)
    return tuple(storeys)


def _rooms(spec: HouseSpec, storeys: Sequence[Storey]) -> tuple[Room, ...]:
    polygons, lowest = _polygons(spec), lowest_cells(spec)
    rooms: dict[str, Room] = {}
    for level, (storey, heights) in enumerate(zip(spec.storeys, storeys, strict=True)):
        for room in storey.rooms:
            below = lowest.get(room.id, room.id)
            if below in rooms:
                rooms[below] = replace(rooms[below], ceiling_m=heights.ceiling_m)
                continue
            outdoor = room.label in OUTDOOR_LABELS
            rooms[room.id] = Room(room.id, room.label, level, polygons[room.id], heights.floor_m, heights.ceiling_m, outdoor)
    return tuple(rooms.values())


def _polygons(spec: HouseSpec) -> dict[str, Polygon]:
    rooms = [room for storey in spec.storeys for room in storey.rooms]
    points = np.array([point for room in rooms for point in (*room.polygon_m, room.polygon_m[0])])
    rings = shapely.linearrings(points, indices=np.repeat(np.arange(len(rooms)), [len(r.polygon_m) + 1 for r in rooms]))
    polygons = np.asarray(shapely.polygons(rings))
    simple, turns_left = shapely.is_valid(polygons), shapely.is_ccw(rings)
    rectangular = np.isclose(shapely.area(polygons), shapely.area(shapely.envelope(polygons)))
    for room, is_simple, is_left, is_rectangle in zip(rooms, simple, np.atleast_1d(turns_left), rectangular, strict=True):
        if not is_simple:
            raise HouseError(f"room {room.id!r}: its polygon crosses or touches itself; valid: a simple one")
        if not is_left:
            raise HouseError(f"room {room.id!r}: its polygon turns clockwise; valid: counter-clockwise (reverse it)")
        if room.label == STAIRS and not is_rectangle:
            raise HouseError(f"stairs {room.id!r}: their polygon must be a rectangle")
    return {room.id: polygon for room, polygon in zip(rooms, polygons, strict=True)}


def _indoors(spec: HouseSpec) -> frozenset[str]:
    return frozenset(room.id for storey in spec.storeys for room in storey.rooms if room.label not in OUTDOOR_LABELS)


def _wall_height(storey: Storey, boundary: Boundary, indoors: frozenset[str]) -> float:
    return FENCE_HEIGHT_M if indoors.isdisjoint(boundary.rooms) else storey.ceiling_m - storey.floor_m


def _walls(spec: HouseSpec, storeys: Sequence[Storey], stretches: Sequence[_Pieces]) -> Iterator[Wall]:
    indoors = _indoors(spec)
    for level, (heights, pieces) in enumerate(zip(storeys, stretches, strict=True)):
        meeting = corners([boundary for boundary, _ in pieces])
        for boundary, opening in pieces:
            height = _wall_height(heights, boundary, indoors)
            ends = extent(boundary, meeting)
            for low, high in wall_spans(opening, height):
                yield Wall(level, boundary, *ends, heights.floor_m + low, heights.floor_m + high)
            if opening is not None and opening.kind == "arch":
                yield from _spandrels(level, boundary, opening, heights.floor_m, height)


def _spandrels(level: int, boundary: Boundary, opening: OpeningSpec, floor_m: float, height_m: float) -> Iterator[Wall]:
    """The corners of an arch, in upright strips that reach down as far as the curve does."""
    top = min(opening.height_m, height_m)
    for (a0, z0), (a1, z1) in itertools.pairwise(arch_curve(boundary, opening, top)):
        if min(z0, z1) < top:
            yield Wall(level, boundary, a0, a1, floor_m + min(z0, z1), floor_m + top, spandrel=True)


def _outer_walls(pieces: _Pieces) -> dict[str, list[Boundary]]:
    """By room: the stretches that no other room is behind."""
    outer: dict[str, list[Boundary]] = defaultdict(list)
    for boundary, opening in pieces:
        if None in boundary.rooms and opening is None:
            outer[boundary.rooms[0] or boundary.rooms[1] or ""].append(boundary)
    return outer


def _windows(spec: HouseSpec, level: int, outer: Mapping[str, Sequence[Boundary]]) -> tuple[WindowSpec, ...]:
    storey = spec.storeys[level]
    if storey.windows is not None:
        return storey.windows
    sampled = (
        sample_windows(room, outer[room.id], storey.height_m, room_rng(spec, room, "windows"))
        for room in storey.rooms
        if room.id in outer
    )
    return tuple(itertools.chain.from_iterable(sampled))


def _hung(
    spec: HouseSpec,
    storeys: Sequence[Storey],
    windows: Sequence[Sequence[WindowSpec]],
    outer: Sequence[Mapping[str, Sequence[Boundary]]],
) -> Iterator[Window]:
    for level, (heights, own, walls) in enumerate(zip(storeys, windows, outer, strict=True)):
        yield from hang_windows(spec, level, own, walls, heights.floor_m)


def _leaves(spec: HouseSpec, storeys: Sequence[Storey], stretches: Sequence[_Pieces]) -> Iterator[DoorLeaf]:
    style = spec.seed if spec.appearance.seed is None else spec.appearance.seed
    for level, (heights, pieces) in enumerate(zip(storeys, stretches, strict=True)):
        yield from hang_leaves(level, pieces, spec.storeys[level].openings, heights.floor_m, style)


def _furniture(spec: HouseSpec, storeys: Sequence[Storey], windows: Sequence[Sequence[WindowSpec]]) -> list[Furniture]:
    rng_of = functools.partial(room_rng, spec, purpose="furniture")
    pieces = []
    for level, (storey, heights) in enumerate(zip(spec.storeys, storeys, strict=True)):
        given = storey.furniture
        specs = furnish(storey, rng_of, spec.clutter, f"{level}", windows[level]) if given is None else given
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
        solid,
        piece.seed,
    )
