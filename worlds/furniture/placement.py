"""`furnish`: fill the rooms of a storey with what the catalogue says belongs there, keeping every room walkable."""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
from jaxtyping import Float64
from numpy.random import Generator

from worlds.furniture.candidates import Piece, candidates, rectangles, zones
from worlds.furniture.catalogue import CATALOGUE, kind_of
from worlds.furniture.kinds import Around, Count, Kind, OnCeiling, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.room_plan import Rectangle, RoomPlan
from worlds.labels import STAIRS
from worlds.spec import FurnitureSpec, RoomSpec, StoreySpec

_TRIES = 5
_HEAD_ROOM_M = 0.05


def furnish(storey: StoreySpec, rng: Generator, clutter: float = 1.0, prefix: str = "0") -> tuple[FurnitureSpec, ...]:
    """Furniture for all rooms of a storey; none for `clutter` 0, the usual for 1, more things lying about above.

    Ids start with `prefix` and are unique in the storey. Stairs stay bare.
    """
    pieces: list[FurnitureSpec] = []
    for room, room_rng in zip(storey.rooms, rng.spawn(len(storey.rooms)), strict=True):
        if room.label == STAIRS or clutter <= 0.0:
            continue
        plan = RoomPlan(room, storey)
        for piece in _furnish_room(plan, room_rng, clutter):
            pieces.append(_spec(piece, room, f"{prefix}.{len(pieces)} {piece.kind.name}", room_rng))
    return tuple(pieces)


def parts_of(spec: FurnitureSpec) -> Parts:
    """The parts of a piece in its own frame. Raises `WorldsError` for an unknown kind."""
    return kind_of(spec.kind).build(Size(*spec.size_m), np.random.default_rng(spec.seed))


def is_solid(kind: str) -> bool:
    """Whether pieces of `kind` block the way. Raises `WorldsError` for an unknown kind."""
    return kind_of(kind).solid


def _furnish_room(plan: RoomPlan, rng: Generator, clutter: float) -> list[Piece]:
    pieces: list[Piece] = []
    standing, seats, details = _kinds_for(plan.room.label)
    for kind in standing:
        first = len(pieces)
        _place_some(plan, kind, None, pieces, rng, clutter)
        new = pieces[first:]
        for seat in seats if new else ():
            for host in _hosts(seat, new):
                _place_some(plan, seat, host, pieces, rng, clutter)
    for kind in details:
        for host in _hosts(kind, pieces):
            _place_some(plan, kind, host, pieces, rng, clutter)
    return pieces


@cache
def _kinds_for(label: str) -> tuple[tuple[Kind, ...], tuple[Kind, ...], tuple[Kind, ...]]:
    """What stands in a room by itself, what goes with that at once, and what comes last; each in the order of placing."""
    here = sorted((kind for kind in CATALOGUE.values() if label in kind.rooms), key=lambda kind: _rank(kind, label))
    seats = tuple(kind for kind in here if isinstance(kind.place, Around) and _is_required(kind, label))
    standing = tuple(kind for kind in here if _stage(kind) <= 1)
    return standing, seats, tuple(kind for kind in here if _stage(kind) > 1 and kind not in seats)


def _rank(kind: Kind, label: str) -> tuple[int, bool, bool, float]:
    """What comes later has to make do: the required first, then what needs the centre of the room, then the large."""
    central = kind.solid and isinstance(kind.place, OnFloor) and kind.place.spot == "centre"
    return _stage(kind), not _is_required(kind, label), not central, -kind.width[1] * kind.depth[1]


def _is_required(kind: Kind, label: str) -> bool:
    return isinstance(kind.rooms[label], tuple)


def _stage(kind: Kind) -> int:
    match kind.place:
        case OnWall(exterior=True):
            return 0
        case Around():
            return 2
        case OnTop():
            return 3
        case OnWall():
            return 4
        case OnCeiling():
            return 5
    return 1


def _hosts(kind: Kind, pieces: Sequence[Piece]) -> list[Piece | None]:
    match kind.place:
        case OnTop(hosts=names) | Around(hosts=names):
            return [piece for piece in pieces if piece.kind.name in names]
        case OnWall(above=names) if names:
            return [piece for piece in pieces if piece.kind.name in names]
    return [None]


def _place_some(plan: RoomPlan, kind: Kind, host: Piece | None, pieces: list[Piece], rng: Generator, clutter: float) -> None:
    for _ in range(_draw_count(kind.rooms[plan.room.label], rng, clutter)):
        piece = _place(plan, kind, host, pieces, rng)
        if piece is None:
            return
        pieces.append(piece)


def _draw_count(count: Count, rng: Generator, clutter: float) -> int:
    expected = min(clutter, 1.0) * int(rng.integers(count[0], count[1] + 1)) if isinstance(count, tuple) else clutter * count
    return math.floor(expected + rng.random())


def _place(plan: RoomPlan, kind: Kind, host: Piece | None, pieces: Sequence[Piece], rng: Generator) -> Piece | None:
    """Try a random size, then the smallest; None if neither finds a place."""
    for shares in (rng.random(3).tolist(), (0.0, 0.0, 0.0)):
        size = _size(plan, kind, shares)
        poses = candidates(plan, kind, size, host, pieces, rng)
        if not poses:
            continue
        places, z = rectangles(poses, size), (poses[0].z, poses[0].z + size.height)
        ahead = zones(poses, size, kind.clearance) if kind.clearance else None
        guest_of = host if isinstance(kind.place, Around) else None
        free = np.flatnonzero(plan.fits(places, z, kind.solid, ahead, guest_of))
        for i in free[:_TRIES].tolist():
            place = _rectangle(places[i])
            if not kind.solid or plan.stays_walkable(place):
                piece = Piece(kind, size, poses[i])
                plan.add(place, z, kind.solid, None if ahead is None else _rectangle(ahead[i]), piece)
                return piece
    return None


def _rectangle(row: Float64[np.ndarray, "4"]) -> Rectangle:
    x0, y0, x1, y1 = row.tolist()
    return x0, y0, x1, y1


def _size(plan: RoomPlan, kind: Kind, shares: Sequence[float]) -> Size:
    """The kind's size at `shares` of its ranges, no higher than the room."""
    ranges = zip((kind.width, kind.depth, kind.height), shares, strict=True)
    width, depth, height = (round(low + share * (high - low), 3) for (low, high), share in ranges)
    return Size(width, depth, min(height, round(plan.height_m - _HEAD_ROOM_M, 3)))


def _spec(piece: Piece, room: RoomSpec, name: str, rng: Generator) -> FurnitureSpec:
    (x, y), (ax, ay) = piece.pose.xy, piece.pose.along
    return FurnitureSpec(
        id=name,
        kind=piece.kind.name,
        room=room.id,
        position_m=(round(x, 5), round(y, 5), round(piece.pose.z, 5)),
        yaw_rad=math.atan2(ay, ax),
        size_m=(piece.size.width, piece.size.depth, piece.size.height),
        seed=int(rng.integers(2**32)),
    )
