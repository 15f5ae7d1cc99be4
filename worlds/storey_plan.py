"""`StoreyPlan`: a storey with its room boundaries, before walls, windows, door leaves and furniture are made.

The room boundaries are cut at the openings. A piece of boundary without an opening is a wall; a piece with an opening may
have a door leaf. Walls with no room or an outdoor room behind them are outer walls, in which windows can lie. Furniture is
placed last, because it must not cover windows.
"""

import functools
import itertools
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from worlds.furniture.placing.furnish import furnish
from worlds.labels import OUTDOOR_LABELS
from worlds.openings.doors import DoorLeaf, hang_leaves
from worlds.openings.windows import Window, hang_windows, sample_windows
from worlds.seeds import room_rng
from worlds.spec import FurnitureSpec, HouseSpec, OpeningSpec, StoreySpec, WindowSpec
from worlds.walls import (
    FENCE_HEIGHT_M,
    Boundary,
    Wall,
    arch_curve,
    boundaries,
    corners,
    split_at_openings,
    wall_extent,
    wall_spans,
)

BoundaryPieces = tuple[tuple[Boundary, OpeningSpec | None], ...]
"""The room boundaries of a storey, cut at its openings: every piece with the opening that fills it, or None for wall."""


@dataclass(frozen=True, eq=False)
class StoreyPlan:
    """One storey of a house that is being built."""

    house: HouseSpec
    level: int
    """Index of the storey in the house."""
    floor_m: float
    """Height of the floor in W [m]."""
    ceiling_m: float
    """Height of the ceiling in W [m]."""
    pieces: BoundaryPieces
    outer: Mapping[str, Sequence[Boundary]]
    """For each room with outer walls, by the room's id: the pieces of its outer walls that have no opening. A wall between
    an indoor room and a garden or balcony is an outer wall of the indoor room."""
    windows: tuple[WindowSpec, ...]
    """Windows of the storey: the windows in the spec, or randomly drawn windows if the spec has None instead of a list."""

    @staticmethod
    def of(house: HouseSpec, level: int, floor_m: float, ceiling_m: float) -> "StoreyPlan":
        """Plan `house.storeys[level]`. Raises `HouseError` where rooms overlap or an opening runs along neither x nor y."""
        storey = house.storeys[level]
        pieces = tuple(piece for line in boundaries(storey) for piece in split_at_openings(line, storey.openings))
        outer = _outer_walls(pieces, indoor_rooms(house))
        windows = _sampled_windows(house, storey, outer) if storey.windows is None else storey.windows
        return StoreyPlan(house, level, floor_m, ceiling_m, pieces, outer, windows)

    def standing_walls(self) -> Iterator[Wall]:
        """Yield the pieces of wall that remain after the openings are cut out, including the corners above arches."""
        meeting, indoors = corners([boundary for boundary, _ in self.pieces]), indoor_rooms(self.house)
        for boundary, opening in self.pieces:
            height = wall_height(boundary, self.ceiling_m - self.floor_m, indoors)
            ends = wall_extent(boundary, meeting)
            for low, high in wall_spans(opening, height):
                yield Wall(self.level, boundary, *ends, self.floor_m + low, self.floor_m + high)
            if opening is not None and opening.kind == "arch":
                yield from self._spandrels(boundary, opening, height)

    def _spandrels(self, boundary: Boundary, opening: OpeningSpec, height_m: float) -> Iterator[Wall]:
        """Yield the wall above an arch as narrow boxes; each box reaches down to the lowest point of the curve below it."""
        floor, top = self.floor_m, min(opening.height_m, height_m)
        for (a0, z0), (a1, z1) in itertools.pairwise(arch_curve(boundary, opening, top)):
            if min(z0, z1) < top:
                yield Wall(self.level, boundary, a0, a1, floor + min(z0, z1), floor + top, spandrel=True)

    def hung_windows(self) -> Iterator[Window]:
        """Yield the windows of the storey as objects in their walls.

        Raises `HouseError` for a window that lies in no outer wall of its room, or whose sill is not below its upper edge.
        """
        return hang_windows(self.house, self.level, self.windows, self.outer, self.floor_m)

    def hung_leaves(self) -> Iterator[DoorLeaf]:
        """Yield the door leaves of the storey as objects, as far open as the spec says."""
        seed = self.house.seed if self.house.appearance.seed is None else self.house.appearance.seed
        return hang_leaves(self.level, self.pieces, self.house.storeys[self.level].openings, self.floor_m, seed)

    def furniture(self) -> tuple[FurnitureSpec, ...]:
        """Return the furniture in the spec, or furniture from the catalogue if the spec has None instead of a list."""
        storey = self.house.storeys[self.level]
        if storey.furniture is not None:
            return storey.furniture
        rng_of = functools.partial(room_rng, self.house, purpose="furniture")
        return furnish(storey, rng_of, self.house.clutter, f"{self.level}", self.windows)


def indoor_rooms(house: HouseSpec) -> frozenset[str]:
    """Return the ids of the rooms that are not outdoors."""
    return frozenset(room.id for storey in house.storeys for room in storey.rooms if room.label not in OUTDOOR_LABELS)


def wall_height(boundary: Boundary, ceiling_height_m: float, indoors: frozenset[str]) -> float:
    """Return the height of the wall on a boundary [m].

    The height is `ceiling_height_m`, or `FENCE_HEIGHT_M` if no room beside the wall is in `indoors`.
    """
    return FENCE_HEIGHT_M if indoors.isdisjoint(boundary.rooms) else ceiling_height_m


def _outer_walls(pieces: BoundaryPieces, indoors: frozenset[str]) -> dict[str, list[Boundary]]:
    outer: dict[str, list[Boundary]] = defaultdict(list)
    for boundary, opening in pieces:
        rooms = [room for room in boundary.rooms if room is not None]
        inside = [room for room in rooms if room in indoors] or rooms
        if len(inside) == 1 and opening is None:
            outer[inside[0]].append(boundary)
    return dict(outer)


def _sampled_windows(
    house: HouseSpec, storey: StoreySpec, outer: Mapping[str, Sequence[Boundary]]
) -> tuple[WindowSpec, ...]:
    sampled = (
        sample_windows(room, outer.get(room.id, ()), storey.height_m, room_rng(house, room, "windows"))
        for room in storey.rooms
    )
    return tuple(itertools.chain.from_iterable(sampled))
