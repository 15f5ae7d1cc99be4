"""Helpers that the commands of `lexis-sim house` share: the file argument, writing a checked house, describing a house."""

from pathlib import Path

from lexis.files.replace import replaced_file
from sim.commands.arguments import argument
from sim.wording import counted
from worlds.house import House
from worlds.spec import HouseSpec
from worlds.truth import floor_area, openness
from worlds.validation import built_and_checked

FILE = argument("file", type=Path, metavar="FILE.json")


def write_checked(spec: HouseSpec, path: Path) -> None:
    """Check a house, write it and print its description. An invalid house raises `HouseError`, and nothing is written."""
    house = built_and_checked(spec)
    with replaced_file(path) as file:
        file.write_text(spec.to_json(), encoding="utf-8")
    print(f"{path}: {describe(house)}")


def describe(house: House) -> str:
    """Describe a house in one line: rooms, floors, area, openness, furniture."""
    return (
        f"{counted(len(house.rooms), 'room')} on {counted(len(house.storeys), 'floor')}, {floor_area(house):.0f} m², "
        f"openness {openness(house):.2f}, {counted(len(house.furniture), 'piece')} of furniture"
    )
