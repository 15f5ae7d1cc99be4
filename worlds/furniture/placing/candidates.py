"""Candidate poses for a piece, best first; each kind of place (`worlds.furniture.kinds.Place`) has its own function.

The candidates are not checked for collisions: `RoomPlan.claim_first_free` takes the first pose at which the piece fits.
"""

from collections.abc import Callable, Iterator
from itertools import chain

from worlds.furniture.kinds import AgainstWall, Around, OnCeiling, OnFloor, OnTop, OnWall, Place, Size
from worlds.furniture.placing.draws import Draws
from worlds.furniture.placing.piece import Piece, Pose
from worlds.furniture.placing.room_plan import RoomPlan
from worlds.walls import HALF_WALL_M

WALL_GAP_M = 0.006
"""Gap between a wall and a piece with its back to the wall [m]."""
_ABUT_M = 0.002
"""Gap between pieces that stand side by side [m]."""
_FLOOR_TRIES = 14
_TOP_TRIES = 8
_WALL_TRIES = 12
_UNDER_M = 0.02
"""Least distance between a piece and the piece that hangs above it [m]."""


def candidates(plan: RoomPlan, place: Place, size: Size, host: Piece | None, draws: Draws) -> Iterator[Pose]:
    """Yield poses for a piece of `size` in a kind of `place`, best first, all at the same height.

    `host` is the piece that the new piece stands at or on, or hangs above; None if the new piece needs no host.
    """
    return _BY_PLACE[type(place)](plan, place, size, host, draws)


def _against_wall(plan: RoomPlan, place: AgainstWall, size: Size, host: Piece | None, draws: Draws) -> Iterator[Pose]:
    # (score, index of the wall, distance along it): a random number plus a bonus for wall ends and preferred neighbours.
    scored: list[tuple[float, int, float]] = []
    half, random, corner = size.width / 2, draws.random, 1.0 if place.corner else 0.35
    margin = HALF_WALL_M + WALL_GAP_M + half
    for index, run in enumerate(plan.runs):
        beside: list[tuple[float, float]] = []
        for piece in plan.at_wall[index]:
            centre, reach = run.side.along(piece.pose[:2]), piece.size.width / 2 + half + _ABUT_M
            bonus = 2.0 if piece.kind.name in place.beside else 0.2
            beside += [(centre - reach, bonus), (centre + reach, bonus)]
        for low, high in run.free:
            low, length = low + margin, high - low - 2 * margin
            if length < 0.0:
                continue
            scored += [(corner + random(), index, low), (corner + random(), index, low + length)]
            scored += [(random(), index, low + random() * length) for _ in range(3)]
            scored += [(bonus + random(), index, t) for t, bonus in beside if low <= t <= low + length]
    for _, index, t in sorted(scored, reverse=True):
        yield _backed(plan, index, t, size.depth, 0.0)


def _on_floor(plan: RoomPlan, place: OnFloor, size: Size, host: Piece | None, draws: Draws) -> Iterator[Pose]:
    width, depth = plan.shape.size
    random = draws.random
    if place.spot == "anywhere":
        for _ in range(_FLOOR_TRIES):
            yield Pose(random() * width, random() * depth, draws.index(4))
        return
    # In the middle of a room, the longer side of a piece runs along the longer side of the room. Candidates start at the
    # centre and spread out; the later ones are also tried at a right angle.
    lengthwise = int(width < depth) if size.width >= size.depth else int(width >= depth)
    for i in range(_FLOOR_TRIES + 1):
        spread = 0.0 if i == 0 else 0.1 + 0.05 * i
        turn = lengthwise + 2 * draws.index(2) + (i >= 8)
        yield Pose(width * (0.5 + spread * (random() - 0.5)), depth * (0.5 + spread * (random() - 0.5)), turn % 4)


