"""Where a piece could go, best first, before anything is checked: one function per kind of place."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, Around, Kind, OnCeiling, OnFloor, OnTop, OnWall, Place, Size
from worlds.furniture.room_plan import HALF_WALL_M, WALL_GAP_M, RoomPlan

_ABUT_M = 0.002
_WALL_TRIES = 12
_UNDER_M = 0.02
"""What hangs over a piece keeps at least so much off its top [m]."""
_AXES = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


@dataclass(frozen=True)
class Pose:
    """A place for a piece: centre of its underside, direction of its x axis."""

    xy: tuple[float, float]
    """[m]"""
    along: tuple[float, float]
    """Unit vector along x or y."""
    z: float = 0.0
    """Above the storey's floor [m]."""
    run: int | None = None
    """The wall at its back, an index into `RoomPlan.runs`."""

    @property
    def inward(self) -> tuple[float, float]:
        """Where the front faces."""
        return -self.along[1], self.along[0]

    def moved(self, x: float, y: float) -> tuple[float, float]:
        """The plan coordinates of (x, y) in the piece's frame [m]."""
        (tx, ty), (nx, ny) = self.along, self.inward
        return self.xy[0] + x * tx + y * nx, self.xy[1] + x * ty + y * ny


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece that has found its place."""

    kind: Kind
    size: Size
    pose: Pose


def candidates(
    plan: RoomPlan, kind: Kind, size: Size, host: Piece | None, placed: Sequence[Piece], rng: Generator
) -> list[Pose]:
    """Poses for a piece of `kind` and `size`, best first; `host` is the piece that it stands at, on or under."""
    return _BY_PLACE[type(kind.place)](plan, kind.place, size, host, placed, rng)


def _against_wall(
    plan: RoomPlan, place: AgainstWall, size: Size, host: Piece | None, placed: Sequence[Piece], rng: Generator
) -> list[Pose]:
    scored: list[tuple[float, Pose]] = []
    half = size.width / 2
    for index, run in enumerate(plan.runs):
        neighbours = [p for p in placed if p.pose.run == index and p.pose.z == 0.0]
        for low, high in run.free:
            low, high = low + HALF_WALL_M + WALL_GAP_M + half, high - HALF_WALL_M - WALL_GAP_M - half
            if high < low:
                continue
            bonus = 1.0 if place.corner else 0.35
            options = [(low, bonus), (high, bonus), *((float(t), 0.0) for t in rng.uniform(low, high, 3))]
            for piece in neighbours:
                centre, reach = _distance_along(plan, piece), piece.size.width / 2 + half + _ABUT_M
                bonus = 2.0 if piece.kind.name in place.beside else 0.2
                options += [(t, bonus) for t in (centre - reach, centre + reach) if low <= t <= high]
            scored += [(bonus + rng.random(), Pose(run.at(t, size.depth), run.along, run=index)) for t, bonus in options]
    return _best_first(scored)


def _on_floor(
    plan: RoomPlan, place: OnFloor, size: Size, host: Piece | None, placed: Sequence[Piece], rng: Generator
) -> list[Pose]:
    low, high = plan.corners.min(axis=0), plan.corners.max(axis=0)
    middle, spread = (low + high) / 2, high - low
    # A long piece in the middle of a room lies along the room.
    lengthwise = int(spread[0] < spread[1]) if size.width >= size.depth else int(spread[0] >= spread[1])
    points = low + rng.random((14, 2)) * spread
    if place.spot == "centre":
        points = np.vstack([middle, middle + (points - low - spread / 2) * np.linspace(0.15, 0.8, 14)[:, None]])
        turns = (lengthwise + 2 * rng.integers(0, 2, len(points))) % 4
        turns[8:] += 1
    else:
        turns = rng.integers(0, 4, len(points))
    return [Pose((float(x), float(y)), _AXES[int(turn) % 4]) for (x, y), turn in zip(points, turns, strict=True)]


def _around(
    plan: RoomPlan, place: Around, size: Size, host: Piece | None, placed: Sequence[Piece], rng: Generator
) -> list[Pose]:
    if host is None:
        return []
    (tx, ty), (nx, ny) = host.pose.along, host.pose.inward
    front, side = host.size.depth / 2 + place.gap_m + size.depth / 2, host.size.width / 2 + place.gap_m + size.depth / 2
    spots: list[tuple[float, float, tuple[float, float]]] = []
    if place.side == "front":
        return [Pose(host.pose.moved(x, front), (-tx, -ty)) for x in (0.0, *rng.uniform(-0.25, 0.25, 3) * host.size.width)]
    for x in _evenly(host.size.width, size.width):
        spots += [(x, front, (-tx, -ty)), (x, -front, (tx, ty))]
    for y in _evenly(host.size.depth, size.width):
        spots += [(side, y, (nx, ny)), (-side, y, (-nx, -ny))]
    return [Pose(host.pose.moved(x, y), along) for x, y, along in spots]


def _on_top(
    plan: RoomPlan, place: OnTop, size: Size, host: Piece | None, placed: Sequence[Piece], rng: Generator
) -> list[Pose]:
    if host is None:
        return []
    room_x, room_y = (host.size.width - size.width) / 2 - 0.01, (host.size.depth - size.depth) / 2 - 0.01
    if min(room_x, room_y) < 0.0:
        return []
    xs = rng.uniform(-room_x, room_x, 8)
    ys = {
        "back": np.full(8, -room_y),
        "middle": np.zeros(8),
        "front": np.full(8, room_y),
        "anywhere": rng.uniform(-room_y, room_y, 8),
    }[place.at]
    top = host.pose.z + host.size.height
    return [Pose(host.pose.moved(float(x), float(y)), host.pose.along, top) for x, y in zip(xs, ys, strict=True)]


def _on_wall(
    plan: RoomPlan, place: OnWall, size: Size, host: Piece | None, placed: Sequence[Piece], rng: Generator
) -> list[Pose]:
    z = min(float(rng.uniform(*place.height_m)), plan.height_m - size.height - 0.05)
    if place.above:
        if host is None or host.pose.run is None:
            return []
        return [_hung(plan, host.pose.run, _distance_along(plan, host), size.depth, max(z, host.size.height + _UNDER_M))]
    margin = size.width / 2 + 0.12
    stretches = [
        (index, low + margin, high - margin)
        for index, run in enumerate(plan.runs)
        for low, high in (run.exterior if place.exterior else run.free)
        if high - low > 2 * margin
    ]
    if not stretches:
        return []
    chosen = [stretches[i] for i in rng.integers(len(stretches), size=_WALL_TRIES)]
    spots = zip(chosen, rng.random(_WALL_TRIES).tolist(), strict=True)
    return [_hung(plan, index, low + t * (high - low), size.depth, z) for (index, low, high), t in spots]


def _hung(plan: RoomPlan, index: int, t: float, depth: float, z: float) -> Pose:
    run = plan.runs[index]
    return Pose(run.at(t, depth), run.along, z, index)


def _on_ceiling(
    plan: RoomPlan, place: OnCeiling, size: Size, host: Piece | None, placed: Sequence[Piece], rng: Generator
) -> list[Pose]:
    middle = _on_floor(plan, OnFloor("centre"), size, None, placed, rng)
    return [Pose(pose.xy, pose.along, plan.height_m - size.height) for pose in middle]


def _distance_along(plan: RoomPlan, piece: Piece) -> float:
    """How far along its wall the centre of a piece is [m]."""
    run = plan.runs[piece.pose.run or 0]
    return (piece.pose.xy[0] - run.start[0]) * run.along[0] + (piece.pose.xy[1] - run.start[1]) * run.along[1]


def _evenly(length: float, each: float) -> list[float]:
    count = max(1, int(length / (each + 0.1)))
    return [(i + 0.5) * length / count - length / 2 for i in range(count)]


def _best_first(scored: list[tuple[float, Pose]]) -> list[Pose]:
    return [pose for _, pose in sorted(scored, key=lambda pair: -pair[0])]


_Finder = Callable[..., list[Pose]]
_BY_PLACE: dict[type[Place], _Finder] = {
    AgainstWall: _against_wall,
    OnFloor: _on_floor,
    Around: _around,
    OnTop: _on_top,
    OnWall: _on_wall,
    OnCeiling: _on_ceiling,
}


def rectangles(poses: Sequence[Pose], size: Size) -> Float64[np.ndarray, "n 4"]:
    """The foot prints of a piece of `size` at each pose [m]."""
    return _rectangles(poses, size.width, size.depth, 0.0)


def zones(poses: Sequence[Pose], size: Size, clearance: float) -> Float64[np.ndarray, "n 4"]:
    """The floor `clearance` [m] deep in front of each of those."""
    return _rectangles(poses, size.width, clearance, (size.depth + clearance) / 2)


def _rectangles(poses: Sequence[Pose], width: float, depth: float, ahead: float) -> Float64[np.ndarray, "n 4"]:
    xy, along, inward = np.array([(pose.xy, pose.along, pose.inward) for pose in poses]).transpose(1, 0, 2)
    centre = xy + ahead * inward
    half = 0.5 * (width * np.abs(along) + depth * np.abs(inward))
    return np.concatenate([centre - half, centre + half], axis=1)
