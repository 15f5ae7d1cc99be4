"""Shared steps of the commands of `lexis-sim house`: a house is read, checked, written and described."""

from pathlib import Path

from lexis.files.replace import replaced_file
from sim.commands.arguments import argument
from worlds.house import House
from worlds.spec import HouseSpec
from worlds.truth import floor_area, openness
from worlds.validation import built_and_checked

FILE = argument("file", type=Path, metavar="FILE.json")


def write_checked(spec: HouseSpec, path: Path) -> None:
    """Write a house that stands, and say what it is. Raises `HouseError` for one that does not, and writes nothing."""
    house = built_and_checked(spec)
    with replaced_file(path) as file:
        file.write_text(spec.to_json())
    print(f"{path}: {describe(house)}")


def describe(house: House) -> str:
    """A house in a line."""
    floors = len(house.storeys)
    return (
        f"{len(house.rooms)} rooms on {floors} floor{'s' * (floors > 1)}, {floor_area(house):.0f} m², "
        f"openness {openness(house):.2f}, {len(house.furniture)} pieces of furniture"
    )
