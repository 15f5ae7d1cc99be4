"""`Partition`: the boundary between two indoor rooms of a storey, and how much of its area is permanently open."""

from collections import defaultdict
from dataclasses import dataclass

from worlds.arches import spandrel_area
from worlds.labels import OUTDOOR_LABELS, STAIRS
from worlds.openings.opening_draft import join_stretches
from worlds.spec import HouseSpec, OpeningSpec
from worlds.walls import Boundary, boundaries


@dataclass(frozen=True)
class Partition:
    """The whole boundary between two indoor rooms of a storey, neither of which is stairs."""

    storey: int
    rooms: frozenset[str]
    """Ids of the two rooms."""
    walls: tuple[Boundary, ...]
    """The straight stretches of the boundary between the two rooms."""
    height_m: float
    """Height of the ceiling above the floor [m]."""

    @property
    def area(self) -> float:
        """Area of the boundary, openings included [m²]."""
        return self.height_m * sum(wall.length for wall in self.walls)


def partitions(spec: HouseSpec) -> list[Partition]:
    """Return the partitions of all storeys, lowest storey first. Raises `HouseError` where rooms overlap."""
    found = []
    for level, storey in enumerate(spec.storeys):
        inner = {room.id for room in storey.rooms if room.label != STAIRS and room.label not in OUTDOOR_LABELS}
        pairs: dict[frozenset[str], list[Boundary]] = defaultdict(list)
        for wall in boundaries(storey):
            sides = frozenset(room for room in wall.rooms if room is not None)
            if len(sides) == 2 and sides <= inner:
                pairs[sides].append(wall)
        found += [Partition(level, rooms, tuple(join_stretches(walls)), storey.height_m) for rooms, walls in pairs.items()]
    return found


def gap_area(opening: OpeningSpec, ceiling_m: float) -> float:
    """Return the area by which an opening permanently opens the wall [m²]; 0 for a door, because a door can be closed.

    `ceiling_m` is the height of the ceiling above the floor [m].
    """
    if opening.kind == "door":
        return 0.0
    low, high = opening.gap_m(ceiling_m)
    lacking = spandrel_area(opening.width_m) if opening.kind == "arch" else 0.0
    return opening.width_m * (min(high, ceiling_m) - low) - lacking
