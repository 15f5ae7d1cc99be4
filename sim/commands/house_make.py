"""`lexis-sim house generate|variant|import`: the commands that make house files."""

import argparse
from pathlib import Path
from typing import get_args

from lexis.command_line import seed
from sim.commands.action import Action
from sim.commands.arguments import PRESET_HELP, SEED, argument, checked_house, number, out_file
from sim.commands.house_action import FILE, write_checked
from sim.errors import SimError
from sim.output_files import check_not_input
from worlds.presets import sample_from_rooms, sample_house
from worlds.spec import AppearanceSpec, HouseSpec

_DEFAULT_PRESET = "home"
_OUT = out_file("FILE.json")


def _generate(arguments: argparse.Namespace) -> int:
    rooms, options = arguments.rooms, {"openness": arguments.openness}
    if rooms is not None and not rooms.strip().lstrip("-").isdecimal():
        if arguments.preset is not None:
            raise SimError(
                f"--preset {arguments.preset}: cannot be combined with a list of --rooms; valid: --rooms with a number"
            )
        labels = [label.strip() for label in rooms.split(",")]
        spec = sample_from_rooms(
            labels,
            arguments.seed,
            clutter=arguments.clutter,
            storeys=1 if arguments.storeys is None else arguments.storeys,
            **options,
        )
    else:
        spec = sample_house(
            arguments.preset or _DEFAULT_PRESET,
            arguments.seed,
            clutter=arguments.clutter,
            rooms=None if rooms is None else int(rooms),
            storeys=arguments.storeys,
            **options,
        )
    write_checked(_with_appearance(spec, arguments), arguments.out)
    return 0


def _variant(arguments: argparse.Namespace) -> int:
    from worlds.variant import explicit, variant

    check_not_input(arguments.out, arguments.file)
    spec = checked_house(arguments.file)
    changed = variant(
        spec,
        openness=arguments.openness,
        clutter=arguments.clutter,
        mirror=arguments.mirror,
        rotate=arguments.rotate,
        repaint=arguments.repaint,
        add_storey=arguments.add_storey,
        climb=arguments.climb,
    )
    changed = _with_appearance(changed, arguments)
    if arguments.list_furniture:
        changed = explicit(changed)
    if changed == spec:
        raise SimError(f"{arguments.file}: nothing would change; see lexis-sim house variant --help")
    write_checked(changed, arguments.out)
    return 0


def _import(arguments: argparse.Namespace) -> int:
    from worlds.plan_import.importer import import_plan

    check_not_input(arguments.out, arguments.plan)
    plan = import_plan(
        arguments.plan,
        metres_per_unit=arguments.metres_per_unit,
        snap_m=arguments.snap,
        only_drawn=arguments.only_drawn,
        seed=arguments.seed,
    )
    write_checked(plan.spec, arguments.out)
    for note in plan.notes:
        print(f"note: {note}")
    return 0


def _with_appearance(spec: HouseSpec, arguments: argparse.Namespace) -> HouseSpec:
    asked = {name: value for name in ("texture", "light") if (value := getattr(arguments, name)) is not None}
    return spec.model_copy(update={"appearance": spec.appearance.model_copy(update=asked)}) if asked else spec


_OPENNESS = "open share of the area of the inner walls, 0 to 1"
_CLUTTER = "amount of furniture, 0 (none) to 4 (very crowded)"
_LIST = "list all furniture and windows in the file, so that each piece can be moved, changed or removed there"
_APPEARANCE = (
    argument(
        "--texture",
        choices=get_args(AppearanceSpec.model_fields["texture"].annotation),
        help="poor: few visual features; repeating: walls and floors with periodic patterns",
    ),
    argument(
        "--light", choices=get_args(AppearanceSpec.model_fields["light"].annotation), help="lighting by windows and lamps"
    ),
)

GENERATE = Action(
    "generate",
    _generate,
    "write a house as JSON",
    "lexis-sim house generate --preset home --seed 3 --openness 0.5 -o home.json",
    (
        argument("--preset", help=PRESET_HELP.replace("%(default)s", _DEFAULT_PRESET)),
        argument(
            "--rooms",
            metavar="N|A,B,...",
            help="number of rooms besides corridors, halls and stairs, 2 to 40, or a list of 1 to 40 room labels "
            "(default: the family's)",
        ),
        argument(
            "--storeys",
            type=int,
            metavar="N",
            help="number of storeys, 1 to 4 (default: the family's; 1 with a list of rooms)",
        ),
        argument("--openness", type=float, metavar="X", help=f"{_OPENNESS} (default: as the plan is drawn)"),
        argument("--clutter", type=float, default=1.0, metavar="X", help=f"{_CLUTTER} (default: %(default)s)"),
        *_APPEARANCE,
        SEED,
        _OUT,
    ),
)
VARIANT = Action(
    "variant",
    _variant,
    "change some properties of a house and leave everything else as it is",
    "lexis-sim house variant home.json --openness 0.8 -o open.json",
    (
        FILE,
        argument("--openness", type=float, metavar="X", help=_OPENNESS),
        argument("--clutter", type=float, metavar="X", help=f"{_CLUTTER}; furniture listed in the file stays"),
        argument("--mirror", action="store_true", help="mirror the house in x"),
        argument("--rotate", type=int, default=0, metavar="N", help="turn the house by N quarter turns counter-clockwise"),
        argument("--repaint", type=seed, metavar="SEED", help="draw other materials and colours"),
        argument("--add-storey", action="store_true", help="repeat the plan of the top storey on top"),
        argument("--list-furniture", action="store_true", help=_LIST),
        argument(
            "--climb",
            choices=("lift", "spiral"),
            help="put lifts or spiral stairs in place of all stairs; spirals need U-shaped stairs",
        ),
        *_APPEARANCE,
        _OUT,
    ),
)
IMPORT = Action(
    "import",
    _import,
    "make a house from a floor plan drawn as SVG or GeoJSON",
    "lexis-sim house import plan.svg --metres-per-unit 0.01 -o house.json",
    (
        argument("plan", type=Path, metavar="PLAN.svg|.geojson"),
        argument(
            "--metres-per-unit",
            type=float,
            metavar="X",
            help="scale of the drawing (default: 1 for GeoJSON, the file's for SVG)",
        ),
        argument(
            "--snap",
            type=number(0.001, 0.3),
            default=0.05,
            metavar="M",
            help="if the plan is invalid as drawn, move corners at most M metres apart onto one line; if rooms are drawn "
            "with gaps for the walls, M has to be the thickness of the walls (default: %(default)s)",
        ),
        argument(
            "--only-drawn",
            action="store_true",
            help="use only the drawn doors (default: rooms that they do not reach get additional doors)",
        ),
        SEED,
        _OUT,
    ),
)
