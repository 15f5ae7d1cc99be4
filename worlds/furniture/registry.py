"""The `@furniture` decorator, which registers a kind of furniture, and the table of registered kinds."""

from collections.abc import Callable, Mapping

from worlds.errors import WorldsError
from worlds.furniture.kinds import AgainstWall, Around, Build, Count, Kind, OnFloor, Place, Range

KINDS: dict[str, Kind] = {}


def furniture(
    name: str,
    *,
    width: Range,
    depth: Range,
    height: Range,
    rooms: Mapping[str, Count],
    place: Place = AgainstWall(),  # noqa: B008 - frozen
    solid: bool | None = None,
    clearance: float = 0.0,
    essential: bool = False,
) -> Callable[[Build], Build]:
    """Register the decorated build function as a kind of furniture; see `Kind` for the arguments.

    Houses that are built after the declaration have pieces of the kind; houses that were built before have none. By default
    (`solid=None`) a piece is solid if it stands on the floor.

    If a function is declared again, as in a cell of a notebook that is run again, the new kind replaces the old one. The
    decorator raises `WorldsError` if another function has declared the name, or if `Kind` refuses an argument.
    """

    def declare(build: Build) -> Build:
        if name in KINDS and _origin(build) != _origin(KINDS[name].build):
            modules = dict.fromkeys((KINDS[name].build.__module__, build.__module__))
            where = (
                f"declared in {' and again in '.join(modules)}"
                if len(modules) > 1
                else f"declared twice in {next(iter(modules))}"
            )
            raise WorldsError(f"furniture kind {name!r} is {where}; valid: a name that is not in worlds.furniture.CATALOGUE")
        on_floor = isinstance(place, AgainstWall | OnFloor | Around)
        blocks = on_floor if solid is None else solid
        KINDS[name] = Kind(name, width, depth, height, rooms, build, place, blocks, clearance, essential)
        return build

    return declare


def own_kinds() -> tuple[Kind, ...]:
    """Return the kinds that users have declared, in the order of their names. Houses that are built now may have them."""
    own = (kind for kind in KINDS.values() if not kind.build.__module__.startswith("worlds."))
    return tuple(sorted(own, key=lambda kind: kind.name))


def _origin(build: Build) -> tuple[str, object]:
    """Return the module and the name of a build function."""
    return build.__module__, getattr(build, "__qualname__", build)
