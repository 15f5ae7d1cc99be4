"""The first layout sampler: rooms in bands on both sides of a hall, stairs at the hall's end, storeys stacked.

+-----------+-----------+---------+   north band
+-----------+-----------+---------+
|  hall                   stairs  |
+-------+---------+---------------+
| room  |  room   |  room         |   south band
+-------+---------+---------------+
|  garden                         |
+---------------------------------+
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from worlds.errors import WorldsError
from worlds.labels import STAIRS
from worlds.spec import HouseSpec, OpeningKind, OpeningSpec, RoomSpec, StoreySpec

Rectangle = tuple[float, float, float, float]
_STAIRS_LENGTH_M = 3.4
_DOOR_M = 0.95
_MIN_ROOM_M = 1.9
_CORNER_MARGIN_M = 0.15
_WEIGHTS = {
    "living room": 1.6, "open-plan office": 2.2, "meeting room": 1.3, "classroom": 1.8, "library": 1.5, "garage": 1.4,
    "gym": 1.4, "kitchen": 1.1, "bathroom": 0.85, "toilet": 0.6, "storage room": 0.7, "pantry": 0.6, "laundry room": 0.75,
    "print room": 0.7,
}  # fmt: skip


@dataclass(frozen=True)
class StoreyPlan:
    """What a storey holds; rooms in each band run from west to east."""

    south: tuple[str, ...]
    north: tuple[str, ...] = ()
    hall: str = "corridor"
    open_pairs: tuple[tuple[str, str], ...] = ()
    """Labels of neighbours in a band that have no wall between them."""
    garden: str | None = None
    """Label of the room south of the south band, reached from it."""


@dataclass(frozen=True)
class BandSizes:
    """Dimensions of the plan [m]."""

    width: float
    south: float
    hall: float
    north: float
    garden: float = 4.0


def sample_sizes(
    rng: np.random.Generator,
    width: tuple[float, float],
    depth: tuple[float, float] = (3.7, 4.6),
    hall: tuple[float, float] = (2.0, 2.3),
) -> BandSizes:
    """Draw the dimensions, each uniform in its range [m], to the centimetre."""

    def draw(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 2)

    return BandSizes(draw(*width), draw(*depth), draw(*hall), draw(*depth), draw(3.6, 4.6))


def lay_out(name: str, seed: int, plans: Sequence[StoreyPlan], sizes: BandSizes, rng: np.random.Generator) -> HouseSpec:
    """Place the rooms and openings of every storey and turn the whole plan to a random orientation.

    Raises `WorldsError` where a band is too short for its rooms.
    """
    turn = _random_symmetry(rng)
    storeys = [_storey(level, plan, plans, sizes, rng, turn) for level, plan in enumerate(plans)]
    return HouseSpec(name=name, seed=seed, storeys=tuple(storeys))


def _storey(
    level: int, plan: StoreyPlan, plans: Sequence[StoreyPlan], sizes: BandSizes, rng: np.random.Generator, turn: "_Symmetry"
) -> StoreySpec:
    has_stairs = len(plans) > 1
    hall_end = round(sizes.width - _STAIRS_LENGTH_M, 2) if has_stairs else sizes.width
    y0, y1, y2 = 0.0, sizes.south, round(sizes.south + sizes.hall, 2)
    hall: Rectangle = (0.0, y1, hall_end, y2)
    rooms: list[tuple[str, Rectangle]] = [(plan.hall, hall)]
    if has_stairs:
        rooms.append((STAIRS, (hall_end, y1, sizes.width, y2)))
    south = [(label, (x0, y0, x1, y1)) for label, x0, x1 in _share(plan.south, sizes.width, hall_end, rng)]
    north = [
        (label, (x0, y2, x1, round(y2 + sizes.north, 2))) for label, x0, x1 in _share(plan.north, sizes.width, hall_end, rng)
    ]
    rooms += south + north
    if plan.garden:
        rooms.append((plan.garden, (0.0, -sizes.garden, sizes.width, 0.0)))
    named = _name(rooms, level)
    openings = _stairs_openings(named, level, len(plans)) if has_stairs else []
    openings += _hall_doors(named, hall, hall_end, plan, rng) + _neighbours(named, plan) + _garden_door(named, plan, rng)
    return StoreySpec(
        rooms=tuple(RoomSpec(id=i, label=label, polygon_m=turn.polygon(r)) for i, label, r in named),
        openings=tuple(
            o.model_copy(update={"start_m": turn.point(o.start_m), "end_m": turn.point(o.end_m)}) for o in openings
        ),
    )


def _share(labels: Sequence[str], width: float, hall_end: float, rng: np.random.Generator) -> list[tuple[str, float, float]]:
    """Divide a band among its rooms by weight; every room keeps enough of the hall's wall for a door."""
    if not labels:
        return []
    weights = np.array([_WEIGHTS.get(label, 1.0) for label in labels]) * rng.uniform(0.85, 1.15, len(labels))
    cuts = _divide(width, weights)
    # The last room has to reach back to the hall past the stairs; the others make way.
    if (limit := hall_end - 1.4) < cuts[-2]:
        cuts = np.append(_divide(limit, weights[:-1]), width)
    if np.min(np.diff(cuts)) < _MIN_ROOM_M - 0.02:
        raise WorldsError(f"{len(labels)} rooms ({', '.join(labels)}) do not fit in a band of {width:.2f} m; make it wider")
    return [(label, float(x0), float(x1)) for label, x0, x1 in zip(labels, cuts[:-1], cuts[1:], strict=True)]


