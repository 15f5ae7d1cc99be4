"""`lexis info`: says what a map holds, and draws it."""

import argparse
import json
import sys
from pathlib import Path

from lexis.command_line import Commands, add_command
from lexis.commands.arguments import JSON_HELP
from lexis.errors import LexisError
from lexis.files.replace import check_outside
from lexis.map.export import export_map
from lexis.map.folder import load_map
from lexis.map.info import info_text, map_info


def add_to(commands: Commands) -> None:
    """Add the command `info`."""
    info = add_command(commands, "info", _info, "what a map holds", "lexis info map --picture map.svg")
    info.add_argument("map", type=Path, metavar="MAP")
    info.add_argument("--json", action="store_true", help=JSON_HELP)
    info.add_argument("--picture", type=Path, metavar="FILE", help="draw the map too, as an SVG file that browsers show")


def _info(arguments: argparse.Namespace) -> int:
    picture = arguments.picture
    if picture and picture.suffix.lower() != ".svg":
        raise LexisError(f"--picture {picture}: only SVG is drawn; valid: a name that ends in .svg")
    if picture:
        check_outside(picture, arguments.map)
    lexis_map = load_map(arguments.map)
    info = map_info(lexis_map)
    print(json.dumps(info, indent=1) if arguments.json else info_text(info))
    if picture:
        export_map(lexis_map, "svg", picture)
        print(f"picture: {picture}", file=sys.stderr)
    return 0
