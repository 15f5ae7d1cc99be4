"""Changed copies of the spec of a house: with other storeys, or with some of its rooms or furniture alone."""

from collections.abc import Callable, Collection, Iterator, Sequence

from worlds.labels import STAIRS
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.stairs.cells import cell_on


def with_storeys(spec: HouseSpec, storeys: Sequence[StoreySpec]) -> HouseSpec:
    """Return the house with other storeys."""
    return spec.model_copy(update={"storeys": tuple(storeys)})


def with_storey(spec: HouseSpec, level: int, storey: StoreySpec) -> HouseSpec:
    """Return the house with another storey at a level, counted from 0."""
    return with_storeys(spec, (*spec.storeys[:level], storey, *spec.storeys[level + 1 :]))


def by_storey(spec: HouseSpec, update: Callable[[StoreySpec], dict[str, object]]) -> HouseSpec:
    """Return the house with the fields of every storey changed as `update` returns for the storey."""
    return with_storeys(spec, [storey.model_copy(update=update(storey)) for storey in spec.storeys])


def rooms_of(spec: HouseSpec, stairs: bool = False) -> Iterator[tuple[int, RoomSpec]]:
    """Yield the level and the room for all rooms; `stairs` says whether stairs are included."""
    for level, storey in enumerate(spec.storeys):
        yield from ((level, room) for room in storey.rooms if stairs or room.label != STAIRS)


def keep_furniture(spec: HouseSpec, ids: Collection[str]) -> HouseSpec:
    """Return the house with only the furniture of the given ids."""
    return by_storey(spec, lambda storey: {"furniture": tuple(p for p in storey.furniture or () if p.id in ids)})


def keep_rooms(spec: HouseSpec, ids: Collection[str]) -> HouseSpec | None:
    """Return the house with only the rooms of the given ids, and their openings, windows and furniture.

    Stairs that lead nowhere any more are dropped, and so are empty storeys at the top or the bottom. The result is None if
    no room is left, or if a storey between two others is empty.
    """
    spec = with_storeys(spec, [_kept(storey, ids) for storey in spec.storeys])
    levels = [level for level, storey in enumerate(spec.storeys) if storey.rooms]
    if not levels or len(levels) != levels[-1] - levels[0] + 1:
        return None
    spec = with_storeys(spec, spec.storeys[levels[0] : levels[-1] + 1])
    alone = {
        room.id
        for level, storey in enumerate(spec.storeys)
        for room in storey.rooms
        if room.label == STAIRS and not any(cell_on(spec, level + step, room) for step in (-1, 1))
    }
    if alone:
        return keep_rooms(spec, {room.id for _, room in rooms_of(spec, stairs=True)} - alone)
    return with_storeys(
        spec,
        [
            storey.model_copy(update={"openings": tuple(o for o in storey.openings if _leads_somewhere(spec, level, o))})
            for level, storey in enumerate(spec.storeys)
        ],
    )


def _kept(storey: StoreySpec, ids: Collection[str]) -> StoreySpec:
    return storey.model_copy(
        update={
            "rooms": tuple(room for room in storey.rooms if room.id in ids),
            "openings": tuple(opening for opening in storey.openings if set(opening.rooms) <= set(ids)),
            "windows": None if storey.windows is None else tuple(w for w in storey.windows if w.room in ids),
            "furniture": None if storey.furniture is None else tuple(p for p in storey.furniture if p.room in ids),
        }
    )


def _leads_somewhere(spec: HouseSpec, level: int, opening: OpeningSpec) -> bool:
    if opening.leads is None:
        return True
    step = 1 if opening.leads == "up" else -1
    cells = [room for room in spec.storeys[level].rooms if room.id in opening.rooms and room.label == STAIRS]
    return any(cell_on(spec, level + step, cell) for cell in cells)
