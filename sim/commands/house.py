"""`lexis-sim house`: commands on house files. To add one, write a function and add an entry to `_ACTIONS`."""

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path

from lexis.command_line import MAX_LINE, Commands, positive
from lexis.errors import one_line
from lexis.files.replace import replaced_file
from sim.commands.action import Action, add_actions
from sim.commands.arguments import SEED, argument, naming, out_file
from sim.commands.house_action import FILE, describe
from sim.commands.house_check import CHECK, PROVE
from sim.commands.house_make import GENERATE, IMPORT, VARIANT
from sim.errors import SimError
from sim.house_files import MODELS, PLANS, Writer, writer_for
from sim.output_files import check_ending, check_not_input
from sim.wording import counted
from worlds.house import House, build_house
from worlds.presets import PRESETS
from worlds.spec import HouseSpec, json_schema
from worlds.valid_names import did_you_mean, listed
from worlds.validation import built_and_checked, problems

_VIEW_PX = (960, 720)
"""Width and height of the picture of a room [px]."""
_MOST_TILES = 1000
"""Largest number of floor plans on one page of a gallery."""


def add_to(commands: Commands) -> None:
    """Add the command `house` with its actions."""
    add_actions(commands, "house", "generate, check and show houses", _ACTIONS)


def _show(arguments: argparse.Namespace) -> int:
    return _write(arguments, PLANS, checked=False)  # the plan of an invalid house helps to see what is wrong


def _export(arguments: argparse.Namespace) -> int:
    return _write(arguments, MODELS, checked=True)


def _write(arguments: argparse.Namespace, writers: Mapping[str, Writer], checked: bool) -> int:
    write = writer_for(arguments.out, writers)
    check_not_input(arguments.out, arguments.file)
    house = _built(arguments.file, checked)
    write(house, arguments.out)
    print(f"{arguments.out}: {describe(house)}")
    return 0


def _built(file: Path, checked: bool = False) -> House:
    """Build the house of a file. A note names the first rule that it breaks; with `checked`, `WorldsError` is raised."""
    spec = HouseSpec.load(file)
    with naming(file):
        house = built_and_checked(spec) if checked else build_house(spec)
    if not checked and (problem := next(problems(house), None)) is not None:
        print(one_line(f"note: the house is not valid: {problem}", MAX_LINE), file=sys.stderr)
    return house


def _view(arguments: argparse.Namespace) -> int:
    from sim.gallery import best_view
    from sim.render.image_files import encoded

    check_ending(arguments.out, [".png"])
    check_not_input(arguments.out, arguments.file)
    house = _built(arguments.file)  # unchecked, because a picture helps to see what is wrong
    if (room := house.room_by_id.get(arguments.room)) is None:
        guess = did_you_mean(arguments.room, house.room_by_id)
        raise SimError(
            f"{arguments.file}: has no room {arguments.room!r:.60}{guess}; valid: {listed(list(house.room_by_id))}"
        )
    view = best_view(house, room, _VIEW_PX)
    with replaced_file(arguments.out) as file:
        file.write_bytes(encoded(view, ".png"))
    print(f"{arguments.out}: {room.id} ({room.label})")
    return 0


def _gallery(arguments: argparse.Namespace) -> int:
    from sim.gallery import plans_page, room_views, rooms_page, sampled_specs
    from sim.render.image_files import encoded

    if arguments.houses > _MOST_TILES:
        raise SimError(
            f"--houses {arguments.houses} are too many for one page; valid: a whole number from 1 to {_MOST_TILES}"
        )
    check_ending(arguments.out, [".png"])
    presets = [name.strip() for name in arguments.preset.split(",")]
    houses = sampled_specs(presets, arguments.seed, arguments.houses)
    page = plans_page(houses) if arguments.view == "plans" else rooms_page(list(room_views(houses)))
    with replaced_file(arguments.out) as file:
        file.write_bytes(encoded(page, ".png"))
    print(f"{arguments.out}: {arguments.view} of {counted(len(houses), 'house')}")
    return 0


def _schema(arguments: argparse.Namespace) -> int:
    print(json.dumps(json_schema(), indent=1))
    return 0


_ACTIONS = (
    GENERATE,
    VARIANT,
    IMPORT,
    CHECK,
    Action(
        "show",
        _show,
        "draw the plan of every storey",
        "lexis-sim house show home.json -o home.png",
        (FILE, out_file("FILE.png|.svg")),
    ),
    Action(
        "export",
        _export,
        "write the house for other tools: as glTF, MJCF with textures, truth as JSON, plan as GeoJSON, or rooms for Hydra",
        "lexis-sim house export home.json -o home.glb",
        (FILE, out_file("FILE.glb|.xml|.json|.geojson|.yaml")),
    ),
    Action(
        "view",
        _view,
        "render a room with its furniture, from the corner or side from which most of it can be seen",
        "lexis-sim house view home.json --room 'kitchen 0.1' -o kitchen.png",
        (
            FILE,
            argument("--room", required=True, metavar="ID", help="id of the room, which 'house show' writes into the plan"),
            out_file("FILE.png"),
        ),
    ),
    Action(
        "gallery",
        _gallery,
        "draw many houses on one page: their plans, or a view of one room of each label",
        "lexis-sim house gallery --view rooms --seed 3 -o rooms.png",
        (
            argument(
                "--preset",
                default=",".join(PRESETS),
                metavar="A,B,...",
                help="families of houses, used in turn (default: all)",
            ),
            argument("--view", choices=("plans", "rooms"), default="plans", help="what to draw (default: %(default)s)"),
            argument("--houses", type=positive, default=25, help="number of houses (default: %(default)s)"),
            SEED,
            out_file("FILE.png"),
        ),
    ),
    PROVE,
    Action(
        "schema",
        _schema,
        "print the format of a house as JSON Schema, for editors and other tools",
        "lexis-sim house schema > house.schema.json",
        (),
    ),
)
