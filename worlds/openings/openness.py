"""`with_openness`: open or close the partitions of a house until it has the requested openness.

A partition is the wall between two indoor rooms. The openness of a house is the share of the area of all its partitions that
is permanently open: 0 if all openings are doors, 1 if the house has no inner walls.
"""

import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from worlds.errors import WorldsError, check_number
from worlds.furniture.catalogue import kind_of
from worlds.openings.door_swings import FRONT_M, hang_leaf, is_in_front
from worlds.openings.opening_draft import OpeningDraft
from worlds.openings.opening_forms import STYLES, Gaps, Task, area_of, closed, fully_open, open_by
from worlds.openings.partitions import Partition, gap_area, partitions
from worlds.rectangles import Rectangle
from worlds.spec import FurnitureSpec, HouseSpec, StoreySpec

_TIERS = {
    **dict.fromkeys(("kitchen", "dining room", "living room"), 0),
    **dict.fromkeys(("corridor", "entrance hall", "lobby", "open-plan office", "office", "meeting room", "library"), 1),
    **dict.fromkeys(("bedroom", "children's room", "bathroom", "toilet"), 3),
}
"""Tier of each room label: 0 for rooms that people like open, 1 for corridors and work rooms, 3 for private rooms, 2 for all
labels that are not named here. Partitions (walls between two rooms) of lower tiers are opened first."""
TOLERANCE = 0.05
"""Greatest difference between the openness that is reached and the target."""
_NEAR = 0.004
"""Openings are not adjusted any further once the openness differs from the target by at most this value."""
_AT_WALL_M = 0.6
"""Depth of the area in front of a wall in which furniture counts as standing at the wall [m]."""
_NARROW_M = 1.3
"""Openings narrower than this count as narrow [m]. No door leaf may stand in front of a new narrow opening."""


@dataclass(frozen=True)
class _PartPlan:
    """A partition (the wall between two rooms), the openings planned in it, and the way in which it would be opened."""

    part: Partition
    gaps: Gaps
    """The openings in the partition as planned so far."""
    old: Gaps
    """The openings in the partition before any change."""
    order: tuple[int, float]
    """Sort key: the tier (see `_TIERS`) of the more private of the two rooms, then a random number."""
    style: str
    """Name of the form, such as "arch", that is tried first when the partition is opened (see `opening_forms`)."""
    share: float
    """Share of the partition's area that is to be open when the partition is opened in its style."""
    draws: tuple[float, float, float]
    """Three numbers in [0, 1): they decide the position of openings, whether a leaf stands ajar, and the leaf's angle."""
    blocked: Gaps
    """Stretches of wall with furniture in front of them, as drafts of openings."""

    @property
    def area(self) -> float:
        """Area by which the planned openings open the partition [m²]."""
        return area_of(self.gaps, self.part)

    def task(self, area: float) -> Task:
        return Task(self.part, self.old, area, self.draws[0], self.blocked)

    def styled(self) -> "_PartPlan":
        return self.opened_by(self.share * self.part.area)

    def opened_by(self, area: float) -> "_PartPlan":
        return replace(self, gaps=open_by(self.task(area), self.style) if area > 0.0 else closed(self.task(0.0)))

    def full(self) -> "_PartPlan":
        return replace(self, gaps=fully_open(self.task(self.part.area)))

    def shut(self) -> "_PartPlan":
        return replace(self, gaps=closed(self.task(0.0)))


def openness_of(spec: HouseSpec) -> float:
    """Return the share of the area of all partitions that is permanently open, in [0, 1]; 0 without partitions."""
    parts = partitions(spec)
    total, pairs = sum(part.area for part in parts), {part.rooms for part in parts}
    gaps = sum(gap_area(o, s.height_m) for s in spec.storeys for o in s.openings if frozenset(o.rooms) in pairs)
    return min(gaps / total, 1.0) if total else 0.0  # rounding may leave a little more than 1


def with_openness(spec: HouseSpec, target: float, seed: int | None = None) -> HouseSpec:
    """Open the inner walls of a house, or close them with doors, until its openness is within 0.05 of `target`.

    The result is the spec of the same house with other openings. Only openings change, and rooms that were connected stay
    connected. Furniture that the spec lists stays where it is, so that it may stand in a new opening; `problems` tells.

    1. Sort the partitions: kitchens, dining and living rooms first, then corridors, lobbies and offices, bedrooms and
       bathrooms last. `seed` (None: the house's) draws the order within these tiers, and the form of each opening.
    2. `_share_out` opens the partitions in this order, or closes them in the reverse order, until changing the next
       partition would overshoot the target; this partition is changed only in part.
    3. An opening cannot have just any area, so a difference may be left. `_correct` changes other partitions to reduce it.
    4. The storeys whose openings changed are rebuilt, with leaves in the new doors.

    Raises `WorldsError` for a target outside of [0, 1], and for a target that cannot be reached because the inner walls are
    too short (less than 1.5 m in total).
    """
    check_number("openness", target, 0.0, 1.0, "0: all rooms are behind doors, 1: no inner walls")
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


def nearly_opened(spec: HouseSpec, target: float) -> HouseSpec:
    """Return the house with the given openness; the house as it is if its inner walls are too short for this openness.

    `houses` with `openness` draws such houses.
    """
    try:
        return with_openness(spec, target)
    except WorldsError:
        return spec


