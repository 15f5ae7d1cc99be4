"""`with_openness`: open or close the partitions of a house until it is as open as asked for.

The openness of a house is the share of the area of all partitions between indoor rooms that is gap for good: 0 where every
room is behind doors, 1 where there is no inner wall.
"""

import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from worlds.errors import WorldsError
from worlds.furniture.catalogue import kind_of
from worlds.openings.door_swings import hang_leaf, is_in_front
from worlds.openings.opening_draft import OpeningDraft, Rectangle
from worlds.openings.opening_forms import STYLES, Gaps, Task, area_of, closed, fully_open, open_by
from worlds.openings.partitions import Partition, gap_area, partitions
from worlds.spec import FurnitureSpec, HouseSpec, StoreySpec

_TIERS = {
    **dict.fromkeys(("kitchen", "dining room", "living room"), 0),
    **dict.fromkeys(("corridor", "entrance hall", "lobby", "open-plan office", "office", "meeting room", "library"), 1),
    **dict.fromkeys(("bedroom", "children's room", "bathroom", "toilet"), 3),
}
"""What people open first; rooms not named come third, and what is private last."""
TOLERANCE = 0.05
_NEAR = 0.004
"""Nearer than this to the target, no further partition is touched."""
_FRONT_M = 0.6
_NARROW_M = 1.3
"""Before gaps narrower than this no leaf may stand."""


@dataclass(frozen=True)
class _Plan:
    """A partition, what is in it, and how it would be opened."""

    part: Partition
    gaps: Gaps
    old: Gaps
    order: tuple[int, float]
    style: str
    share: float
    draws: tuple[float, float, float]
    blocked: Gaps

    @property
    def area(self) -> float:
        return area_of(self.gaps, self.part)

    def task(self, area: float) -> Task:
        return Task(self.part, self.old, area, self.draws[0], self.blocked)

    def styled(self) -> "_Plan":
        return self.opened_by(self.share * self.part.area)

    def opened_by(self, area: float) -> "_Plan":
        return replace(self, gaps=open_by(self.task(area), self.style) if area > 0.0 else closed(self.task(0.0)))

    def full(self) -> "_Plan":
        return replace(self, gaps=fully_open(self.task(self.part.area)))

    def shut(self) -> "_Plan":
        return replace(self, gaps=closed(self.task(0.0)))


def openness_of(spec: HouseSpec) -> float:
    """The share of all partitions' area that is gap; 0 for a house without partitions."""
    parts = partitions(spec)
    total, pairs = sum(part.area for part in parts), {part.rooms for part in parts}
    gaps = sum(gap_area(o, s.height_m) for s in spec.storeys for o in s.openings if frozenset(o.rooms) in pairs)
    return gaps / total if total else 0.0


def with_openness(spec: HouseSpec, target: float, seed: int | None = None) -> HouseSpec:
    """The same house with its inner walls opened, or closed with doors, until its openness is within 0.05 of `target`.

    Nothing but openings changes, and what was joined stays joined. Kitchens, dining and living rooms open first, then
    corridors, lobbies and offices, bedrooms and bathrooms last; closing goes the other way. `seed` (absent: the house's)
    draws the order among equals and the ways of opening. Raises `WorldsError` for a target outside of [0, 1], and where the
    inner walls are so short (less than 1.5 m in all) that there is no such house.
    """
    if not 0.0 <= target <= 1.0:
        raise WorldsError(f"no house has openness {target}; valid: 0 (all rooms behind doors) to 1 (no inner walls)")
    before = _plans(spec, spec.seed if seed is None else seed)
    total = sum(plan.part.area for plan in before)
    after = list(before)
    if abs(_excess(after, target * total)) > _NEAR * total:
        _share_out(after, target * total)
        _correct(after, target * total, _NEAR * total)
    if total and abs(off := _excess(after, target * total) / total) > TOLERANCE:
        raise WorldsError(f"the inner walls are too short for openness {target:.2f}; the nearest is {target + off:.2f}")
    storeys = []
    for level, storey in enumerate(spec.storeys):
        changed = [new for old, new in zip(before, after, strict=True) if new.gaps != old.gaps and new.part.storey == level]
        storeys.append(_rebuild(storey, changed) if changed else storey)
    return spec.model_copy(update={"storeys": tuple(storeys)})


def _plans(spec: HouseSpec, seed: int) -> list[_Plan]:
    """All partitions, what people open first at the head."""
    plans = []
    for part in partitions(spec):
        storey = spec.storeys[part.storey]
        rooms = {room.id: room for room in storey.rooms}
        gaps = tuple(
            OpeningDraft.of(opening, rooms) for opening in storey.openings if frozenset(opening.rooms) == part.rooms
        )
        rng = np.random.default_rng([seed, zlib.crc32("|".join(sorted(part.rooms)).encode())])
        draws = rng.random(5).tolist()
        style = list(STYLES)[int(draws[3] * len(STYLES))]
        low, high = STYLES[style]
        order = max(_TIERS.get(rooms[room].label, 2) for room in part.rooms), draws[4]
        blocked = _blocked(part, storey)
        plans.append(_Plan(part, gaps, gaps, order, style, low + draws[1] * (high - low), tuple(draws[:3]), blocked))
    return sorted(plans, key=lambda plan: plan.order)


