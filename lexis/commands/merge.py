"""`lexis merge`: makes one map from two maps of a building."""

import argparse
from pathlib import Path

from lexis.command_line import Commands, add_command, note_replacement
from lexis.commands.arguments import (
    MAP_ENCODER_HELP,
    add_settings,
    check_map_folder,
    map_encoder,
    recognisable_map,
    settings,
    write_map,
)
from lexis.map.folder import JSON_FILE


def add_to(commands: Commands) -> None:
    """Add the command `merge`."""
    merge = add_command(
        commands, "merge", _merge, "one map from two maps of a building", "lexis merge monday tuesday -o both"
    )
    merge.add_argument("first", type=Path, metavar="A", help="map whose coordinates the new map has")
    merge.add_argument("second", type=Path, metavar="B", help="map that is added")
    merge.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the new map")
    add_settings(merge)
    merge.add_argument("--encoder", help=MAP_ENCODER_HELP)


def _merge(arguments: argparse.Namespace) -> int:
    from lexis.merging import check_apart, merge

    check_map_folder(arguments.out, arguments.first, arguments.second)
    first, second = recognisable_map(arguments.first), recognisable_map(arguments.second)
    check_apart(first, second)
    config = settings(arguments)
    encoder = map_encoder(first, arguments.encoder)
    note_replacement(arguments.out, JSON_FILE)
    write_map(merge(first, second, encoder, config), arguments.out)
    return 0