def _plans(spec: HouseSpec, seed: int) -> list[_PartPlan]:
    """Return a plan for every partition of a house, sorted in the order in which partitions are opened."""
    plans = []
    for part in partitions(spec):
        storey = spec.storeys[part.storey]
        rooms = {room.id: room for room in storey.rooms}
        gaps = tuple(
            OpeningDraft.of(opening, rooms) for opening in storey.openings if frozenset(opening.rooms) == part.rooms
        )
        # Each partition has its own generator, so that a change to one partition does not change the draws of the others.
        rng = np.random.default_rng([seed, zlib.crc32("|".join(sorted(part.rooms)).encode())])
        draws = rng.random(5).tolist()
        style = list(STYLES)[int(draws[3] * len(STYLES))]
        low, high = STYLES[style]
        order = max(_TIERS.get(rooms[room].label, 2) for room in part.rooms), draws[4]
        blocked = _blocked(part, storey)
        plans.append(_PartPlan(part, gaps, gaps, order, style, low + draws[1] * (high - low), tuple(draws[:3]), blocked))
    return sorted(plans, key=lambda plan: plan.order)


def _excess(plans: Sequence[_PartPlan], goal: float) -> float:
    """Open area of all plans together, minus the goal [m²]."""
    return sum(plan.area for plan in plans) - goal


def _share_out(plans: list[_PartPlan], goal: float) -> None:
    """Open or close partitions until the open area of all partitions together reaches `goal` [m²].

    `plans` holds the planned openings of each partition; it is changed in place. The changes are those of `_steps`, in
    order. A change in the wrong direction is skipped: for example, a partition may already be more open than its style would
    make it. The first change that would overshoot the goal is the last. It is made only in part, and only if this brings the
    area nearer to the goal.
    """
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


def _steps(plans: list[_PartPlan], opening: bool) -> Iterator[tuple[int, _PartPlan]]:
    """Yield the changes to try, in order, each as the index of a plan and the plan's new version.

    To open a house, each tier is treated in turn: first each partition of the tier is opened in its style, then each
    partition is removed as a whole, so that all partitions of a tier are opened a little before the first disappears. To
    close a house, each partition is closed, the most private partition first.
    """
    if not opening:
        yield from ((i, plans[i].shut()) for i in reversed(range(len(plans))))
        return
    for tier in range(4):
        members = [i for i, plan in enumerate(plans) if plan.order[0] == tier]
        yield from ((i, plans[i].styled()) for i in members)
        yield from ((i, plans[i].full()) for i in members)


def _correct(plans: list[_PartPlan], goal: float, enough: float) -> None:
    """Reduce the difference between the open area of all plans and the goal [m²] until it is at most `enough` [m²].

    One partition after another is opened or closed by the difference that is left. A change is kept only if it reduces the
    difference.
    """
    for i in range(len(plans)):
        excess = _excess(plans, goal)
        if abs(excess) <= enough:
            return
        new = plans[i].opened_by(max(0.0, plans[i].area - excess))
        if abs(excess + new.area - plans[i].area) < abs(excess):
            plans[i] = new


def _rebuild(storey: StoreySpec, changed: Sequence[_PartPlan]) -> StoreySpec:
    """Return the storey with the openings of some partitions replaced, and with leaves in the new doors.

    Old leaves stay, unless they would stand in front of a narrow new opening; these leaves are hung differently or removed.
    """
    rooms = {room.id: room for room in storey.rooms}
    pairs = {plan.part.rooms for plan in changed}
    kept = [opening for opening in storey.openings if frozenset(opening.rooms) not in pairs]
    new = [(gap, plan.draws) for plan in changed for gap in plan.gaps]
    gaps = [OpeningDraft.of(opening, rooms) for opening in kept] + [gap for gap, _ in new]
    draws = [(0.5, 0.5)] * len(kept) + [(ajar, angle) for _, (_, ajar, angle) in new]
    narrow = [gap for gap, _ in new if gap.width < _NARROW_M]
    obstacles = [_footprint(piece) for piece in _blocking_furniture(storey)]
    openings = kept + [gap.spec() for gap, _ in new]
    for k, gap in enumerate(gaps):
        bare = gap.leaf is None and k >= len(kept)
        if gap.kind == "door" and (bare or any(is_in_front(gap, other, FRONT_M) for other in narrow)):
            gaps[k] = replace(gap, leaf=hang_leaf(gap, gaps, rooms, draws[k], obstacles))
            openings[k] = gaps[k].spec()
    return storey.model_copy(update={"openings": tuple(openings)})


def _blocking_furniture(storey: StoreySpec) -> list[FurnitureSpec]:
    """Return the solid furniture in the spec that is low enough to block people."""
    return [piece for piece in storey.furniture or () if kind_of(piece.kind).solid and piece.position_m[2] < 2.0]


def _footprint(piece: FurnitureSpec) -> Rectangle:
    """Return the axis-aligned bounding rectangle of a piece in the plan [m]."""
    (x, y, _), (width, depth, _) = piece.position_m, piece.size_m
    cos, sin = abs(math.cos(piece.yaw_rad)) / 2, abs(math.sin(piece.yaw_rad)) / 2
    dx, dy = width * cos + depth * sin, width * sin + depth * cos
    return x - dx, y - dy, x + dx, y + dy


def _blocked(part: Partition, storey: StoreySpec) -> Gaps:
    """Return the stretches of a partition's walls that have furniture in front, as drafts of openings for `free_spans`."""
    rooms = sorted(part.rooms)
    found = []
    for x0, y0, x1, y1 in (_footprint(piece) for piece in _blocking_furniture(storey) if piece.room in part.rooms):
        for wall in part.walls:
            along, across = ((x0, x1), (y0, y1)) if wall.axis == 0 else ((y0, y1), (x0, x1))
            if across[0] < wall.at + _AT_WALL_M and across[1] > wall.at - _AT_WALL_M:
                found.append(OpeningDraft((rooms[0], rooms[1]), "open", wall.axis, wall.at, *along))
    return tuple(found)
