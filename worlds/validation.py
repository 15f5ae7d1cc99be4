"""Validation of houses: every rule that a house must keep is checked, and each message names the place that breaks it."""

from collections.abc import Iterator

from worlds.checks.barriers import reachability_problems
from worlds.checks.furniture_checks import furniture_problems
from worlds.checks.opening_checks import opening_problems
from worlds.checks.plan_checks import overlap_problems, plan_problems
from worlds.checks.plan_grid import PlanGrid
from worlds.errors import HouseError
from worlds.house import House, build_house
from worlds.spec import HouseSpec

BODY_RADIUS_M = 0.25


def built_and_checked(spec: HouseSpec) -> House:
    """Build the house of a spec and check it.

    Raises `HouseError` if the house cannot be built, or if it breaks a rule of `problems`.
    """
    try:
        house = build_house(spec)
    except HouseError as error:
        raise HouseError(next(_why_not_built(spec, error))) from None
    validate(house)
    return house


def validate(house: House) -> None:
    """Raise `HouseError` with the first of the `problems` of a house, if there is one."""
    for problem in problems(house):
        raise HouseError(problem)


def problems(house: House) -> Iterator[str]:
    """Yield a message for every rule that a house breaks; the message names the rooms or objects.

    The next rule is checked only when the caller asks for the next message. The rules:

    - Rooms of a storey do not overlap or nearly touch, and indoor rooms of upper storeys stand on indoor rooms.
    - Stairs join storeys. (`worlds.stairs.build` has further rules for stairs: a house that breaks them cannot be built.)
    - Openings and windows lie in the walls of their rooms and do not overlap. Doors and other passages let a body through.
    - Furniture stays in its room, collides with nothing, and does not stand in the swing area of a door leaf.
    - Every room can be reached on foot from every other room, with all doors opened.
    """
    grid = PlanGrid.of(house.spec)
    yield from plan_problems(house, grid)
    yield from opening_problems(house)
    yield from furniture_problems(house, grid)
    yield from reachability_problems(house, grid, BODY_RADIUS_M)


def spec_problems(spec: HouseSpec) -> Iterator[str]:
    """Yield a message for every rule that the house of a spec breaks.

    For a house that cannot be built, the messages name all pairs of rooms that overlap. If no rooms overlap, the message
    gives the reason why the house cannot be built.
    """
    try:
        house = build_house(spec)
    except HouseError as error:
        yield from _why_not_built(spec, error)
    else:
        yield from problems(house)


def _why_not_built(spec: HouseSpec, error: HouseError) -> Iterator[str]:
    """Yield why a house cannot be built: the overlaps of rooms, which often cause other errors, or else `error`."""
    overlaps = list(overlap_problems(PlanGrid.of(spec)))
    yield from overlaps or [str(error)]
