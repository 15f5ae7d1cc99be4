"""`Surroundings`: a house as upright boxes with names, for the ray casts of the feature sensor."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float32, Float64, Int

from worlds.furniture.catalogue import CATALOGUE
from worlds.furniture.registry import own_kinds
from worlds.house import House
from worlds.labels import ROOM_LABELS
from worlds.parts import Part
from worlds.rectangles import tiles
from worlds.truth import NOWHERE, ObjectInstance, objects
from worlds.visuals.house_visuals import STAIRS_OBJECT
from worlds.visuals.materials import PATTERNS
from worlds.visuals.surface_textures import finishes
from worlds.visuals.surfaces import SURFACE_KINDS

OBJECTS = (*sorted(CATALOGUE.keys() - {kind.name for kind in own_kinds()}), "door", "window", STAIRS_OBJECT)
"""Kinds of objects that the included feature model knows. Furniture that a user declares has none of these kinds."""
KINDS = (*OBJECTS, *(f"{pattern} {surface}" for surface in SURFACE_KINDS for pattern in PATTERNS))
"""Visual kinds of things: kinds of objects, then one kind for each combination of a surface and a pattern of its finish. The
setting `texture` of a house's appearance, which changes the rendered textures, is ignored."""
CELL_M = 0.05
"""Cell size of `RoomMap` [m]."""
_LEAST_M = 0.08
"""Objects that are smaller than this in every direction are left out [m]."""
_LEAST_DIFFERENCE = 1e-3
"""Sizes [m] and colours of things that look the same differ by less than this."""
_DIGITS = 2 ** np.array([48, 32, 16, 0])
"""Weights that make one number of a kind and three sizes or colours in units of `_LEAST_DIFFERENCE`, each less than 2^16."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """Upright boxes that rays may hit (walls and objects), one row for each box, in W [m, rad]."""

    centre: Float32[np.ndarray, "b 2"]
    half: Float32[np.ndarray, "b 2"]
    """Half the width and half the depth of each box, along the box's own axes."""
    yaw: Float32[np.ndarray, "b"]
    z: Float32[np.ndarray, "b 2"]
    """Heights of each box's lower and upper end in W [m]."""
    thing: Int[np.ndarray, "b"]
    """Index into `Surroundings.names`; `NOWHERE` for walls, because a hit on a wall counts for the room in front of it."""

    def __getitem__(self, rows: np.ndarray) -> "Blocks":
        return Blocks(self.centre[rows], self.half[rows], self.yaw[rows], self.z[rows], self.thing[rows])


