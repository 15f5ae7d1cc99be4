"""Stairs as boxes in W: steps, landings, floors inside the cell, and railings."""

import math
from collections.abc import Iterator, Sequence

from worlds.parts import Colour, Part
from worlds.spec import OpeningSpec
from worlds.stairs.cells import CellFrame
from worlds.stairs.flights import Rail, Slab
from worlds.walls import HALF_WALL_M

SLAB_THICKNESS_M = 0.3
WOOD: Colour = (0.62, 0.47, 0.33)
_DARK_WOOD = (0.36, 0.26, 0.18)
_RAIL_HEIGHT_M, _RAIL_M, _POST_M = 0.95, 0.05, 0.03
_RAIL_DEPTH_M = 0.2
"""Height of a rail's cross-section [m]. It exceeds a riser, so that the rails of neighbouring steps form one hand rail."""
_POST_SPACING_M = 0.3
_MIN_SILL_M = 0.02

Interval = tuple[float, float]


def slab_parts(slabs: Sequence[Slab], frame: CellFrame, floor_m: float) -> tuple[Part, ...]:
    """Return a box for each slab (step, landing or floor). `floor_m` is the height of the lower storey's floor in W [m]."""
    return tuple(_box(frame, s.u, s.v, (floor_m + s.top - SLAB_THICKNESS_M, floor_m + s.top), WOOD) for s in slabs)


def rail_parts(rails: Sequence[Rail], frame: CellFrame, floor_m: float) -> tuple[Part, ...]:
    """Return a hand rail on posts for each railing. `floor_m` is the height of the lower storey's floor in W [m].

    Each hand rail is thin and centred on the edge of the slab that it guards, so that it does not obstruct the walking line.
    """
    return tuple(part for rail in rails for part in _railing(rail, frame, floor_m))


def floor_beside_flight(opening: OpeningSpec, floor: Slab, frame: CellFrame) -> list[tuple[Slab, Rail]]:
    """Return pairs of a slab and a railing for an opening that is wider than the flight behind it.

    The flight begins or ends on the slab `floor`. Each part of the opening beside `floor` gets a slab as deep as half the
    wall, and a railing at the inner edge of this slab, beyond which there is a drop.
    """
    (ua, va), (ub, vb) = frame.plan(*opening.start_m), frame.plan(*opening.end_m)
    if abs(va - vb) > abs(ua - ub):
        depth, inner = ((0.0, HALF_WALL_M), HALF_WALL_M) if ua < frame.length / 2 else _far_side(frame.length)
        rest = _beside((min(va, vb), max(va, vb)), floor.v)
        return [(Slab(depth, v, floor.top), Rail((inner, v[0], floor.top), (inner, v[1], floor.top))) for v in rest]
    depth, inner = _far_side(frame.width)
    rest = _beside((min(ua, ub), max(ua, ub)), floor.u)
    return [(Slab(u, depth, floor.top), Rail((u[0], inner, floor.top), (u[1], inner, floor.top))) for u in rest]


def _far_side(end: float) -> tuple[Interval, float]:
    return (end - HALF_WALL_M, end), end - HALF_WALL_M


def _beside(whole: Interval, part: Interval) -> list[Interval]:
    pieces = (whole[0], min(whole[1], part[0])), (max(whole[0], part[1]), whole[1])
    return [piece for piece in pieces if piece[1] - piece[0] > _MIN_SILL_M]


def _railing(rail: Rail, frame: CellFrame, floor_m: float) -> Iterator[Part]:
    (u0, v0, z), (u1, v1, _) = rail.start, rail.end
    bottom, top, half = floor_m + z, floor_m + z + _RAIL_HEIGHT_M, _RAIL_M / 2
    # The rail is as long as the edge, and extends half its width to either side of it.
    du, dv = (0.0, half) if u1 > u0 else (half, 0.0)
    yield _box(frame, (u0 - du, u1 + du), (v0 - dv, v1 + dv), (top - _RAIL_DEPTH_M, top), _DARK_WOOD)
    posts = max(1, round(math.dist(rail.start, rail.end) / _POST_SPACING_M))
    for k in range(posts):
        u, v = (a + (k + 0.5) / posts * (b - a) for a, b in ((u0, u1), (v0, v1)))
        half = _POST_M / 2
        yield _box(frame, (u - half, u + half), (v - half, v + half), (bottom, top - _RAIL_DEPTH_M), _DARK_WOOD)


def _box(frame: CellFrame, u: Interval, v: Interval, z: Interval, colour: Colour) -> Part:
    (xa, ya), (xb, yb) = frame.world(u[0], v[0]), frame.world(u[1], v[1])
    centre = ((xa + xb) / 2, (ya + yb) / 2, (z[0] + z[1]) / 2)
    return Part("box", centre, (abs(xb - xa), abs(yb - ya), z[1] - z[0]), colour, "wood")
