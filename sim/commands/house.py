"""`lexis-sim house`: houses as files. A new action is a function and a row of `_ACTIONS`."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from lexis.command_line import Command, Commands, add_command, positive
from lexis.files import replaced_file
from sim.commands.arguments import PRESET_HELP, SEED, Argument, argument, out_file
from sim.house_files import MODELS, PLANS, Writer, writer_for
from worlds.errors import HouseError
from worlds.house import House, build_house
from worlds.presets import PRESETS, sample_from_rooms, sample_house
from worlds.spec import HouseSpec
from worlds.truth import floor_area, openness


class Action(NamedTuple):
    """A command below `lexis-sim house`."""

    name: str
    command: Command
    help: str
    example: str
    arguments: tuple[Argument, ...]


def add_to(commands: Commands) -> None:
    """Add the actions."""
    examples = "\n".join(f"  {action.example}" for action in _ACTIONS)
    house = commands.add_parser(
        "house",
        help="generate, check and show houses",
        description="Houses as files.",
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = house.add_subparsers(required=True, metavar="ACTION")
    for action in _ACTIONS:
        parser = add_command(actions, action.name, action.command, action.help, action.example)
        for add_argument in action.arguments:
            add_argument(parser)


def _generate(arguments: argparse.Namespace) -> int:
    if arguments.rooms is None:
        spec = sample_house(arguments.preset, arguments.seed)
    else:
        spec = sample_from_rooms([label.strip() for label in arguments.rooms.split(",")], arguments.seed)
    house = _checked(spec)
    with replaced_file(arguments.out) as file:
        file.write_text(spec.to_json())
    print(f"{arguments.out}: {_describe(house)}")
    return 0


def _check(arguments: argparse.Namespace) -> int:
    spec = HouseSpec.load(arguments.file)
    try:
        house = _checked(spec)
    except HouseError as error:
        print(f"{arguments.file}: {error}")
        return 1
    print(f"{arguments.file}: {_describe(house)}; all checks passed")
    return 0


def _show(arguments: argparse.Namespace) -> int:
    return _write(arguments, PLANS)


def _export(arguments: argparse.Namespace) -> int:
    return _write(arguments, MODELS)


def _write(arguments: argparse.Namespace, writers: Mapping[str, Writer]) -> int:
    write = writer_for(arguments.out, writers)
    house = build_house(HouseSpec.load(arguments.file))
    write(house, arguments.out)
    print(f"{arguments.out}: {_describe(house)}")
    return 0


def _gallery(arguments: argparse.Namespace) -> int:
    from sim.gallery import plans_page, png, room_views, rooms_page, sample_page

    presets = [name.strip() for name in arguments.preset.split(",")]
    houses = sample_page(presets, arguments.seed, arguments.houses)
    page = plans_page(houses) if arguments.view == "plans" else rooms_page(list(room_views(houses)))
    with replaced_file(arguments.out) as file:
        file.write_bytes(png(page))
    print(f"{arguments.out}: {arguments.view} of {len(houses)} houses")
    return 0


def _preset_or_rooms(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--preset", default="home", help=PRESET_HELP)
    source.add_argument("--rooms", metavar="A,B,...", help="one storey with these rooms around a corridor")


def _checked(spec: HouseSpec) -> House:
    from worlds.validation import validate

    house = build_house(spec)
    validate(house)
    return house


def _describe(house: House) -> str:
    floors = len(house.storeys)
    return (
        f"{len(house.rooms)} rooms on {floors} floor{'s' * (floors > 1)}, {floor_area(house):.0f} m², "
        f"openness {openness(house):.2f}, {len(house.furniture)} pieces of furniture"
    )


_FILE = argument("file", type=Path, metavar="FILE.json")

_ACTIONS = (
    Action(
        "generate",
        _generate,
        "write a house as JSON",
        "lexis-sim house generate --preset home --seed 3 -o home.json",
        (_preset_or_rooms, SEED, out_file("FILE.json")),
    ),
    Action(
        "check",
        _check,
        "prove that a house can stand and be walked",
        "lexis-sim house check home.json",
        (_FILE,),
    ),
    Action(
        "show",
        _show,
        "draw the plan of every storey",
        "lexis-sim house show home.json -o home.png",
        (_FILE, out_file("FILE.png|.svg")),
    ),
    Action(
        "export",
        _export,
        "a model for other tools: glTF, MJCF with its textures beside it, or the truth as JSON",
        "lexis-sim house export home.json -o home.glb",
        (_FILE, out_file("FILE.glb|.xml|.json")),
    ),
    Action(
        "gallery",
        _gallery,
        "many houses on one page: their plans, or a look into a room of each label",
        "lexis-sim house gallery --view rooms --seed 3 -o rooms.png",
        (
            argument("--preset", default=",".join(PRESETS), metavar="A,B,...", help="families, in turn (default: all)"),
            argument("--view", choices=("plans", "rooms"), default="plans", help="default: %(default)s"),
            argument("--houses", type=positive, default=25, help="how many (default: %(default)s)"),
            SEED,
            out_file("FILE.png"),
        ),
    ),
)
