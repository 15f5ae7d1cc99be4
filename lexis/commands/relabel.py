"""`lexis relabel`: gives a map other room names, without its recording."""

import argparse
from pathlib import Path

from lexis.command_line import Commands, add_command, note_replacement
from lexis.commands.arguments import (
    MAP_ENCODER_HELP,
    ROOMS_HELP,
    add_settings,
    check_map_folder,
    map_encoder,
    room_names,
    settings,
    write_map,
)
from lexis.map.folder import JSON_FILE, load_map


def add_to(commands: Commands) -> None:
    """Add the command `relabel`."""
    relabel = add_command(
        commands,
        "relabel",
        _relabel,
        "other room names for a map, no image encoded again",
        'lexis relabel map --rooms "kitchen,bathroom,bedroom,corridor,stairs" -o relabelled',
    )
    relabel.add_argument("map", type=Path, metavar="MAP")
    relabel.add_argument("--rooms", required=True, help=ROOMS_HELP)
    relabel.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the new map")
    add_settings(relabel)
    relabel.add_argument("--encoder", help=MAP_ENCODER_HELP)


def _relabel(arguments: argparse.Namespace) -> int:
    from lexis.map.relabelling import relabel

    check_map_folder(arguments.out, arguments.map)
    lexis_map = load_map(arguments.map)
    names = room_names(arguments.rooms)
    config = settings(arguments)
    renamed = relabel(lexis_map, names, map_encoder(lexis_map, arguments.encoder), config)
    note_replacement(arguments.out, JSON_FILE)
    write_map(renamed, arguments.out)
    return 0