@dataclass(frozen=True, eq=False)
class Surroundings:
    """All visible things of a house: first wall, floor and ceiling of each room, then the objects."""

    house: House
    names: tuple[str, ...]
    """Names as in `sim.render.scene.Scene.object_of_geom`: "<room id>/<wall|floor|ceiling>", or the id of an object."""
    kind: Int[np.ndarray, "things"]
    """Index into `KINDS` of each thing; `NOWHERE` for furniture that a user has declared."""
    colour: Float32[np.ndarray, "rooms surfaces 3"]
    """Colours of each room's surfaces, RGB in [0, 1]."""
    room: Int[np.ndarray, "things"]
    """Index into `House.rooms` of the room that each thing belongs to."""
    blocks: Blocks

    @cached_property
    def looks(self) -> Int[np.ndarray, "things"]:
        """What each thing looks like, as a number from 0 on that does not depend on the rest of the house.

        Surfaces of the same kind and colour look the same and have the same number, and so have objects of the same kind and
        size. The colours of objects are ignored. If an object has several blocks, as stairs have, the last one counts.
        """
        described = np.zeros((len(self.names), 4), np.int64)
        described[:, 0] = self.kind - NOWHERE
        described[: self.colour.size // 3, 1:] = np.rint(self.colour.reshape(-1, 3) / _LEAST_DIFFERENCE)
        blocks = self.blocks[self.blocks.thing != NOWHERE]
        sizes = np.column_stack([2.0 * blocks.half, blocks.z[:, 1] - blocks.z[:, 0]])
        described[blocks.thing, 1:] = np.rint(sizes / _LEAST_DIFFERENCE)
        return np.asarray(described @ _DIGITS)

    def offsets(self, room: int) -> Float64[np.ndarray, "others 3"]:
        """Return the offsets from a room to the other rooms of its label, from corner to corner, in W [m].

        A room is given as its index into `House.rooms`, or as `NOWHERE`, which has no offsets.
        """
        if room == NOWHERE:
            return np.zeros((0, 3))
        others = np.flatnonzero(self.labels == self.labels[room])
        return np.asarray(self._corners[others[others != room]] - self._corners[room])

    @cached_property
    def _corners(self) -> Float64[np.ndarray, "rooms 3"]:
        """Least x and least y of the outline of each room, and the height of its floor, in W [m]."""
        return np.array([(*room.polygon.bounds[:2], room.floor_m) for room in self.house.rooms]).reshape(-1, 3)

    @cached_property
    def labels(self) -> Int[np.ndarray, "rooms"]:
        """Label of each room, as an index into `ROOM_LABELS`."""
        return np.array([ROOM_LABELS.index(room.label) for room in self.house.rooms])

    @cached_property
    def rooms_at(self) -> "RoomMap":
        """A raster map of rooms, in which the room at a point can be looked up."""
        return RoomMap.of(self.house)


def survey(house: House) -> Surroundings:
    """Collect all visible things of a house, as surfaces and upright boxes."""
    index = {room.id: i for i, room in enumerate(house.rooms)}
    rows = [*_walls(house), *_objects(house)]
    # The dictionary by name joins all flights of stairs into one object, as in the rendered scene.
    named = {name: (name, kind, room) for _, name, kind, room in rows if name is not None}
    finish = finishes(house)
    covered = [(room.id, surface, getattr(finish[room.id], surface)) for room in house.rooms for surface in SURFACE_KINDS]
    surfaces = [(f"{room}/{surface}", f"{pattern} {surface}", room) for room, surface, (pattern, _) in covered]
    things = [*surfaces, *named.values()]
    colour = np.array([shade for _, _, (_, shade) in covered], np.float32).reshape(-1, len(SURFACE_KINDS), 3)
    row_of = {name: i for i, (name, _, _) in enumerate(things)}
    kinds = {kind: i for i, kind in enumerate(KINDS)}
    values = np.array([box for box, *_ in rows], np.float32).reshape(-1, 7)
    thing = np.array([NOWHERE if name is None else row_of[name] for _, name, _, _ in rows], int)
    return Surroundings(
        house,
        tuple(name for name, _, _ in things),
        np.array([kinds.get(kind, NOWHERE) for _, kind, _ in things]),
        colour,
        np.array([index[house.room_by_id[room].id] for _, _, room in things]),
        Blocks(values[:, :2], values[:, 2:4], values[:, 4], values[:, 5:], thing),
    )


_Box = tuple[float, float, float, float, float, float, float]
"""Centre (x, y), half extents (x, y), yaw, heights of the lower and upper end."""
_Row = tuple[_Box, str | None, str, str]
"""Box, name of the thing (None: wall), kind and room."""


def _walls(house: House) -> Iterator[_Row]:
    for wall in house.walls:
        x0, y0, x1, y1 = wall.bounds
        box = ((x0 + x1) / 2, (y0 + y1) / 2, (x1 - x0) / 2, (y1 - y0) / 2, 0.0, wall.bottom_m, wall.top_m)
        yield box, None, "", ""


def _objects(house: House) -> Iterator[_Row]:
    for thing in objects(house):
        if max(thing.size) >= _LEAST_M:
            yield _box_of(thing), thing.id, thing.kind, thing.room
    for flight in house.stairs:
        for part in flight.parts:
            yield _box_of(part), STAIRS_OBJECT, STAIRS_OBJECT, flight.room


def _box_of(thing: ObjectInstance | Part) -> _Box:
    (x, y, z), (width, depth, height) = thing.centre, thing.size
    return x, y, width / 2, depth / 2, thing.yaw, z - height / 2, z + height / 2


@dataclass(frozen=True, eq=False)
class RoomMap:
    """A raster map of rooms for each storey. Cells have the size `CELL_M`; a border of one cell belongs to no room."""

    cells: Int[np.ndarray, "storeys nx ny"]
    """The room of each cell, as an index into `House.rooms`; `NOWHERE` outside of all rooms."""
    origin: Float32[np.ndarray, "2"]

    @staticmethod
    def of(house: House) -> "RoomMap":
        """Build the maps of a house. A staircase appears on all storeys that it joins."""
        bounds = np.array([room.polygon.bounds for room in house.rooms])
        low, high = bounds[:, :2].min(axis=0) - CELL_M, bounds[:, 2:].max(axis=0) + CELL_M
        size = np.ceil((high - low) / CELL_M).astype(int)
        cells = np.full((len(house.storeys), *size), NOWHERE, np.int16)
        for i, room in enumerate(house.rooms):
            levels = [k for k, s in enumerate(house.storeys) if room.floor_m <= s.floor_m < room.ceiling_m]
            for x0, y0, x1, y1 in tiles(room.polygon):
                a, b = (np.rint((np.array(corner) - low) / CELL_M).astype(int) for corner in ((x0, y0), (x1, y1)))
                cells[levels, a[0] : b[0], a[1] : b[1]] = i
        return RoomMap(cells, low.astype(np.float32))

    def at(
        self, storey: Int[np.ndarray, "*#n"], x: Float32[np.ndarray, "*n"], y: Float32[np.ndarray, "*n"]
    ) -> Int[np.ndarray, "*n"]:
        """Return the index of the room at each point (in W [m]) of a storey; `NOWHERE` outside of all rooms."""
        _, nx, ny = self.cells.shape
        column = np.clip((x - self.origin[0]) / np.float32(CELL_M), 0, nx - 1).astype(np.int32)
        row = np.clip((y - self.origin[1]) / np.float32(CELL_M), 0, ny - 1).astype(np.int32)
        return np.asarray(self.cells[storey, column, row])
