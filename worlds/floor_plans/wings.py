"""Wings: the corridors of a building, the bands of rooms along them, and the place of the stairs; shared by all storeys.

The main wing's spine runs east from the origin; that of a second wing leaves it northwards, through the north band. Stairs
stand in the north band or at the main spine's end.

                       west  |  |  east
    +---------+--------+-----+  +----+---------+
    | north 0 | stairs | north 1|  | north 2   |
    +---------+--------+--------+  +-----------+
    | spine                                    |
    +------------------------------------------+
    | south                                    |
    +------------------------------------------+
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from worlds.floor_plans.bays import run_width
from worlds.floor_plans.programmes import BayRun
from worlds.floor_plans.rectangles import Edge, Rect
from worlds.stairs.flights import StairsKind, cell_needed

Band = Literal["south", "north 0", "north 1", "north 2", "west", "east"]
BANDS: tuple[Band, ...] = ("south", "north 0", "north 1", "north 2", "west", "east")
_FROM_THE_EAST: tuple[Band, ...] = ("north 2", "north 1", "north 0")
_LEAST_STEP = 60
"""Between the ends of bands on either side of a spine [cm]."""
_SHORTEST = 220
"""Least length of a spine that ends at stairs [cm]."""
_ARM = 140
"""Width of the spine's arms beside stairs [cm]."""


@dataclass(frozen=True)
class Depths:
    """Measures across the wings [cm]; 0: there is no such band."""

    spine: int
    south: int
    north: int = 0
    cross: int = 0
    """Width of the second wing's spine."""
    west: int = 0
    east: int = 0

    def of(self, band: Band) -> int:
        """Depth of a band."""
        return {"south": self.south, "west": self.west, "east": self.east}.get(band, self.north)


