"""Wings: the corridors of a building, the bands of rooms along them, and the stairs; the same on all storeys.

A wing is a corridor, called its spine, with rows of rooms along it, called bands. The spine of the main wing runs east from
the origin. The spine of a second wing, if there is one, leaves the main spine northwards; the passage is its part inside
the north band. Stairs stand in the north band, which they interrupt, or at the east end of the main spine. The parts that
all storeys share are called the shell; all lengths are in whole centimetres. The drawing has x to the right (east) and y up
(north):

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

from worlds.floor_plans.bays import group_width
from worlds.floor_plans.programmes import BayGroup
from worlds.floor_plans.rectangles import Edge, RectCm
from worlds.stairs.flights import StairsKind, cell_needed

Band = Literal["south", "north 0", "north 1", "north 2", "west", "east"]
BANDS: tuple[Band, ...] = ("south", "north 0", "north 1", "north 2", "west", "east")
_FROM_THE_EAST: tuple[Band, ...] = ("north 2", "north 1", "north 0")
_LEAST_STEP = 60
"""Least distance between the ends of the two rows of rooms along a corridor; rows that end closer are made equal [cm]."""
_SHORTEST = 220
"""Least length of a spine (a corridor) that ends at stairs [cm]."""
_ARM = 140
"""Width of an arm: a piece of corridor that leads from the spine along a side of the stairs [cm]."""


@dataclass(frozen=True)
class Depths:
    """Widths of the spines (corridors) and depths of the bands (rows of rooms) [cm]; 0: the plan has none in this place."""

    spine: int
    """Width of the main spine (corridor) [cm]."""
    south: int
    """Depth of the south band (row of rooms) [cm]."""
    north: int = 0
    """Depth of all three north bands (rows of rooms) [cm]."""
    cross: int = 0
    """Width of the second wing's spine (corridor) [cm]; 0: no second wing."""
    west: int = 0
    """Depth of the band (row of rooms) along the second wing's west side [cm]."""
    east: int = 0
    """Depth of the band (row of rooms) along the second wing's east side [cm]."""

    def of(self, band: Band) -> int:
        """Return the depth of a band (row of rooms) [cm]."""
        return {"south": self.south, "west": self.west, "east": self.east}.get(band, self.north)


@dataclass(frozen=True)
class StairsBay:
    """The space that stairs take beside a corridor, in the coordinates of an `Edge`: u runs along it, v away from it [cm].

    The cell is the room of the stairs. L-shaped and straight stairs also need arms: pieces of corridor beside the cell, for
    those ends of the flight that do not face the corridor.
    """

    kind: StairsKind
    length: int
    """Length of the cell, along the first run of steps [cm]."""
    width: int
    """Width of the cell, across the first run of steps [cm]."""
    flipped: bool
    """Whether the stairs are mirrored, left for right as seen from the corridor."""

    @property
    def front(self) -> int:
        """Length of the corridor's side that the stairs and their arms (pieces of corridor beside them) take up [cm]."""
        if self.kind == "straight":
            return self.length + 2 * _ARM
        return self.width + (_ARM if self.kind == "L" else 0)

    @property
    def depth(self) -> int:
        """Depth of the cell (the room of the stairs), measured away from the corridor [cm]."""
        return self.width if self.kind == "straight" else self.length

    def arms(self) -> tuple[tuple[int, int, int, int], ...]:
        """Return the rectangles (u0, v0, u1, v1) of the arms, the pieces of corridor beside the stairs [cm].

        u runs along the side of the main corridor, v is the distance from this side. U-shaped stairs have no arms.
        """
        match self.kind:
            case "straight":
                return (0, 0, _ARM, self.width), (_ARM + self.length, 0, self.front, self.width)
            case "L":
                return (self._turned((0, 0, _ARM, self.length)),)
        return ()

    def cell(self) -> tuple[int, int, int, int]:
        """Return the rectangle (u0, v0, u1, v1) of the cell, the room of the stairs [cm].

        u runs along the side of the main corridor, v is the distance from this side.
        """
        match self.kind:
            case "straight":
                return _ARM, 0, _ARM + self.length, self.width
            case "L":
                return self._turned((_ARM, 0, self.front, self.length))
        return 0, 0, self.width, self.length

    def gaps(self) -> tuple[tuple[int, int, int, int], tuple[int, int, int, int]]:
        """Return the openings to the flight up and to the flight down, each as a segment (u0, v0, u1, v1) [cm].

        u runs along the side of the main corridor, v is the distance from this side.
        """
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


def stairs_bay(kind: StairsKind, rise_m: float, flipped: bool, width_m: float | None = None) -> StairsBay:
    """Compute the space that comfortable stairs of a kind take if they rise `rise_m` from floor to floor [m].

    `width_m` is the width of the cell (the room of the stairs) [m]; only U-shaped stairs use it. None: 2.2 m.
    """
    if kind == "U":
        across = width_m or 2.2
        length, _ = cell_needed("U", rise_m, 0.26, across / 2 - 0.05)
        return StairsBay("U", round(100 * max(length, 3.2)), round(100 * across), flipped)
    length, width = cell_needed(kind, rise_m, 0.25, 0.95 if kind == "straight" else 0.9)
    return StairsBay(kind, round(100 * length), round(100 * width), flipped)