def _excess(plans: Sequence[_Plan], goal: float) -> float:
    return sum(plan.area for plan in plans) - goal


def _share_out(plans: list[_Plan], goal: float) -> None:
    """Take step after step towards the goal [m²], the one that would overshoot in part."""
    lacking = -_excess(plans, goal)
    opening = lacking > 0.0
    for i, new in _steps(plans, opening):
        gain = new.area - plans[i].area
        if (gain <= 0.0) if opening else (gain >= 0.0):
            continue
        if abs(gain) > abs(lacking):
            part_way = plans[i].opened_by(plans[i].area + lacking)
            if abs(lacking - (part_way.area - plans[i].area)) < abs(lacking):
                plans[i] = part_way
            return
        plans[i] = new
        lacking -= gain


def _steps(plans: list[_Plan], opening: bool) -> Iterator[tuple[int, _Plan]]:
    """Partition by partition, what it would be next: tier by tier each in its style, then each without walls; or shut."""
    if not opening:
        yield from ((i, plans[i].shut()) for i in reversed(range(len(plans))))
        return
    for tier in range(4):
        members = [i for i, plan in enumerate(plans) if plan.order[0] == tier]
        yield from ((i, plans[i].styled()) for i in members)
        yield from ((i, plans[i].full()) for i in members)


def _correct(plans: list[_Plan], goal: float, enough: float) -> None:
    """Where the last partition could not take exactly what was left, let others take it."""
    for i in range(len(plans)):
        excess = _excess(plans, goal)
        if abs(excess) <= enough:
            return
        new = plans[i].opened_by(max(0.0, plans[i].area - excess))
        if abs(excess + new.area - plans[i].area) < abs(excess):
            plans[i] = new


def _rebuild(storey: StoreySpec, changed: Sequence[_Plan]) -> StoreySpec:
    """The storey with the openings of some partitions replaced, and leaves in the new doors."""
    rooms = {room.id: room for room in storey.rooms}
    pairs = {plan.part.rooms for plan in changed}
    kept = [opening for opening in storey.openings if frozenset(opening.rooms) not in pairs]
    new = [(gap, plan.draws) for plan in changed for gap in plan.gaps]
    gaps = [OpeningDraft.of(opening, rooms) for opening in kept] + [gap for gap, _ in new]
    draws = [(0.5, 0.5)] * len(kept) + [(ajar, angle) for _, (_, ajar, angle) in new]
    narrow = [gap for gap, _ in new if gap.width < _NARROW_M]
    obstacles = [_footprint(piece) for piece in _standing(storey)]
    openings = kept + [gap.spec() for gap, _ in new]
    for k, gap in enumerate(gaps):
        bare = gap.leaf is None and k >= len(kept)
        if gap.kind == "door" and (bare or any(is_in_front(gap, other, _FRONT_M) for other in narrow)):
            gaps[k] = replace(gap, leaf=hang_leaf(gap, gaps, rooms, draws[k], obstacles))
            openings[k] = gaps[k].spec()
    return storey.model_copy(update={"openings": tuple(openings)})


def _standing(storey: StoreySpec) -> list[FurnitureSpec]:
    return [piece for piece in storey.furniture or () if kind_of(piece.kind).solid and piece.position_m[2] < 2.0]


def _footprint(piece: FurnitureSpec) -> Rectangle:
    """The rectangle around a piece."""
    (x, y, _), (width, depth, _) = piece.position_m, piece.size_m
    cos, sin = abs(math.cos(piece.yaw_rad)) / 2, abs(math.sin(piece.yaw_rad)) / 2
    dx, dy = width * cos + depth * sin, width * sin + depth * cos
    return x - dx, y - dy, x + dx, y + dy


def _blocked(part: Partition, storey: StoreySpec) -> Gaps:
    """The stretches of a partition's walls that furniture stands before."""
    rooms = sorted(part.rooms)
    found = []
    for x0, y0, x1, y1 in (_footprint(piece) for piece in _standing(storey) if piece.room in part.rooms):
        for wall in part.walls:
            along, across = ((x0, x1), (y0, y1)) if wall.axis == 0 else ((y0, y1), (x0, x1))
            if across[0] < wall.at + _FRONT_M and across[1] > wall.at - _FRONT_M:
                found.append(OpeningDraft((rooms[0], rooms[1]), "open", wall.axis, wall.at, *along))
    return tuple(found)
