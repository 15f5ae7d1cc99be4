"""`furnish`: fills the rooms of a storey with furniture from the catalogue and keeps every room walkable.

Each room is furnished in this order. Steps 1 and 2 place everything that a usual home has. If the clutter is lower than
usual, some of these pieces are left out at the end.

1. Pieces that stand by themselves, each followed by its required seats: first one piece of each required kind, so that
   the kitchen counters leave space for a sink and a stove, and then the others, the large ones first.
2. Details: other seats, and things on top of pieces, on walls and under the ceiling.
3. Pieces that need more than the usual clutter, in the order of the least clutter at which they are present.

This order makes rooms comparable: a piece that is present at some clutter is in the same place at any higher clutter.
"""

import heapq
import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import islice, product
from typing import NamedTuple

from numpy.random import Generator

from worlds.furniture.catalogue import CATALOGUE
from worlds.furniture.kind_checks import check_kinds
from worlds.furniture.kinds import AgainstWall, Around, Kind, OnCeiling, OnFloor, OnTop, OnWall, Place, Range, Size
from worlds.furniture.placing.candidates import candidates
from worlds.furniture.placing.counts import USUAL, appearances
from worlds.furniture.placing.draws import Draws, pool, stream_key
from worlds.furniture.placing.piece import Piece
from worlds.furniture.placing.room_plan import RoomPlan
from worlds.labels import STAIRS
from worlds.spec import FurnitureSpec, RoomSpec, StoreySpec, WindowSpec

WALKABLE_SHARE = 0.4
"""Least share of a room's area that a walking body can still cover in a usual home."""
_SHARE_PER_CLUTTER = 0.04
"""Decrease of `WALKABLE_SHARE` per unit of clutter above the usual."""
_HEAD_ROOM_M = 0.05
_SMALLEST = (0.0, 0.0, 0.0)
_YAWS = (0.0, math.pi / 2, math.pi, -math.pi / 2)


def furnish(
    storey: StoreySpec,
    rng_of: Callable[[RoomSpec], Generator],
    clutter: float = USUAL,
    prefix: str = "0",
    windows: Sequence[WindowSpec] = (),
) -> tuple[FurnitureSpec, ...]:
    """Return furniture for all rooms of a storey. Rooms of stairs stay empty.

    Args:
        storey: the storey to furnish.
        rng_of: returns the random generator of a room. Equal rooms with equal generators are furnished equally.
        clutter: 0 for no furniture, 1 for the furniture of a usual home, more for additional loose things. A piece that is
            present at some clutter is present at any higher clutter, under the same id.
        prefix: start of the ids of the furniture.
        windows: the windows of the storey.

    Raises `WorldsError` if a kind of the catalogue is invalid (`check_kinds`).
    """
    specs: list[FurnitureSpec] = []
    for index, room in enumerate(storey.rooms):
        if room.label == STAIRS or clutter <= 0.0:
            continue
        plan = RoomPlan(room, storey, windows)
        pieces = _Furnisher(plan, pool(rng_of(room)), clutter).furnished()
        specs += [
            _spec(piece, plan, room, f"{prefix}.{index}.{number} {piece.kind.name}")
            for number, piece in enumerate(pieces)
            if piece.since <= clutter
        ]
    return tuple(specs)


