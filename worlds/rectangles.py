"""Rectangles of a plan with sides along x and y: overlap and growth."""

Rectangle = tuple[float, float, float, float]
"""A rectangle of the plan, as x0, y0, x1, y1 [m]."""
_Whole = tuple[int, int, int, int]


def overlap(a: Rectangle | _Whole, b: Rectangle | _Whole) -> bool:
    """Whether two rectangles in the same unit have an area in common; rectangles that only touch do not overlap."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def grown(r: Rectangle, by: float) -> Rectangle:
    """Return the rectangle, larger by `by` [m] on every side."""
    return r[0] - by, r[1] - by, r[2] + by, r[3] + by
