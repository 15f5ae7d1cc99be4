"""`DoorLeaf`: the panel of a door as a placed object, at the angle that the spec gives."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from shapely.geometry import Polygon

from worlds.openings.opening_draft import LEAF_THICKNESS_M
from worlds.parts import Colour, Part, Vector
from worlds.placed import Placed
from worlds.spec import LeafSpec, OpeningSpec
from worlds.walls import Boundary

_GAP_M = 0.01
"""Gap between the leaf and the lintel above it [m]."""
_ARC_STEPS = 8
"""Number of straight pieces that approximate the arc of a leaf's tip."""
_STEEL: Colour = (0.72, 0.72, 0.74)
_PAINTS: tuple[tuple[Colour, str], ...] = (
    ((0.93, 0.92, 0.89), "plain"),
    ((0.8, 0.84, 0.84), "plain"),
    ((0.66, 0.47, 0.3), "wood"),
    ((0.5, 0.34, 0.22), "wood"),
    ((0.78, 0.63, 0.44), "wood"),
)


@dataclass(frozen=True, eq=False)
class DoorLeaf(Placed):
    """The leaf of a door at its angle. In its own frame it extends along x, with the hinge at the end of smaller x."""

    id: str
    storey: int
    opening: int
    """Index of the door's opening in the list of the storey's openings."""
    into: str
    """Id of the room that the leaf swings into."""
    hinge: tuple[float, float]
    """Position of the hinge, on the wall's centre line [m]."""
    shut_yaw: float
    """Direction from the hinge to the free end when the leaf is closed [rad]."""
    turn: float
    """Angle from the closed to the present position, positive counter-clockwise [rad]."""
    position: Vector
    size: Vector
    seed: int
    """Seed of the leaf's appearance."""

    @property
    def yaw(self) -> float:  # type: ignore[override]
        """Direction from the hinge to the free end [rad]."""
        return self.shut_yaw + self.turn

    @cached_property
    def swing(self) -> Polygon:
        """Swing area: the sector from the closed to the present position, but at least a quarter of a circle [m]."""
        return Polygon([self.hinge, *self.arc(math.copysign(max(abs(self.turn), math.pi / 2), self.turn))])

    def arc(self, turn: float) -> list[tuple[float, float]]:
        """Return the path of the free end from the closed position through an angle `turn` [rad], as points [m]."""
        (x, y), radius = self.hinge, self.size[0]
        angles = (self.shut_yaw + turn * i / _ARC_STEPS for i in range(_ARC_STEPS + 1))
        return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """A panel with two decorative fields and with a handle on both sides."""
        (width, thickness, height), rng = self.size, np.random.default_rng(self.seed)
        paint, material = _PAINTS[int(rng.integers(len(_PAINTS)))]
        shade: Colour = (0.88 * paint[0], 0.88 * paint[1], 0.88 * paint[2])
        grip = width / 2 - 0.07
        return (
            Part("box", (0.0, 0.0, height / 2), self.size, paint, material),
            *(
                Part("box", (0.0, 0.0, z * height), (0.66 * width, thickness + 0.008, share * height), shade, material)
                for z, share in ((0.27, 0.34), (0.71, 0.4))
            ),
            Part("box", (grip, 0.0, 1.02), (0.035, thickness + 0.012, 0.18), _STEEL, "metal"),
            Part("box", (grip, 0.0, 1.04), (0.018, thickness + 0.1, 0.018), _STEEL, "metal"),
            *(Part("box", (grip - 0.05, y, 1.04), (0.12, 0.014, 0.02), _STEEL, "metal") for y in (-0.065, 0.065)),
        )


def hang_leaves(
    level: int,
    pieces: Sequence[tuple[Boundary, OpeningSpec | None]],
    openings: Sequence[OpeningSpec],
    floor_m: float,
    seed: int,
) -> Iterator[DoorLeaf]:
    """Yield the leaves of a storey's `openings`.

    Args:
        level: index of the storey.
        pieces: the storey's room boundaries, cut into pieces at the openings. Each piece comes with the opening that fills
            it, or None for wall.
        openings: the storey's openings; an opening without a leaf, or in no boundary, is skipped.
        floor_m: height of the floor in W [m].
        seed: seed of the leaves' appearance, the same for all doors of the storey.
    """
    wall_of = {id(opening): boundary for boundary, opening in pieces if opening is not None}
    for index, opening in enumerate(openings):
        wall = wall_of.get(id(opening))
        if opening.leaf is not None and wall is not None:
            yield _hung(level, index, opening, opening.leaf, wall, floor_m, seed)


def _hung(
    level: int, index: int, opening: OpeningSpec, leaf: LeafSpec, wall: Boundary, floor_m: float, seed: int
) -> DoorLeaf:
    hinge, free = (opening.start_m, opening.end_m) if leaf.hinge == "start" else (opening.end_m, opening.start_m)
    width, along = opening.width_m, (free[0] - hinge[0], free[1] - hinge[1])
    across = 1.0 if wall.rooms[1] == leaf.into else -1.0
    # A leaf opens counter-clockwise if the room that it swings into is to the left of the closed leaf, seen from its hinge.
    left = along[0] if wall.axis == 0 else -along[1]
    turn = math.copysign(leaf.angle_rad, across * left)
    shut = math.atan2(along[1], along[0])
    x, y = hinge[0] + width / 2 * math.cos(shut + turn), hinge[1] + width / 2 * math.sin(shut + turn)
    return DoorLeaf(
        id=f"door/{level}/{index}",
        storey=level,
        opening=index,
        into=leaf.into,
        hinge=hinge,
        shut_yaw=shut,
        turn=turn,
        position=(x, y, floor_m),
        size=(width, LEAF_THICKNESS_M, opening.height_m - _GAP_M),
        seed=seed,
    )