class _Furnisher:
    """Fills one room: first with everything that a usual home has, then with the additional pieces of a cluttered home."""

    def __init__(self, plan: RoomPlan, numbers: Sequence[float], clutter: float) -> None:
        self._plan, self._numbers, self._clutter = plan, numbers, clutter
        self._kinds = _room_kinds(plan.label, tuple(CATALOGUE.values()))
        self._pieces: list[Piece] = []
        self._by_kind: dict[str, list[Piece]] = defaultdict(list)
        self._more: list[_Queued] = []

    def furnished(self) -> list[Piece]:
        """Place the pieces and return them in the order of placing.

        All pieces of a usual home are included, even at a lower clutter.
        """
        numbered = {kind: self._appearances(kind, None) for kind in self._kinds.standing}
        for kind, each in numbered.items():
            if kind.is_required_in(self._plan.label):
                self._stand(kind, islice(each, 1))
        for kind, each in numbered.items():
            self._stand(kind, each)
        for kind in self._kinds.details:
            for host in self._hosts(kind):
                self._usual(kind, host, self._appearances(kind, host))
        while self._more:
            self._add_queued(heapq.heappop(self._more))
        return self._pieces

    def _hosts(self, kind: Kind) -> Sequence[Piece | None]:
        return [piece for name in kind.hosts for piece in self._by_kind[name]] if kind.hosts else (None,)

    def _appearances(self, kind: Kind, host: Piece | None) -> Iterator[tuple[float, int]]:
        return appearances(kind, self._plan.label, self._plan.shape.area_m2, self._draws(kind, 0, host))

    def _stand(self, kind: Kind, each: Iterator[tuple[float, int]]) -> None:
        """Place the usual pieces of a kind that stands by itself, each followed by its required seats."""
        for piece in self._usual(kind, None, each):
            for seat in self._kinds.seats.get(kind.name, ()):
                self._usual(seat, piece, self._appearances(seat, piece))

    def _usual(self, kind: Kind, host: Piece | None, each: Iterator[tuple[float, int]]) -> list[Piece]:
        """Place the pieces of a kind that a usual home has (per host); queue the first piece that needs more clutter."""
        placed: list[Piece] = []
        for since, number in each:
            if since > USUAL:
                self._queue(since, kind, number, host, each)
                break
            piece = self._place(kind, number, host, since)
            if piece is None:
                break
            placed.append(piece)
        return placed

    def _queue(self, since: float, kind: Kind, number: int, host: Piece | None, rest: Iterator[tuple[float, int]]) -> None:
        if since <= self._clutter:
            heapq.heappush(self._more, _Queued(since, _key(kind, number, host), kind, number, host, rest))

    def _add_queued(self, next_one: "_Queued") -> None:
        """Place a queued piece; if it fits, queue the pieces that follow it.

        These are the next piece of its kind, and the first piece of each kind that can stand at or on the placed piece, or
        hang above it.
        """
        since, _, kind, number, host, rest = next_one
        piece = self._place(kind, number, host, since)
        if piece is None:
            return
        self._queue_next(kind, host, rest, piece.since)
        for guest in self._kinds.guests.get(kind.name, ()):
            self._queue_next(guest, piece, self._appearances(guest, piece), piece.since)

    def _queue_next(self, kind: Kind, host: Piece | None, rest: Iterator[tuple[float, int]], least: float) -> None:
        """Queue the next piece of `rest`, if there is one; it needs at least the clutter `least`."""
        if (following := next(rest, None)) is not None:
            since, number = following
            self._queue(max(since, least), kind, number, host, rest)

    def _place(self, kind: Kind, number: int, host: Piece | None, since: float) -> Piece | None:
        """Place a piece with a random size, or else with the smallest size of its kind; return None if neither fits.

        The first piece that the room requires may stand free if its kind can.
        """
        draws = self._draws(kind, number, host)
        seed, shares = int(draws.random() * 2**32), (draws.random(), draws.random(), draws.random())
        since = max(since, host.since) if host else since
        walkable = WALKABLE_SHARE - _SHARE_PER_CLUTTER * max(0.0, since - USUAL)
        for place, each in product(self._places(kind), (shares, _SMALLEST)):
            size = _size(kind, each, self._plan.height_m)
            poses = candidates(self._plan, place, size, host, draws)
            pose = self._plan.claim_first_free(kind, size, poses, host, walkable)
            if pose is not None:
                piece = Piece(kind, size, pose, _key(kind, number, host), seed, since)
                self._plan.add(piece)
                self._pieces.append(piece)
                self._by_kind[kind.name].append(piece)
                return piece
        return None

    def _places(self, kind: Kind) -> tuple[Place, ...]:
        """Return where the next piece of a kind may stand, the usual place first."""
        first = kind.is_required_in(self._plan.label) and not self._by_kind[kind.name]
        free = isinstance(kind.place, AgainstWall) and kind.place.can_stand_free
        return (kind.place, OnFloor()) if first and free else (kind.place,)

    def _draws(self, kind: Kind, number: int, host: Piece | None) -> Draws:
        return Draws(self._numbers, _key(kind, number, host))


