"""`lexis relabel`: gives a map other room names, without its recording."""

import argparse
from pathlib import Path

from lexis.command_line import Commands, add_command, note_replacement
from lexis.commands.arguments import (
    MAP_ENCODER_HELP,
    ROOMS_HELP,
    add_settings,
    map_encoder,
    print_summary,
    room_names,
    settings,
)
from lexis.files.replace import check_outside, check_replaceable
from lexis.map.folder import JSON_FILE, load_map, save_map


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

    check_replaceable(arguments.out, JSON_FILE)
    check_outside(arguments.out, arguments.map)
    lexis_map = load_map(arguments.map)
    names = room_names(arguments.rooms)
    config = settings(arguments)
    renamed = relabel(lexis_map, names, map_encoder(lexis_map, arguments.encoder), config)
    note_replacement(arguments.out, JSON_FILE)
    save_map(renamed, arguments.out)
    print_summary(renamed, arguments.out)
    return 0
