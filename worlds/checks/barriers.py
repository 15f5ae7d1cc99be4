"""Rooms that cannot be reached on foot, and the furniture that blocks the path to them.

Each blocking piece has a message of its own. The message also names the opening beside which the piece stands, so that the
user knows what to move.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import LineString

from worlds.checks.furniture_checks import piece_name
from worlds.checks.plan_grid import PlanGrid
from worlds.checks.reachability import unreachable_rooms
from worlds.house import Furniture, House
from worlds.spec import PASSABLE

_BESIDE_M = 0.6
"""Largest distance from an opening at which a piece may block it [m]; a little more than the width of the body."""


def reachability_problems(house: House, grid: PlanGrid, radius_m: float) -> Iterator[str]:
    """Yield a message for each piece of furniture that blocks the path to rooms, with the names of these rooms.

    Rooms that cannot be reached even without furniture are listed in one last message. `grid` is the plan of the house, and
    `radius_m` is the radius of the body that walks [m].
    """

    def cut_off(pieces: Sequence[Furniture]) -> set[str]:
        return set(unreachable_rooms(replace(house, furniture=tuple(pieces)), grid, radius_m))

    if not (missing := cut_off(house.furniture)):
        return
    unfurnished = cut_off(())
    if unfurnished - missing:  # without furniture, another part of the house is the largest: furniture is not to blame
        missing = unfurnished
    solid = [piece for piece in house.furniture if piece.solid]
    if freed := missing - unfurnished:
        barriers = _barriers(house, solid, lambda pieces: cut_off(pieces) <= unfurnished)
        for piece in barriers:
            others = [other for other in solid if other is piece or other not in barriers]
            behind = cut_off(others) - unfurnished
            rooms = [room.id for room in house.rooms if room.id in behind]
            yield (
                f"{piece_name(piece)} in {piece.room!r} {_blocked(house, piece)}; not reachable on foot "
                f"(body radius {radius_m} m): {', '.join(rooms)}; move it away"
            )
    if rooms := [room.id for room in house.rooms if room.id in missing - freed]:
        yield f"not reachable on foot (body radius {radius_m} m): {', '.join(rooms)}; add an opening, stairs or free space"


def _barriers(house: House, solid: Sequence[Furniture], frees: Callable[[Sequence[Furniture]], bool]) -> list[Furniture]:
    """Return a minimal set of pieces whose removal makes rooms reachable: no piece of this set can be left in place.

    `frees` tells whether, with only the given pieces in the house, all rooms are reachable that are reachable in the empty
    house. This test is expensive, so the search begins with the pieces beside openings, if their removal is enough, and else
    with all pieces. The search then puts pieces back: first all at once, then half of the pieces at a time, then a quarter,
    and so on. This needs few tests, because most pieces are no barriers.
    """
    openings = shapely.union_all([line for _, _, line in _openings(house)])
    suspects = [piece for piece in solid if shapely.distance(piece.footprint, openings) <= _BESIDE_M]
    if not frees([piece for piece in solid if piece not in suspects]):
        suspects = list(solid)
    barriers, some = suspects, len(suspects)
    while some > 0:
        # Put back `some` neighbouring pieces of the list, wherever all rooms stay reachable.
        for first in range(len(barriers) - some, -some, -some):
            fewer = barriers[: max(first, 0)] + barriers[first + some :]
            if frees([piece for piece in solid if piece not in fewer]):
                barriers = fewer
        some //= 2
    return barriers


def _blocked(house: House, piece: Furniture) -> str:
    """Return the part of a message that says what a piece blocks: the opening beside the piece, or else "the path"."""
    beside = [
        (shapely.distance(piece.footprint, line), name) for storey, name, line in _openings(house) if storey == piece.storey
    ]
    distance, name = min(beside, default=(np.inf, ""))
    return f"blocks {name}" if distance <= _BESIDE_M else "blocks the path"


def _openings(house: House) -> Iterator[tuple[int, str, LineString]]:
    """Yield the storey, the name and the line in the plan of every opening that one can walk through."""
    for level, storey in enumerate(house.spec.storeys):
        for i, opening in enumerate(storey.openings):
            if opening.kind in PASSABLE:
                name = f"the {_KINDS.get(opening.kind, opening.kind)} between {opening.rooms[0]!r} and {opening.rooms[1]!r}"
                yield level, f"{name} (storeys[{level}].openings[{i}])", LineString([opening.start_m, opening.end_m])


_KINDS = {"cased": "passage", "open": "open boundary"}