def _around(plan: RoomPlan, place: Around, size: Size, host: Piece | None, draws: Draws) -> Iterator[Pose]:
    if host is None:
        return
    turn, front = host.pose.turn, host.size.depth / 2 + place.gap_m + size.depth / 2
    if place.side == "front":
        offsets = chain((0.0,), (draws.uniform(-0.25, 0.25) * host.size.width for _ in range(3)))
        yield from (_facing(host, x, front, turn + 2) for x in offsets)
        return
    for x in _evenly(host.size.width, size.width):
        yield _facing(host, x, front, turn + 2)
        yield _facing(host, x, -front, turn)
    side = host.size.width / 2 + place.gap_m + size.depth / 2
    for y in _evenly(host.size.depth, size.width):
        yield _facing(host, side, y, turn + 1)
        yield _facing(host, -side, y, turn + 3)


def _facing(host: Piece, x: float, y: float, turn: int) -> Pose:
    return Pose(*host.pose.moved(x, y), turn % 4)


def _on_top(plan: RoomPlan, place: OnTop, size: Size, host: Piece | None, draws: Draws) -> Iterator[Pose]:
    if host is None:
        return
    room_x, room_y = (host.size.width - size.width) / 2 - 0.01, (host.size.depth - size.depth) / 2 - 0.01
    if min(room_x, room_y) < 0.0:
        return
    fixed = {"back": -room_y, "middle": 0.0, "front": room_y}.get(place.at)
    for _ in range(_TOP_TRIES):
        x, y = draws.uniform(-room_x, room_x), draws.uniform(-room_y, room_y)
        yield Pose(*host.pose.moved(x, y if fixed is None else fixed), host.pose.turn, host.pose.z + host.size.height)


def _on_wall(plan: RoomPlan, place: OnWall, size: Size, host: Piece | None, draws: Draws) -> Iterator[Pose]:
    z = min(draws.uniform(*place.height_m), plan.height_m - size.height - 0.05)
    if place.above:
        if host is not None and host.pose.run is not None:
            t = plan.runs[host.pose.run].side.along(host.pose[:2])
            yield _backed(plan, host.pose.run, t, size.depth, max(z, host.size.height + _UNDER_M))
        return
    margin = size.width / 2 + 0.12
    stretches = [
        (index, low + margin, high - margin)
        for index, run in enumerate(plan.runs)
        for low, high in run.free
        if high - low > 2 * margin
    ]
    for _ in range(_WALL_TRIES if stretches else 0):
        index, low, high = stretches[draws.index(len(stretches))]
        yield _backed(plan, index, draws.uniform(low, high), size.depth, z)


def _on_ceiling(plan: RoomPlan, place: OnCeiling, size: Size, host: Piece | None, draws: Draws) -> Iterator[Pose]:
    z = plan.height_m - size.height
    return (Pose(x, y, turn, z) for x, y, turn, *_ in _on_floor(plan, OnFloor("centre"), size, None, draws))


def _backed(plan: RoomPlan, index: int, t: float, depth: float, z: float) -> Pose:
    """Return the pose of a piece with its back to wall `index`, at distance `t` along the wall and at height `z` [m]."""
    side = plan.runs[index].side
    return Pose(*side.at(t, HALF_WALL_M + WALL_GAP_M + depth / 2), side.turn, z, index)


def _evenly(length: float, each: float) -> list[float]:
    """Return the positions of seats along a side of `length`, relative to the middle of the side [m].

    There are as many seats of width `each` [m] as fit with gaps of 0.1 m, but at least one.
    """
    count = max(1, int(length / (each + 0.1)))
    return [(i + 0.5) * length / count - length / 2 for i in range(count)]


_Finder = Callable[..., Iterator[Pose]]
_BY_PLACE: dict[type[Place], _Finder] = {
    AgainstWall: _against_wall,
    OnFloor: _on_floor,
    Around: _around,
    OnTop: _on_top,
    OnWall: _on_wall,
    OnCeiling: _on_ceiling,
}