def _divide(length: float, weights: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n+1"]:
    """Cut `length` [m] so that each part has the least width of a room, and what is left by weight; to the centimetre."""
    parts = _MIN_ROOM_M + (length - len(weights) * _MIN_ROOM_M) * weights / weights.sum()
    return np.round(np.concatenate([[0.0], np.cumsum(parts)]), 2)


def _name(rooms: Sequence[tuple[str, Rectangle]], level: int) -> list[tuple[str, str, Rectangle]]:
    count: dict[str, int] = {}
    named = []
    for label, rectangle in rooms:
        count[label] = count.get(label, 0) + 1
        named.append((f"{label} {level}.{count[label]}", label, rectangle))
    return named


def _stairs_openings(named: Sequence[tuple[str, str, Rectangle]], level: int, levels: int) -> list[OpeningSpec]:
    """Way up over one half of the cell's front, way down over the other."""
    hall_id, _, _ = named[0]
    stairs_id, _, (x, y0, _, y1) = named[1]
    middle = (y0 + y1) / 2
    up = OpeningSpec(
        rooms=(hall_id, stairs_id), kind="open", start_m=(x, round(y0 + 0.05, 3)), end_m=(x, round(middle, 3)), leads="up"
    )
    down = OpeningSpec(
        rooms=(hall_id, stairs_id), kind="open", start_m=(x, round(middle, 3)), end_m=(x, round(y1 - 0.05, 3)), leads="down"
    )
    return ([up] if level + 1 < levels else []) + ([down] if level > 0 else [])


def _hall_doors(
    named: Sequence[tuple[str, str, Rectangle]], hall: Rectangle, hall_end: float, plan: StoreyPlan, rng: np.random.Generator
) -> list[OpeningSpec]:
    in_open_plan = {label for pair in plan.open_pairs for label in pair}
    doors = []
    for room_id, label, (x0, y0, x1, y1) in named[1:]:
        y = y1 if y1 == hall[1] else y0
        if label == STAIRS or y not in (hall[1], hall[3]):
            continue
        low, high = max(x0, hall[0]) + _CORNER_MARGIN_M, min(x1, hall_end) - _CORNER_MARGIN_M
        wide = label in in_open_plan and high - low > 2.2 and rng.random() < 0.5
        width = 1.6 if wide else _DOOR_M
        kind: OpeningKind = "cased" if wide else "door"
        start = round(float(rng.uniform(low, high - width)), 2)
        doors.append(_opening((named[0][0], room_id), kind, (start, y), (start + width, y)))
    return doors


def _neighbours(named: Sequence[tuple[str, str, Rectangle]], plan: StoreyPlan) -> list[OpeningSpec]:
    open_pairs = {frozenset(pair) for pair in plan.open_pairs}
    openings = []
    for (a, label_a, (_, y0, x1, y1)), (b, label_b, (x2, y2, _, _)) in itertools.pairwise(named):
        if x1 == x2 and y0 == y2 and {label_a, label_b} in open_pairs:
            openings.append(_opening((a, b), "open", (x1, y0), (x1, y1)))
    return openings


def _garden_door(
    named: Sequence[tuple[str, str, Rectangle]], plan: StoreyPlan, rng: np.random.Generator
) -> list[OpeningSpec]:
    if plan.garden is None:
        return []
    garden_id, *_ = named[-1]
    beside = [(i, r) for i, label, r in named if r[1] == 0.0 and label in ("living room", "dining room", "kitchen")]
    room_id, (x0, _, x1, _) = beside[int(rng.integers(len(beside)))]
    start = round(float(rng.uniform(x0 + 0.3, x1 - 0.3 - 1.3)), 2)
    return [_opening((room_id, garden_id), "cased", (start, 0.0), (start + 1.3, 0.0))]


def _opening(rooms: tuple[str, str], kind: OpeningKind, start: tuple[float, float], end: tuple[float, float]) -> OpeningSpec:
    return OpeningSpec(rooms=rooms, kind=kind, start_m=(start[0], start[1]), end_m=(round(end[0], 3), end[1]))


@dataclass(frozen=True)
class _Symmetry:
    """One of the eight symmetries of the square, about the origin."""

    swap: bool
    sign_x: float
    sign_y: float

    def point(self, p: tuple[float, float]) -> tuple[float, float]:
        x, y = (p[1], p[0]) if self.swap else p
        return (self.sign_x * x + 0.0, self.sign_y * y + 0.0)

    def polygon(self, rectangle: Rectangle) -> tuple[tuple[float, float], ...]:
        (xa, ya), (xb, yb) = self.point(rectangle[:2]), self.point(rectangle[2:])
        x0, x1, y0, y1 = min(xa, xb), max(xa, xb), min(ya, yb), max(ya, yb)
        return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def _random_symmetry(rng: np.random.Generator) -> _Symmetry:
    swap, mirror_x, mirror_y = rng.integers(0, 2, 3)
    return _Symmetry(bool(swap), 1.0 - 2.0 * mirror_x, 1.0 - 2.0 * mirror_y)


Sampler = Callable[[np.random.Generator], tuple[Sequence[StoreyPlan], BandSizes]]