@dataclass(frozen=True)
class Shell:
    """The part of the plan that all storeys share: spines (corridors), bands (rows of rooms) and stairs."""

    depths: Depths
    lengths: dict[Band, int]
    """Greatest length that every band (row of rooms) has on any storey [cm]."""
    stairs: StairsBay | None
    at_end: bool
    """Whether the stairs stand at the east end of the main spine (corridor), and not in the row of rooms to its north."""

    @property
    def stairs_start(self) -> int:
        """The x at which stairs in the north band (the row of rooms north of the main corridor) begin [cm]."""
        return self.lengths["north 0"]

    @property
    def passage_start(self) -> int:
        """The x at which the second wing's corridor begins, on its way through the north band (a row of rooms) [cm]."""
        in_band = self.stairs.front if self.stairs and not self.at_end else 0
        return self.stairs_start + in_band + self.lengths["north 1"]

    @property
    def length(self) -> int:
        """Length of the main spine (corridor), without stairs at its end [cm].

        The spine is as long as the rows of rooms along it. If stairs stand at its end, their length is subtracted, but the
        spine stays at least `_SHORTEST` long and reaches past the corridor of the second wing.
        """
        passage_end = self.passage_start + self.depths.cross
        total = max(self.lengths["south"], passage_end + self.lengths["north 2"])
        if self.stairs is None or not self.at_end:
            return total
        return max(_SHORTEST, total - self.stairs.length, passage_end if self.depths.cross else 0)

    def flush(self) -> "Shell":
        """Return the shell (the part of the plan that all storeys share) without small steps in its outline.

        Where the rows of rooms on both sides of a corridor end less than `_LEAST_STEP` apart, the shorter row is lengthened
        until both end together.
        """
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
        """Return the x of the east end of a band (row of rooms) of this length [cm]; 0 for bands along the second wing."""
        if band in ("west", "east"):
            return 0
        return self.edge(band).x + length

    def edge(self, band: Band) -> Edge:
        """Return the line, with its own coordinates, along which the rooms of a band (row of rooms) stand."""
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
        """Return the line, with its own coordinates, along which the stairs stand."""
        if self.at_end:
            return Edge(self.length, 0, (0, 1), (1, 0))
        return Edge(self.stairs_start, self.depths.spine, (1, 0), (0, 1))

    def slot(self) -> RectCm | None:
        """Return the space behind the stairs in the north band (row of rooms); None if no room can be there.

        A room there is entered from the arms, the pieces of corridor beside the stairs. The result is None without stairs,
        for stairs at the spine's end, for U-shaped stairs, which have no arms, and if the space is less than 1.75 m deep.
        """
        if self.stairs is None or self.at_end or self.stairs.kind == "U":
            return None
        if self.depths.north - self.stairs.depth < 175:
            return None
        return self.stairs_edge().rect(0, self.stairs.depth, self.stairs.front, self.depths.north)


def distribute(
    groups: Sequence[BayGroup], lengths: dict[Band, int], depths: Depths, kept: dict[int, Band]
) -> dict[Band, list[BayGroup]]:
    """Choose a band (a row of rooms along a corridor) for every group of bays.

    `lengths` has the planned length of every band [cm]. `kept` has the groups whose band is already decided: it maps the
    index of such a group to its band.

    The longest groups come first, because they are the hardest to fit. Each group goes to the band with most length left
    after two deductions: twice the length that is missing if the group is too long for the band, and twice the group's
    `_misfit`, which is large if the band is too deep or too shallow for the group's rooms.
    """
    left = dict(lengths)
    bands: dict[Band, list[BayGroup]] = {band: [] for band in lengths}
    order = sorted(range(len(groups)), key=lambda i: -group_width(groups[i], 450))
    for i in order:
        group = groups[i]

        width = {band: group_width(group, depths.of(band)) for band in left}
        free = {
            band: left[band] - 2.0 * (_misfit(group, depths.of(band)) + max(0, width[band] - left[band])) for band in left
        }
        roomiest: Band = max(free, key=free.__getitem__)
        band = kept.get(i, roomiest)
        bands[band].append(group)
        left[band] -= width[band]
    return bands


def _misfit(group: BayGroup, depth: int) -> float:
    """Return how badly a group of bays fits a band (row of rooms) of the given depth; 0: perfectly [cm].

    The result is the sum of two excess widths. In a deep band, the group gets wider than its area requires, because rooms
    have a least width. In a shallow band, the group gets wider than 1.8 times the depth per main room, so that the rooms are
    too slender.
    """
    wanted = sum(sum(bay.areas) for bay in group.bays) * 1e4 / depth
    return group_width(group, depth) - wanted + max(0.0, wanted - 1.8 * depth * len(group.bays))