def _key(kind: Kind, number: int, host: Piece | None) -> int:
    return stream_key(kind.name, number, host.key if host else 0)


class _Queued(NamedTuple):
    """A piece that needs more than the usual clutter and is still to be placed; `rest` yields further pieces of its kind."""

    since: float
    key: int
    kind: Kind
    number: int
    host: Piece | None
    rest: Iterator[tuple[float, int]]


@dataclass(frozen=True)
class RoomKinds:
    """The kinds that belong in rooms with one label, in the order of placing."""

    standing: tuple[Kind, ...]
    """Kinds of furniture that stand on the floor, independently of other pieces."""
    seats: Mapping[str, tuple[Kind, ...]]
    """Kinds of required seats around another piece (the host), by the name of the host's kind. Seats are placed right after
    their host."""
    details: tuple[Kind, ...]
    """Kinds that are placed last: seats that are not required, and things on pieces, on walls and on the ceiling."""
    guests: Mapping[str, tuple[Kind, ...]]
    """All kinds that stand at or on another piece (the host), or hang above it, by the name of the host's kind."""


@cache
def _room_kinds(label: str, catalogue: tuple[Kind, ...]) -> RoomKinds:
    """Return the kinds of the catalogue that belong in rooms with `label`. Raises `WorldsError` for an invalid kind."""
    check_kinds(catalogue)
    here = sorted((kind for kind in catalogue if label in kind.rooms), key=lambda kind: _rank(kind, label))
    seats = [kind for kind in here if isinstance(kind.place, Around) and kind.is_required_in(label)]
    standing = tuple(kind for kind in here if _stage(kind) == 1)
    details = tuple(kind for kind in here if _stage(kind) > 1 and kind not in seats)
    return RoomKinds(standing, _by_host(seats), details, _by_host(here))


def _by_host(kinds: Sequence[Kind]) -> dict[str, tuple[Kind, ...]]:
    names = {name for kind in kinds for name in kind.hosts}
    return {name: tuple(kind for kind in kinds if name in kind.hosts) for name in names}


def _rank(kind: Kind, label: str) -> tuple[int, bool, bool, bool, float]:
    """Return the sort key for the order of placing; kinds that come later have less space to choose from.

    Kinds are sorted by their place (floor, around a piece, on top, wall, ceiling). Within a place, required kinds come
    first, and among them the essential ones, then solid kinds for the centre of the room, then kinds with a large footprint.
    """
    central = kind.solid and isinstance(kind.place, OnFloor) and kind.place.spot == "centre"
    required = kind.is_required_in(label)
    essential = required and kind.essential
    return _stage(kind), not required, not essential, not central, -kind.width[1] * kind.depth[1]


def _stage(kind: Kind) -> int:
    match kind.place:
        case Around():
            return 2
        case OnTop():
            return 3
        case OnWall():
            return 4
        case OnCeiling():
            return 5
    return 1


def _size(kind: Kind, shares: tuple[float, float, float], room_height: float) -> Size:
    """Return the size at the relative positions `shares`, in [0, 1], within the kind's ranges, but lower than the room."""
    width, depth, height = map(_at_share, (kind.width, kind.depth, kind.height), shares)
    return Size(width, depth, min(height, round(room_height - _HEAD_ROOM_M, 3)))


def _at_share(interval: Range, share: float) -> float:
    return round(interval[0] + share * (interval[1] - interval[0]), 3)


def _spec(piece: Piece, plan: RoomPlan, room: RoomSpec, name: str) -> FurnitureSpec:
    """Return the spec of a piece; it is not validated, because its values come from the placement and not from a file."""
    (x0, y0), pose, size = plan.shape.origin, piece.pose, piece.size
    return FurnitureSpec.model_construct(
        id=name,
        kind=piece.kind.name,
        room=room.id,
        position_m=(round(x0 + pose.x, 5), round(y0 + pose.y, 5), round(pose.z, 5)),
        yaw_rad=_YAWS[pose.turn],
        size_m=(size.width, size.depth, size.height),
        seed=piece.seed,
    )
