"""Rooms as sets of rectangles in whole centimetres.

Floor plans are computed in integers, so that the walls of neighbouring rooms coincide exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

RectCm = tuple[int, int, int, int]
"""A rectangle of the plan, as x0, y0, x1, y1 [cm]."""
Corner = tuple[int, int]


@dataclass(frozen=True)
class Edge:
    """A straight line along which a row of rooms stands, with coordinates of its own.

    The origin of these coordinates is at (`x`, `y`) in the plan [cm]; u runs along the line, v away from it.
    """

    x: int
    y: int
    along: Corner
    """Unit vector of u in the plan."""
    out: Corner
    """Unit vector of v in the plan."""

    def rect(self, u0: int, v0: int, u1: int, v1: int) -> RectCm:
        """Convert the rectangle with opposite corners (u0, v0) and (u1, v1) [cm] to the plan's coordinates."""
        (ax, ay), (bx, by) = self.point(u0, v0), self.point(u1, v1)
        return min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)

    def point(self, u: int, v: int) -> Corner:
        """Convert the point (u, v) [cm] to the plan's coordinates."""
        return self.x + u * self.along[0] + v * self.out[0], self.y + u * self.along[1] + v * self.out[1]


@dataclass(frozen=True)
class SquareSymmetry:
    """One of the eight symmetries of a square about the origin: x and y are swapped or not, then each is negated or not."""

    swap: bool
    flip_x: bool
    flip_y: bool

    def point(self, p: Corner) -> Corner:
        """Apply the symmetry to a point."""
        x, y = (p[1], p[0]) if self.swap else p
        return (-x if self.flip_x else x), (-y if self.flip_y else y)

    def rect(self, r: RectCm) -> RectCm:
        """Apply the symmetry to a rectangle."""
        (xa, ya), (xb, yb) = self.point(r[:2]), self.point(r[2:])
        return min(xa, xb), min(ya, yb), max(xa, xb), max(ya, yb)


def metres(p: Corner) -> tuple[float, float]:
    """Convert a point from centimetres to metres."""
    return p[0] / 100, p[1] / 100


def area_m2(rects: Sequence[RectCm]) -> float:
    """Return the total area of rectangles that do not overlap [m²]."""
    return sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in rects) / 1e4


def contact(a: Sequence[RectCm], b: Sequence[RectCm]) -> int:
    """Return the length of the longest stretch along which a rectangle of `a` touches one of `b`; 0 if none touch [cm]."""
    return max((_side(p, q) for p in a for q in b), default=0)


def _side(p: RectCm, q: RectCm) -> int:
    x, y = min(p[2], q[2]) - max(p[0], q[0]), min(p[3], q[3]) - max(p[1], q[1])
    return max(x, y) if min(x, y) == 0 else 0


def outline(rects: Sequence[RectCm]) -> tuple[Corner, ...]:
    """Return the corners of the union of rectangles, counter-clockwise [cm].

    The rectangles must not overlap, and their union must be one piece without holes. The sides of every rectangle, directed
    counter-clockwise, are cut at the x and y of all corners. A piece that appears in both directions lies inside the union
    and is removed; the other pieces are the outline.
    """
    if len(rects) == 1:
        x0, y0, x1, y1 = rects[0]
        return (x0, y0), (x1, y0), (x1, y1), (x0, y1)
    xs, ys = sorted({x for r in rects for x in r[::2]}), sorted({y for r in rects for y in r[1::2]})
    edges: set[tuple[Corner, Corner]] = set()
    for x0, y0, x1, y1 in rects:
        across, up = [x for x in xs if x0 <= x <= x1], [y for y in ys if y0 <= y <= y1]
        ring = [(x, y0) for x in across] + [(x1, y) for y in up[1:]]
        ring += [(x, y1) for x in reversed(across[:-1])] + [(x0, y) for y in reversed(up[:-1])]
        for side in pairwise(ring):
            # Where two rectangles touch, their sides have opposite directions and cancel.
            if side[::-1] in edges:
                edges.remove(side[::-1])
            else:
                edges.add(side)
    return _corners(dict(edges))


def _corners(successor: dict[Corner, Corner]) -> tuple[Corner, ...]:
    """Return the points of a closed outline at which its direction changes; `successor` maps each point to the next."""
    first = min(successor)
    corners, before, here = [first], first, successor[first]
    while here != first:
        after = successor[here]
        if (after[0] - here[0]) * (here[1] - before[1]) != (after[1] - here[1]) * (here[0] - before[0]):
            corners.append(here)
        before, here = here, after
    return tuple(corners)
