"""`variant`: the same house with chosen properties changed, so that runs in both houses can be compared."""

from typing import Literal, get_args

from worlds.errors import WorldsError, check_number, check_whole
from worlds.floor_plans.symmetry import in_place
from worlds.floor_plans.upper_storey import with_storey_on_top
from worlds.house import House, build_house
from worlds.labels import STAIRS
from worlds.openings.openness import with_openness
from worlds.spec import CLUTTER_SCALE, FurnitureSpec, HouseSpec, LightName, StoreySpec, TextureName, WindowSpec
from worlds.stairs.cells import openings_of

_DIGITS = 6
Replacement = Literal["lift", "spiral"]
"""What may take the place of all stairs."""


def variant(
    spec: HouseSpec,
    *,
    openness: float | None = None,
    clutter: float | None = None,
    mirror: bool = False,
    rotate: int = 0,
    repaint: int | None = None,
    add_storey: bool = False,
    climb: Replacement | None = None,
) -> HouseSpec:
    """Return a house that differs from `spec` in the properties given as arguments, and in nothing else.

    Args:
        spec: the house to start from.
        openness: new openness in [0, 1]; inner walls are opened or closed (see `with_openness`), while room polygons,
            windows and seeds stay.
        clutter: how much furniture is filled in, in [0, 4]; furniture that the spec lists stays as it is.
        mirror: whether the house is mirrored, so that x changes its sign. Pieces of furniture change places, but their
            shapes are not mirrored.
        rotate: number of quarter turns, counter-clockwise.
        repaint: new `appearance.seed`. Rooms, walls and furniture keep their shapes; windows keep their place and size, but
            their panes and curtains are drawn anew.
        add_storey: whether the plan of the top storey is repeated on top, with new room ids and therefore new furniture.
        climb: what takes the place of all stairs: "lift" or "spiral". Each keeps its first opening on every storey.
            For a spiral, these openings have to be in one side, as those of U-shaped stairs are.

    Room ids stay, because the random numbers of a room depend on its id. Before a house is mirrored or rotated, its windows
    and furniture are written into the spec, so that they stay at their walls. The textures of rooms are painted anew; they
    are neither mirrored nor rotated.

    Raises:
        WorldsError: a value is of the wrong type or out of its range, or no storey can be added.
    """
    check_whole(rotate=rotate, repaint=repaint)
    if clutter is not None:
        check_number("clutter", clutter, 0.0, 4.0, CLUTTER_SCALE)
        spec = spec.model_copy(update={"clutter": float(clutter)})
    if add_storey:
        spec = with_storey_on_top(spec)
    if climb is not None:
        if climb not in get_args(Replacement):
            raise WorldsError(f"climb is {climb!r}; valid: {', '.join(get_args(Replacement))}")
        spec = spec.model_copy(update={"storeys": tuple(_with_climb(storey, climb) for storey in spec.storeys)})
    if openness is not None:
        spec = with_openness(spec, openness)
    if mirror or rotate % 4:
        frozen = explicit(spec)
        spec = in_place(frozen, mirror, rotate % 4).house(frozen)
    if repaint is not None:
        if not 0 <= repaint < 2**63:
            raise WorldsError(f"repaint is {repaint}; valid: 0 ... 2**63 - 1")
        spec = _looking(spec, seed=int(repaint))
    return spec


def in_light(spec: HouseSpec, light: LightName) -> HouseSpec:
    """Return the house in another light; nothing else changes."""
    return _looking(spec, light=light)


def in_texture(spec: HouseSpec, texture: TextureName) -> HouseSpec:
    """Return the house with other textures; nothing else changes."""
    return _looking(spec, texture=texture)


def _looking(spec: HouseSpec, **appearance: str | int) -> HouseSpec:
    """Return the house with other values of the given fields of its appearance."""
    return spec.model_copy(update={"appearance": spec.appearance.model_copy(update=appearance)})


def _with_climb(storey: StoreySpec, climb: Replacement) -> StoreySpec:
    """Return the storey with another way to climb in its rooms of stairs, of which each keeps its first opening."""
    rooms = [room.model_copy(update={"climb": climb}) if room.label == STAIRS else room for room in storey.rooms]
    surplus = {index for room in rooms if room.label == STAIRS for index, _ in list(openings_of(storey, room))[1:]}
    openings = [opening for index, opening in enumerate(storey.openings) if index not in surplus]
    return storey.model_copy(update={"rooms": tuple(rooms), "openings": tuple(openings)})


def explicit(spec: HouseSpec) -> HouseSpec:
    """Return the spec of the same house with all windows and furniture listed that `build_house` would fill in.

    Raises `HouseError` for a house that cannot be built.
    """
    house = build_house(spec)
    storeys = [
        storey.model_copy(
            update={
                "windows": _windows(house, level) if storey.windows is None else storey.windows,
                "furniture": _furniture(house, level) if storey.furniture is None else storey.furniture,
            }
        )
        for level, storey in enumerate(spec.storeys)
    ]
    return spec.model_copy(update={"storeys": tuple(storeys)})


def _windows(house: House, level: int) -> tuple[WindowSpec, ...]:
    floor = house.storeys[level].floor_m
    return tuple(
        WindowSpec(
            room=window.room,
            start_m=window.start,
            end_m=window.end,
            sill_m=round(window.position[2] - floor, _DIGITS),
            height_m=round(window.position[2] - floor + window.size[2], _DIGITS),
        )
        for window in house.windows
        if window.storey == level
    )


def _furniture(house: House, level: int) -> tuple[FurnitureSpec, ...]:
    floor = house.storeys[level].floor_m
    return tuple(
        FurnitureSpec(
            id=piece.id,
            kind=piece.kind,
            room=piece.room,
            position_m=(piece.position[0], piece.position[1], round(piece.position[2] - floor, _DIGITS)),
            yaw_rad=piece.yaw,
            size_m=piece.size,
            seed=piece.seed,
        )
        for piece in house.furniture
        if piece.storey == level
    )
