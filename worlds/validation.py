"""Proofs that a house can stand and be walked; each failure names the place."""

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
    """The house of a spec, which stands and can be walked. Raises `HouseError` for another."""
    try:
        house = build_house(spec)
    except HouseError as error:
        raise HouseError(next(_obstacles(spec, error))) from None
    validate(house)
    return house


def validate(house: House) -> None:
    """Raise `HouseError` at the first of the `problems` of a house."""
    for problem in problems(house):
        raise HouseError(problem)


def problems(house: House) -> Iterator[str]:
    """Every rule that a house breaks, found as asked for, with the rooms or objects that break it.

    Rooms of a storey do not overlap or nearly touch, and stand on rooms; openings and windows lie in the right walls, clear
    of each other, and let the body through; stairs join storeys; furniture stays in its room and runs into nothing, nor into
    where doors swing; every room can be reached on foot from every other, doors being opened. (`worlds.stairs.build` holds
    the rules of stairs: a house that breaks them cannot be built.)
    """
    grid = PlanGrid.of(house.spec)
    yield from plan_problems(house, grid)
    yield from opening_problems(house)
    yield from furniture_problems(house, grid)
    yield from reachability_problems(house, grid, BODY_RADIUS_M)


def spec_problems(spec: HouseSpec) -> Iterator[str]:
    """Every rule that the house of a spec breaks; of one that cannot be built, the rooms that overlap, or else the first."""
    try:
        house = build_house(spec)
    except HouseError as error:
        yield from _obstacles(spec, error)
    else:
        yield from problems(house)


def _obstacles(spec: HouseSpec, error: HouseError) -> Iterator[str]:
    overlaps = list(overlap_problems(PlanGrid.of(spec)))
    yield from overlaps or [str(error)]
