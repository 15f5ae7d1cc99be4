"""`missing_essentials`: rooms that lack a piece without which they are of no use, such as a kitchen's sink."""

from collections.abc import Iterator

from worlds.furniture.catalogue import CATALOGUE
from worlds.house import House


def missing_essentials(house: House) -> Iterator[tuple[str, str]]:
    """Yield (id of a room, name of a kind) for each essential kind of which the room requires a piece and has none.

    Such a house is valid: small rooms with many doors and windows may have no space for all of their essential pieces.
    """
    present = {(piece.room, piece.kind) for piece in house.furniture}
    essentials = [kind for kind in CATALOGUE.values() if kind.essential]
    for room in house.rooms:
        for kind in essentials:
            if kind.is_required_in(room.label) and (room.id, kind.name) not in present:
                yield room.id, kind.name
