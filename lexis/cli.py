"""The console script `lexis`: maps from recorded runs, with no simulator.

Exit status: 0 on success, 2 on bad input, with one line on stderr that says what would be valid.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import Parser, add_command, positive, run_command
from lexis.encoder_options import PRECISIONS, EncoderOptions
from lexis.errors import LexisError
from lexis.export import FORMATS, export_map
from lexis.map_io import JSON_FILE, load_map, save_map
from lexis.planner import plan
from lexis.room_names import instance_names
from lexis.types import LexisMap, RoomInstance

if TYPE_CHECKING:
    from lexis.encoder import OpenClipEncoder

ENCODER_HELP = "mini, MODEL[:PRETRAINED] or MODEL:PATH of open_clip (default: %(default)s)"

FROM_HELP = 'an instance ("office 2") or a label ("office"): of its instances the one with the shortest way to the goal'
TO_HELP = (
    "likewise: of a label's instances the one nearest to the start by the length of the way; in both, an instance whose "
    "images look more like another room counts only where there is no other"
)
DATASET_HELP = "folder of a recording: TUM RGB-D (rgb.txt), EuRoC ASL (mav0) or ROS 2 bag; lexis.datasets says what is read"
ROOMS_HELP = 'names of rooms, with commas between them; or a JSON file, of which only its list "labels" is read'
ODOMETRY_HELP = "file, sensor folder or topic of the odometry (default: odometry.tum, odom0, /odom)"
CACHE_HELP = "folder that keeps the encoder's work by image, so that mapping a recording again skips it"
QUERY_NOTE = "mini was trained on renders of generated houses; maps of photographs want real CLIP weights."


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return the exit status."""
    return run_command(_parser(), argv, (LexisError,))


def _parser() -> Parser:
    parser = Parser(
        "lexis", description="Indoor SLAM that understands language: rooms, floors, loops and plans from RGB and odometry."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    run = add_command(
        commands, "run", _run, "map a recorded run", 'lexis run recording --rooms "kitchen,office,corridor,stairs" -o map'
    )
    run.add_argument("dataset", type=Path, metavar="DATASET", help=DATASET_HELP)
    run.add_argument("--rooms", type=_rooms, required=True, help=ROOMS_HELP)
    run.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the map")
    run.add_argument("--encoder", default="mini", help=ENCODER_HELP)
    run.add_argument("--cache", type=Path, metavar="DIR", help=CACHE_HELP)
    run.add_argument("--device", default="cpu", help="cpu, cuda or cuda:N, for the encoder (default: %(default)s)")
    run.add_argument("--precision", choices=PRECISIONS, default="fp32", help="of the encoder (default: %(default)s)")
    run.add_argument("--odometry", metavar="NAME", help=ODOMETRY_HELP)
    run.add_argument("--camera", metavar="NAME", help="of several, the camera to use (default: cam0)")
    path = add_command(
        commands, "plan", _plan, "the shortest way between two rooms", "lexis plan map --from office --to kitchen"
    )
    path.add_argument("map", type=Path, metavar="MAP")
    path.add_argument("--from", dest="start", required=True, metavar="ROOM", help=FROM_HELP)
    path.add_argument("--to", dest="goal", required=True, metavar="ROOM", help=TO_HELP)
    query = add_command(
        commands, "query", _query, "the rooms that fit a description best", 'lexis query map "a room with a bathtub"'
    )
    query.epilog = f"{query.epilog}\n\n{QUERY_NOTE}"
    query.add_argument("map", type=Path, metavar="MAP")
    query.add_argument("text", metavar="TEXT", help="in any words that the encoder understands")
    query.add_argument("--encoder", default="mini", help=f"the one the map was made with: {ENCODER_HELP}")
    query.add_argument("--top", type=positive, default=3, help="rooms to list (default: %(default)s)")
    export = add_command(commands, "export", _export, "the map for other tools", "lexis export map --format g2o -o map.g2o")
    export.add_argument("map", type=Path, metavar="MAP")
    export.add_argument("--format", choices=list(FORMATS), required=True)
    export.add_argument("-o", "--out", type=Path, required=True, metavar="FILE")
    return parser


def _run(arguments: argparse.Namespace) -> int:
    # Late imports: torch takes seconds, and the other commands do without.
    from rich.console import Console
    from rich.progress import track

    from lexis.datasets import DatasetConfig, open_dataset
    from lexis.files import check_replaceable
    from lexis.slam import Slam

    check_replaceable(arguments.out, JSON_FILE)
    options = EncoderOptions(arguments.device, arguments.precision, cache=arguments.cache)
    dataset = open_dataset(arguments.dataset, DatasetConfig(arguments.odometry, arguments.camera))
    slam = Slam(dataset.camera, _encoder(arguments.encoder, options), arguments.rooms)
    for observation in track(dataset, "mapping", console=Console(stderr=True), disable=not sys.stderr.isatty()):
        slam.process(observation)
    lexis_map = slam.finish()
    save_map(lexis_map, arguments.out)
    rooms = ", ".join(instance_names(lexis_map.rooms))
    print(f"{len(lexis_map.keyframes)} keyframes, {len(lexis_map.loops)} loop edges, rooms: {rooms}")
    print(arguments.out)
    return 0


def _plan(arguments: argparse.Namespace) -> int:
    lexis_map = load_map(arguments.map)
    result = plan(lexis_map, arguments.start, arguments.goal)
    start, goal = (_place(lexis_map, room) for room in (result.start, result.goal))
    print(f"{start} to {goal}: {result.length_m:.1f} m, {len(result.keyframes)} keyframes")
    for i in result.keyframes:
        x, y, z = lexis_map.T_W_B[i, :3, 3]
        print(f"{i:6d}  {x:8.2f} {y:8.2f} {z:8.2f} m  {lexis_map.label_of(i)}")
    return 0


def _place(lexis_map: LexisMap, room: RoomInstance) -> str:
    where = "between floors" if room.floor is None else f"floor {room.floor}"
    return f"{instance_names(lexis_map.rooms)[room.id]} ({where})"


def _query(arguments: argparse.Namespace) -> int:
    from lexis.query import rank_rooms

    lexis_map = load_map(arguments.map)
    if not arguments.text.strip():
        raise LexisError("the question is blank; valid: some words")
    text = _encoder(arguments.encoder).encode_texts([arguments.text])[0]
    names = instance_names(lexis_map.rooms)
    for answer in rank_rooms(lexis_map, text)[: arguments.top]:
        print(f"{names[answer.room.id]:24s} {answer.similarity:.3f}  keyframe {answer.keyframe}")
    return 0


def _export(arguments: argparse.Namespace) -> int:
    export_map(load_map(arguments.map), arguments.format, arguments.out)
    return 0


def _encoder(model: str, options: EncoderOptions | None = None) -> "OpenClipEncoder":
    from lexis.encoder import load_encoder

    return load_encoder(model, options)


def _rooms(text: str) -> tuple[str, ...]:
    if not text.endswith(".json"):
        return tuple(name.strip() for name in text.split(","))
    try:
        labels = json.loads(Path(text).read_text(encoding="utf-8"))["labels"]
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{text}: cannot be read: {error.strerror}") from None
    except (KeyError, TypeError, ValueError):
        labels = None
    if not isinstance(labels, list) or not all(isinstance(label, str) for label in labels):
        raise argparse.ArgumentTypeError(f'{text}: has no list "labels" of names of rooms')
    return tuple(labels)


if __name__ == "__main__":
    sys.exit(main())
