"""Widths of the bays of a band, and the rectangles that their rooms cover; all lengths are in whole centimetres.

A bay is one slice of a band (a row of rooms along a corridor). It holds one main room, the host, and up to two small rooms
carved from it; `programmes` shows the forms in a drawing. A bay is as deep as its band, so its area follows from its width:

1. `bay_width` gives each bay the width at which its rooms get the areas that were chosen at random for them.
2. `share_out` widens the bays of a band until they fill the band's length.
3. `bay_rooms` cuts the bay into rectangles: the small rooms keep their size, the host gets everything else.
"""

import math
from collections.abc import Sequence

from worlds.floor_plans.programmes import Bay, BayGroup
from worlds.floor_plans.rectangles import Edge, RectCm
from worlds.floor_plans.room_sizes import SIZES

DOOR_FRONT = 140
"""Least width that the main room of a bay (a slice of a row of rooms) keeps along the corridor, enough for its door [cm]."""
_ARM = 170
"""Least depth of the part of a main room behind a small room carved from it, so that this part can be used [cm]."""
_SLENDER = {"toilet": 2.6, "storage room": 2.6, "pantry": 2.6, "laundry room": 2.4, "bathroom": 2.2, "print room": 2.2}
"""Greatest ratio of depth to width of a bay, by the label of its main room; `_MOST_SLENDER` for all other labels."""
_MOST_SLENDER = 1.75


def bay_width(bay: Bay, depth: int) -> int:
    """Return the preferred width of a bay in a band (a row of rooms) of this depth, rounded up to 5 cm [cm].

    The preferred width is the largest of three widths:

    - the width at which the rooms get the areas chosen for them;
    - the least width at which the host (the main room) is neither too narrow nor too slender;
    - the least width at which the small rooms carved from the host leave it enough width beside them.
    """
    host = bay.labels[0]
    wished = round(sum(bay.areas) * 1e4 / depth)
    least = max(round(100 * SIZES[host].side_m), math.ceil(depth / _SLENDER.get(host, _MOST_SLENDER)))
    carved = sum(_small_size(bay, i, depth)[0] for i in range(1, len(bay.labels)))
    # What the host keeps of the width beside the carved rooms; both sides of a "middle" room are wide enough for a door.
    front = {"plain": 0, "inner": 120, "middle": 2 * DOOR_FRONT}.get(bay.form, 160)
    return 5 * math.ceil(max(wished, least, carved + front) / 5)


def group_width(group: BayGroup, depth: int) -> int:
    """Return the width that a group of bays prefers in a band (a row of rooms) of the given depth [cm].

    A bay is a main room with the small rooms carved from it. The width is the sum of the preferred widths of the bays.
    """
    return sum(bay_width(bay, depth) for bay in group.bays)


def _small_size(bay: Bay, i: int, depth: int) -> tuple[int, int]:
    """Return the width (along the corridor) and depth of the i-th room of a bay, a small room (i > 0) [cm].

    Both are multiples of 5 cm. The small room is a little deeper than wide, but leaves a usable part of the main room behind
    it.
    """
    side, area = round(100 * SIZES[bay.labels[i]].side_m), bay.areas[i] * 1e4
    most = max(side, depth - _ARM)
    deep = 5 * round(min(max(math.sqrt(1.3 * area), side), most) / 5)
    return 5 * math.ceil(max(side, area / deep) / 5), deep


def bay_rooms(bay: Bay, edge: Edge, start: int, width: int, depth: int) -> list[tuple[RectCm, ...]]:
    """Return the rectangles in the plan [cm] for every room of a bay, the main room first.

    The bay stands along `edge`, from `start` to `start + width`, and is `depth` deep. Inside this function, rectangles have
    coordinates of the bay: x runs along `edge`, and y away from it. `_placed` converts them to coordinates of the plan.
    """
    cut = [_small_size(bay, i, depth) for i in range(1, len(bay.labels))]
    rooms: list[tuple[RectCm, ...]]
    match bay.form:
        case "plain":
            rooms = [((0, 0, width, depth),)]
        case "corner":
            ((m, d),) = cut
            rooms = [((m, 0, width, d), (0, d, width, depth)), ((0, 0, m, d),)]
        case "inner":
            back, n = depth - max(d for _, d in cut), cut[1][0] if len(cut) > 1 else 0
            m = cut[0][0]
            rooms = [((0, 0, width, back), (m, back, width - n, depth)), ((0, back, m, depth),)]
            rooms += [((width - n, back, width, depth),)] if n else []
        case "middle":
            ((m, d),) = cut
            left = (width - m) // 2
            host = ((0, 0, left, d), (left + m, 0, width, d), (0, d, width, depth))
            rooms = [host, ((left, 0, left + m, d),)]
        case "corners":
            (m, d), (n, e) = cut
            # Both small rooms are equally deep, so that the host's part behind them is one rectangle.
            d = e = max(d, e)
            rooms = [((m, 0, width - n, d), (0, d, width, depth)), ((0, 0, m, d),), ((width - n, 0, width, e),)]
    return [tuple(_placed(r, bay, edge, start, width) for r in rects) for rects in rooms]


def _placed(r: tuple[int, int, int, int], bay: Bay, edge: Edge, start: int, width: int) -> RectCm:
    u0, v0, u1, v1 = r
    if bay.flipped:
        u0, u1 = width - u1, width - u0
    return edge.rect(start + u0, v0, start + u1, v1)


def share_out(widths: Sequence[int], bays: Sequence[Bay], length: int) -> list[int]:
    """Return the widths of bays, enlarged in proportion until they fill `length`, at least the sum of `widths` [cm].

    The new widths are rounded down to centimetres. The rest goes to the last bay without a twin, because twins must stay
    equal, or to the last bay if all bays are twins.
    """
    total = sum(widths)
    out = [w + (length - total) * w // total for w in widths]
    rest = length - sum(out)
    others = [i for i, bay in enumerate(bays) if bay.twin is None] or [len(bays) - 1]
    out[others[-1]] += rest
    return out
