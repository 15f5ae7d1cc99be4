"""`lexis export` and `lexis import`: maps for other tools, and maps from scene graphs."""

import argparse
from pathlib import Path

from lexis.command_line import Commands, add_command, note_replacement
from lexis.commands.arguments import check_map_folder, write_map
from lexis.files.replace import check_outside
from lexis.map.export import FORMATS, export_map
from lexis.map.folder import JSON_FILE, load_map
from lexis.map.interchange.spark_dsg_reader import read_spark_dsg


def add_to(commands: Commands) -> None:
    """Add the commands `export` and `import`."""
    export = add_command(commands, "export", _export, "the map for other tools", "lexis export map --format g2o -o map.g2o")
    export.add_argument("map", type=Path, metavar="MAP")
    export.add_argument("--format", choices=list(FORMATS), required=True, help="format of the file; ros writes a folder")
    export.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="file or folder to write")
    graph = add_command(
        commands, "import", _import, "a map from a scene graph of Spark-DSG", "lexis import map.dsg.json -o map"
    )
    graph.add_argument(
        "graph", type=Path, metavar="FILE", help="JSON that 'lexis export --format spark-dsg' wrote, or a changed copy"
    )
    graph.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the new map")


def _export(arguments: argparse.Namespace) -> int:
    check_outside(arguments.out, arguments.map)
    export_map(load_map(arguments.map), arguments.format, arguments.out)
    print(arguments.out)
    return 0


def _import(arguments: argparse.Namespace) -> int:
    check_map_folder(arguments.out)
    lexis_map = read_spark_dsg(arguments.graph)
    note_replacement(arguments.out, JSON_FILE)
    write_map(lexis_map, arguments.out)
    return 0