@dataclass(frozen=True)
class StairsBay:
    """What stairs take, from the origin of an edge [cm]."""

    kind: StairsKind
    length: int
    width: int
    """Of the cell, along the first flight and across it."""
    flipped: bool = False

    @property
    def front(self) -> int:
        """How much of a band they take."""
        if self.kind == "straight":
            return self.length + 2 * _ARM
        return self.width + (_ARM if self.kind == "L" else 0)

    @property
    def depth(self) -> int:
        """How far the cell reaches away from the spine."""
        return self.width if self.kind == "straight" else self.length

    def arms(self) -> tuple[tuple[int, int, int, int], ...]:
        """In u and v: what the spine has beside the cell."""
        match self.kind:
            case "straight":
                return (0, 0, _ARM, self.width), (_ARM + self.length, 0, self.front, self.width)
            case "L":
                return (self._turned((0, 0, _ARM, self.length)),)
        return ()

    def cell(self) -> tuple[int, int, int, int]:
        """In u and v."""
        match self.kind:
            case "straight":
                return _ARM, 0, _ARM + self.length, self.width
            case "L":
                return self._turned((_ARM, 0, self.front, self.length))
        return 0, 0, self.width, self.length

    def gaps(self) -> tuple[tuple[int, int, int, int], tuple[int, int, int, int]]:
        """In u and v: the openings to the flight up and from the one below, as segments."""
        match self.kind:
            case "straight":
                up = self._turned((_ARM, 5, _ARM, self.width - 5))
                return up, self._turned((_ARM + self.length, 5, _ARM + self.length, self.width - 5))
            case "L":
                far, deep = self.front, self.length
                return self._turned((far - 105, 0, far - 10, 0)), self._turned((_ARM, deep - 105, _ARM, deep - 10))
        middle = self.width // 2
        return self._turned((5, 0, middle, 0)), self._turned((middle, 0, self.width - 5, 0))

    def _turned(self, r: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
        if not self.flipped:
            return r
        return self.front - r[2], r[1], self.front - r[0], r[3]


def stairs_bay(kind: StairsKind, rise_m: float, width_m: float | None = None, flipped: bool = False) -> StairsBay:
    """Comfortable stairs of a kind for a rise from floor to floor; `width_m` [m] of the cell is for U only."""
    if kind == "U":
        across = width_m or 2.2
        length, _ = cell_needed("U", rise_m, 0.26, across / 2 - 0.05)
        return StairsBay("U", round(100 * max(length, 3.2)), round(100 * across), flipped)
    length, width = cell_needed(kind, rise_m, 0.25, 0.95 if kind == "straight" else 0.9)
    return StairsBay(kind, round(100 * length), round(100 * width), flipped)


@dataclass(frozen=True)
class Shell:
    """What all storeys share."""

    depths: Depths
    lengths: dict[Band, int]
    """Of the bands where they are longest [cm]."""
    stairs: StairsBay | None = None
    at_end: bool = False
    """Whether the stairs stand at the spine's end rather than in the north band."""

    @property
    def stairs_start(self) -> int:
        """Where the stairs' bay begins in the north band."""
        return self.lengths["north 0"]

    @property
    def passage_start(self) -> int:
        """Where the second wing's spine goes through the north band."""
        in_band = self.stairs.front if self.stairs and not self.at_end else 0
        return self.stairs_start + in_band + self.lengths["north 1"]

    @property
    def length(self) -> int:
        """Of the main spine, less stairs at its end."""
        passage_end = self.passage_start + self.depths.cross
        total = max(self.lengths["south"], passage_end + self.lengths["north 2"])
        if self.stairs is None or not self.at_end:
            return total
        return max(_SHORTEST, total - self.stairs.length, passage_end if self.depths.cross else 0)

    def flush(self) -> "Shell":
        """The same without small steps: ends of bands that lie nearly side by side do so."""
        n = dict(self.lengths)
        step = n["south"] - (self.passage_start + self.depths.cross + n["north 2"])
        last = next((band for band in _FROM_THE_EAST if n[band]), None)
        if -_LEAST_STEP < step < 0:
            n["south"] -= step
        elif 0 < step < _LEAST_STEP and last is not None:
            n[last] += step
        if abs(n["west"] - n["east"]) < _LEAST_STEP:
            n["west"] = n["east"] = max(n["west"], n["east"])
        return replace(self, lengths=n)

    def reach(self, band: Band, length: int) -> int:
        """How far east a band of that length goes; 0 for those along the second wing."""
        if band in ("west", "east"):
            return 0
        return self.edge(band).x + length

    def edge(self, band: Band) -> Edge:
        """Where a band's rooms stand."""
        c, x = self.depths.spine, self.passage_start
        top = c + self.depths.north
        match band:
            case "south":
                return Edge(0, 0, (1, 0), (0, -1))
            case "north 0":
                return Edge(0, c, (1, 0), (0, 1))
            case "north 1":
                return Edge(x - self.lengths["north 1"], c, (1, 0), (0, 1))
            case "north 2":
                return Edge(x + self.depths.cross, c, (1, 0), (0, 1))
            case "west":
                return Edge(x, top, (0, 1), (-1, 0))
            case "east":
                return Edge(x + self.depths.cross, top, (0, 1), (1, 0))

    def stairs_edge(self) -> Edge:
        """Where the stairs' bay stands."""
        if self.at_end:
            return Edge(self.length, 0, (0, 1), (1, 0))
        return Edge(self.stairs_start, self.depths.spine, (1, 0), (0, 1))

    def slot(self) -> Rect | None:
        """The place behind the stairs, reached from the spine's arms, where it is large enough for a room."""
        if self.stairs is None or self.at_end or self.stairs.kind == "U":
            return None
        if self.depths.north - self.stairs.depth < 175:
            return None
        return self.stairs_edge().rect(0, self.stairs.depth, self.stairs.front, self.depths.north)


def distribute(
    runs: Sequence[BayRun], room: dict[Band, int], depths: Depths, kept: dict[int, Band]
) -> dict[Band, list[BayRun]]:
    """Give every run a band: the longest first, each to where most room is left [cm]; `kept` says where some belong."""
    left = dict(room)
    bands: dict[Band, list[BayRun]] = {band: [] for band in room}
    order = sorted(range(len(runs)), key=lambda i: -run_width(runs[i], 450))
    for i in order:
        run = runs[i]

        width = {band: run_width(run, depths.of(band)) for band in left}
        free = {band: left[band] - 2.0 * (_misfit(run, depths.of(band)) + max(0, width[band] - left[band])) for band in left}
        roomiest: Band = max(free, key=free.__getitem__)
        band = kept.get(i, roomiest)
        bands[band].append(run)
        left[band] -= width[band]
    return bands


def _misfit(run: BayRun, depth: int) -> float:
    """How much wider a run is than its area wants, in a deep band, or than is good for its rooms, in a shallow one [cm]."""
    wanted = sum(sum(bay.areas) for bay in run.bays) * 1e4 / depth
    return run_width(run, depth) - wanted + max(0.0, wanted - 1.8 * depth * len(run.bays))
