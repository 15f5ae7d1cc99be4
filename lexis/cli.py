"""The console script `lexis`, which makes maps from recorded runs and works with them. It needs no simulator.

The exit status is 0 on success. On bad input it is 2, and one line on stderr says what would be valid. If a recording breaks
off, `lexis run` saves what it has mapped, and says so in a line before.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import (
    ENCODER_HELP,
    MAX_LINE,
    Commands,
    Parser,
    add_command,
    add_completion,
    interrupted_later,
    note_replacement,
    positive,
    run_command,
)
from lexis.config import Config, read_config
from lexis.encoder.options import PRECISIONS, EncoderOptions
from lexis.errors import DatasetError, EncoderError, LexisError, MapError, ObservationError, PlanError, one_line
from lexis.files.reading import FileKind, read_json
from lexis.files.replace import check_outside, check_replaceable
from lexis.graph.components import sessions_apart
from lexis.map.export import FORMATS, export_map
from lexis.map.folder import JSON_FILE, load_map, save_map
from lexis.map.info import info_text, map_info
from lexis.map.interchange.spark_dsg_reader import read_spark_dsg
from lexis.map.path_directions import directions, place, plan_summary
from lexis.planning.planner import plan
from lexis.room_names import find_rooms, instance_names, unused_names
from lexis.settings import settings_data
from lexis.types import LexisMap

if TYPE_CHECKING:
    from lexis.encoder.open_clip_encoder import OpenClipEncoder
    from lexis.slam import Slam

_FAST_M_S = 15.0
"""Mean speed above which a recording is probably in other units [m/s]."""
FROM_HELP = 'an instance ("office 2"), or a label ("office"): the instance with the shortest path to the goal is chosen'
TO_HELP = (
    "an instance, a label (the instance with the shortest path is chosen), or a description in several words. In --from and "
    "--to, an instance whose images resemble another room more is used only if the label has no other"
)
AVOID_HELP = "an instance, or a label (all its rooms), that the path must not enter; may be given several times"
DATASET_HELP = "folder of a recording in one of the forms below"
DATASET_NOTE = """\
A dataset is a folder that holds one of:
  TUM RGB-D   rgb.txt        lines of "stamp file"
              odometry.tum   lines of "stamp tx ty tz qx qy qz qw": pose of the body by odometry [s, m]
              camera.json    width, height, fx, fy, cx, cy [px], and T_B_C: 4x4 pose of the camera on the body
  EuRoC ASL   mav0/cam0      sensor.yaml, data.csv and images in data
              mav0/odom0     data.csv: stamp [ns], position [m], quaternion w x y z
  ROS 2 bag   metadata.yaml beside the files of the bag, with the topics /cam0/image_raw (or /compressed),
              /cam0/camera_info, /odom and /tf_static
Images are PNG or JPEG, or raw in bags. Covariances of the odometry are read where there are any."""
JSON_HELP = "print JSON for scripts instead of text for people"
ROOMS_HELP = 'names of rooms, with commas between them; or a JSON file, of which only its list "labels" is read'
ODOMETRY_HELP = "file, sensor folder or topic of the odometry (default: odometry.tum, odom0, /odom)"
CAMERA_HELP = (
    "camera to use, or several of a rig with commas between them: cam0,cam1 (default: cam0); for TUM RGB-D, which has one "
    "camera, its file (default: camera.json)"
)
CACHE_HELP = "folder in which embeddings of images are kept, so that a recording is mapped again faster"
MAP_ENCODER_HELP = "default: the encoder that made the map, under the name or path that it had then"
CALIBRATION_HELP = (
    "calibration of the encoder, as 'lexis-sim calibrate-queries' writes it (default for mini: the included one)"
)
_ROOMS_FILE = FileKind('names, or a file with a list "labels" of names of rooms', 1_000_000)
EXAMPLE = """example:
  lexis run recording --rooms "kitchen,office,corridor,stairs" -o map
  lexis query map "where can I wash my hands"
"""
QUERY_NOTE = """\
Probabilities hold for houses like those of the calibration, if every second question has an answer. If no room reaches
0.5, nothing in the map fits. "not a kitchen" asks for all rooms that are no kitchens: each probability is that the room is
no kitchen, and each similarity is to a kitchen. A question that negates only a part of itself is refused. Without a
calibration, only similarities are shown. They can be compared within one question; one of them is always the largest, even
if no room fits. mini was trained on renders of generated houses; maps of photographs need real CLIP weights, and
'lexis-sim calibrate-queries' for them."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return the exit status."""
    return run_command(parser(), argv, (LexisError,))


def parser() -> Parser:
    """Return the parser of all commands."""
    root = Parser(
        "lexis",
        description="Indoor SLAM that understands language: rooms, floors, loops and plans from RGB and odometry.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = root.add_subparsers(required=True, metavar="COMMAND")
    for add in (
        _add_run, _add_merge, _add_info, _add_plan, _add_query, _add_relabel, _add_export, _add_import, _add_config,
    ):  # fmt: skip
        add(commands)
    add_completion(commands, root)
    return root


def _add_run(commands: Commands) -> None:
    run = add_command(
        commands, "run", _run, "map a recorded run", 'lexis run recording --rooms "kitchen,office,corridor,stairs" -o map'
    )
    run.epilog = f"{run.epilog}\n\n{DATASET_NOTE}"
    run.add_argument("dataset", type=Path, metavar="DATASET", help=DATASET_HELP)
    run.add_argument("--rooms", help=f"{ROOMS_HELP} (with --map: those of the map)")
    run.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the map")
    run.add_argument("--map", type=Path, metavar="OLD", help="map that the recording continues; MAP then holds both")
    run.add_argument("--save-every", type=positive, metavar="N", help="also save the map after every N keyframes")
    _add_settings(run)
    run.add_argument("--encoder", default="mini", help=ENCODER_HELP)
    run.add_argument("--cache", type=Path, metavar="DIR", help=CACHE_HELP)
    run.add_argument("--device", default="cpu", help="cpu, cuda or cuda:N, for the encoder (default: %(default)s)")
    run.add_argument(
        "--precision", choices=PRECISIONS, default="fp32", help="precision of the encoder (default: %(default)s)"
    )
    run.add_argument("--odometry", metavar="NAME", help=ODOMETRY_HELP)
    run.add_argument("--camera", metavar="NAME", help=CAMERA_HELP)


def _add_merge(commands: Commands) -> None:
    merge = add_command(
        commands, "merge", _merge, "one map from two maps of a building", "lexis merge monday tuesday -o both"
    )
    merge.add_argument("first", type=Path, metavar="A", help="map whose coordinates the new map has")
    merge.add_argument("second", type=Path, metavar="B", help="map that is added")
    merge.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the new map")
    _add_settings(merge)
    merge.add_argument("--encoder", help=MAP_ENCODER_HELP)


def _add_info(commands: Commands) -> None:
    info = add_command(commands, "info", _info, "what a map holds", "lexis info map --picture map.svg")
    info.add_argument("map", type=Path, metavar="MAP")
    info.add_argument("--json", action="store_true", help=JSON_HELP)
    info.add_argument("--picture", type=Path, metavar="FILE", help="draw the map too, as an SVG file that browsers show")


def _add_plan(commands: Commands) -> None:
    path = add_command(
        commands, "plan", _plan, "the shortest path between two rooms", "lexis plan map --from office --to kitchen"
    )
    path.add_argument("map", type=Path, metavar="MAP")
    path.add_argument("--from", dest="start", required=True, metavar="ROOM", help=FROM_HELP)
    path.add_argument("--to", dest="goal", required=True, metavar="ROOM", help=TO_HELP)
    path.add_argument("--avoid", action="append", default=[], metavar="ROOM", help=AVOID_HELP)
    _add_settings(path, ", of which those of 'planner' are used")
    path.add_argument("--calibration", type=Path, metavar="FILE", help=CALIBRATION_HELP)
    path.add_argument("--keyframes", action="store_true", help="also list the keyframes on the path, with their positions")
    path.add_argument("--json", action="store_true", help=f"{JSON_HELP}, keyframes included")


def _add_query(commands: Commands) -> None:
    query = add_command(
        commands, "query", _query, "the rooms that fit a description best", 'lexis query map "where can I wash my hands"'
    )
    query.epilog = f"{query.epilog}\n\n{QUERY_NOTE}"
    query.add_argument("map", type=Path, metavar="MAP")
    query.add_argument("text", metavar="TEXT", help="in any words that the encoder understands")
    query.add_argument("--encoder", help=MAP_ENCODER_HELP)
    query.add_argument("--calibration", type=Path, metavar="FILE", help=CALIBRATION_HELP)
    query.add_argument("--top", type=positive, default=3, help="rooms to list (default: %(default)s)")
    query.add_argument("--keyframes", type=positive, default=0, metavar="N", help="list the N best keyframes too")


def _add_relabel(commands: Commands) -> None:
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
    _add_settings(relabel)
    relabel.add_argument("--encoder", help=MAP_ENCODER_HELP)


def _add_export(commands: Commands) -> None:
    export = add_command(commands, "export", _export, "the map for other tools", "lexis export map --format g2o -o map.g2o")
    export.add_argument("map", type=Path, metavar="MAP")
    export.add_argument("--format", choices=list(FORMATS), required=True, help="format of the file; ros writes a folder")
    export.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="file or folder to write")


def _add_import(commands: Commands) -> None:
    graph = add_command(
        commands, "import", _import, "a map from a scene graph of Spark-DSG", "lexis import map.dsg.json -o map"
    )
    graph.add_argument(
        "graph", type=Path, metavar="FILE", help="JSON that 'lexis export --format spark-dsg' wrote, or a changed copy"
    )
    graph.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the new map")


def _add_settings(parser: Parser, which: str = "") -> None:
    """Add the option that names a file of settings; `which` says in its help text which of the settings are used."""
    help = f"settings as JSON{which} (default: those that 'lexis config' prints)"
    parser.add_argument("--config", type=Path, metavar="FILE", help=help)


def _settings(arguments: argparse.Namespace) -> Config:
    """Return the settings of `--config`, or the defaults without this option."""
    return read_config(arguments.config) if arguments.config else Config()


def _add_config(commands: Commands) -> None:
    add_command(commands, "config", _config, "all settings with their defaults, as JSON", "lexis config > settings.json")


def _run(arguments: argparse.Namespace) -> int:
    # Imported here, because loading torch takes seconds and the other commands do not need it.
    from rich.console import Console
    from rich.progress import track

    from lexis.datasets.dataset import DatasetConfig, open_dataset
    from lexis.merging import holds_image
    from lexis.slam import Slam

    check_replaceable(arguments.out, JSON_FILE)
    options = EncoderOptions(arguments.device, arguments.precision, cache=arguments.cache)
    dataset = open_dataset(arguments.dataset, DatasetConfig(arguments.odometry, arguments.camera))
    old = _with_features(arguments.map) if arguments.map else None
    if old is None and arguments.rooms is None:
        raise LexisError("--rooms is missing; valid: --rooms with names of rooms, or --map with a map that has them")
    names = old.room_names if old and arguments.rooms is None else _rooms(arguments.rooms)
    config, encoder = _settings(arguments), _encoder(arguments.encoder, options)
    slam = Slam(dataset.camera, encoder, names, config, map=old)
    if old is not None and holds_image(old, next(iter(dataset)), encoder):
        print(f"note: {arguments.map} already holds this recording; the new map will hold it twice", file=sys.stderr)
    before = saved = slam.keyframe_count
    note_replacement(arguments.out, JSON_FILE)
    shown = track(dataset, "mapping", console=Console(stderr=True), disable=not sys.stderr.isatty())
    with interrupted_later() as pressed:
        try:
            for observation in shown:
                slam.process(observation)
                if arguments.save_every and slam.keyframe_count >= saved + arguments.save_every:
                    save_map(slam.snapshot(), arguments.out)
                    saved = slam.keyframe_count
                if pressed.is_set():
                    raise _Stopped
        except (DatasetError, ObservationError, EncoderError, _Stopped):
            _save_part(slam, before, arguments.out)
            raise
        lexis_map = slam.finish()
        save_map(lexis_map, arguments.out)
    _report(lexis_map, arguments.out)
    return 0


class _Stopped(KeyboardInterrupt):
    """Ctrl-C, between two observations."""


def _save_part(slam: "Slam", before: int, folder: Path) -> None:
    """Save what a run that ends early has added to the `before` keyframes of an earlier map, if anything, and say so."""
    try:
        part = slam.finish()
    except LexisError:  # there was no observation
        return
    if len(part.keyframes) > before:
        save_map(part, folder)
        told = f"lexis: the run ended early; {folder} holds the map until then, {_count(len(part.keyframes), 'keyframe')}"
        print(one_line(told, MAX_LINE), file=sys.stderr)


def _merge(arguments: argparse.Namespace) -> int:
    from lexis.merging import check_apart, merge

    check_replaceable(arguments.out, JSON_FILE)
    first, second = _with_features(arguments.first), _with_features(arguments.second)
    check_apart(first, second)
    config = _settings(arguments)
    encoder = _map_encoder(first, arguments.encoder)
    note_replacement(arguments.out, JSON_FILE)
    lexis_map = merge(first, second, encoder, config)
    save_map(lexis_map, arguments.out)
    _report(lexis_map, arguments.out)
    return 0


def _with_features(folder: Path) -> LexisMap:
    """Load a map to which a session can be added. Raises MapError if the map has no key points to recognise places by."""
    lexis_map = load_map(folder)
    if not any(len(keyframe.features.keypoints) for keyframe in lexis_map.keyframes):
        valid = "valid: a map that 'lexis run' made of images and that was not imported since"
        raise MapError(f"{folder}: the map has no key points to recognise places by; {valid}")
    return lexis_map


def _config(arguments: argparse.Namespace) -> int:
    print(json.dumps(settings_data(Config()), indent=1))
    return 0


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


def _plan(arguments: argparse.Namespace) -> int:
    lexis_map = load_map(arguments.map)
    _check_room(lexis_map, arguments.start, "or a label alone; only --to takes a description")
    goal = _goal(lexis_map, arguments.goal, arguments.calibration)
    _check_room(lexis_map, goal, "a label alone, or a description of several words")
    result = plan(lexis_map, arguments.start, goal, _settings(arguments).planner, arguments.avoid)
    if arguments.json:
        print(json.dumps(plan_summary(lexis_map, result), indent=1))
        return 0
    start, goal = (place(lexis_map, room.id) for room in (result.start, result.goal))
    print(f"{start} to {goal}: {result.length_m:.1f} m, {_count(len(result.keyframes), 'keyframe')}")
    for number, step in enumerate(directions(lexis_map, result), 1):
        print(f"{number:3d}. {step.at_m:6.1f} m  {step.text}")
    for i in result.keyframes if arguments.keyframes else ():
        x, y, z = lexis_map.T_W_B[i, :3, 3]
        print(f"keyframe {i:6d}  {x:8.2f} {y:8.2f} {z:8.2f} m  {lexis_map.label_of(i)}")
    return 0


def _check_room(lexis_map: LexisMap, name: str, more: str) -> None:
    """Raise PlanError unless the map has a room of this name; `more` says what else is valid."""
    if not find_rooms(lexis_map.rooms, name):
        raise PlanError(f"no room {name!r} in the map; valid: {', '.join(instance_names(lexis_map.rooms))}, {more}")


def _goal(lexis_map: LexisMap, text: str, calibration: Path | None) -> str:
    """Return `text` if it is one word or the name of a room that may exist; otherwise, the name of the room it describes."""
    label, _, number = text.rpartition(" ")
    is_name = find_rooms(lexis_map.rooms, text) or (number.isdecimal() and find_rooms(lexis_map.rooms, label))
    if is_name or len(text.split()) < 2:
        return text
    from lexis.questions.calibration import find_calibration
    from lexis.questions.goals import goal_in_words

    encoder = _map_encoder(lexis_map, None)
    return goal_in_words(lexis_map, text, encoder, find_calibration(encoder, calibration))


def _query(arguments: argparse.Namespace) -> int:
    from lexis.questions.answers import ask
    from lexis.questions.calibration import find_calibration

    lexis_map = load_map(arguments.map)
    encoder = _map_encoder(lexis_map, arguments.encoder)
    answer = ask(lexis_map, arguments.text, encoder, find_calibration(encoder, arguments.calibration))
    names = instance_names(lexis_map.rooms)
    best = answer.rooms[0]
    if answer.unknown:
        print(f"nothing in this map fits (best: {names[best.room.id]}, probability {best.probability:.2f})")
        return 0
    if best.probability is None:
        print("no calibration for this encoder: similarities alone, see lexis query --help", file=sys.stderr)
    for fit in answer.rooms[: arguments.top]:
        likely = "" if fit.probability is None else f"probability {fit.probability:.2f}  "
        print(f"{names[fit.room.id]:24s} {likely}similarity {fit.similarity:.3f}  keyframe {fit.keyframe}")
    room_of = lexis_map.room_of
    for i, similarity in answer.keyframes[: arguments.keyframes]:
        x, y, z = lexis_map.T_W_B[i, :3, 3]
        room = names[room_of[i]] if room_of[i] >= 0 else "no room"
        print(f"keyframe {i:<15d} similarity {similarity:.3f}  {x:.2f} {y:.2f} {z:.2f} m  {room}")
    return 0


def _relabel(arguments: argparse.Namespace) -> int:
    from lexis.map.relabelling import relabel

    check_replaceable(arguments.out, JSON_FILE)
    lexis_map = load_map(arguments.map)
    names = _rooms(arguments.rooms)
    config = _settings(arguments)
    renamed = relabel(lexis_map, names, _map_encoder(lexis_map, arguments.encoder), config)
    note_replacement(arguments.out, JSON_FILE)
    save_map(renamed, arguments.out)
    _report(renamed, arguments.out)
    return 0


def _report(lexis_map: LexisMap, folder: Path) -> None:
    """Print a summary of a written map: counts of keyframes and loop edges, rooms, and the map's folder."""
    keyframes, loops = _count(len(lexis_map.keyframes), "keyframe"), _count(len(lexis_map.loops), "loop edge")
    print(f"{keyframes}, {loops}, rooms: {', '.join(instance_names(lexis_map.rooms))}")
    info = map_info(lexis_map)
    if info["path_m"] > _FAST_M_S * info["duration_s"] > 0.0:
        speed = f"{info['path_m'] / info['duration_s']:.0f} m/s on average"
        print(f"warning: the camera moves at {speed}; positions have to be in metres, and stamps in seconds")
    if missing := unused_names(lexis_map.room_names, lexis_map.rooms):
        print(f"no room: {', '.join(missing)}")
    if apart := sessions_apart(lexis_map):
        print(
            f"not recognised in the rest of the map: {', '.join(f'session {number}' for number in apart)}; the map holds it "
            "as a separate part, which no plan connects with the rest"
        )
    elif (sessions := lexis_map.keyframes[-1].session + 1) > 1:
        print(f"all {sessions} sessions are joined in one map")
    print(folder)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _map_encoder(lexis_map: LexisMap, asked: str | None) -> "OpenClipEncoder":
    """Load the requested encoder, or the encoder that made the map if none was requested."""
    try:
        return _encoder(asked or lexis_map.encoder.name)
    except EncoderError as error:
        if asked:
            raise
        raise MapError(
            f"the map was made with encoder {lexis_map.encoder.name!r}, which cannot be loaded: {error}"
        ) from None


def _export(arguments: argparse.Namespace) -> int:
    check_outside(arguments.out, arguments.map)
    export_map(load_map(arguments.map), arguments.format, arguments.out)
    print(arguments.out)
    return 0


def _import(arguments: argparse.Namespace) -> int:
    check_replaceable(arguments.out, JSON_FILE)
    lexis_map = read_spark_dsg(arguments.graph)
    note_replacement(arguments.out, JSON_FILE)
    save_map(lexis_map, arguments.out)
    _report(lexis_map, arguments.out)
    return 0


def _encoder(model: str, options: EncoderOptions | None = None) -> "OpenClipEncoder":
    from lexis.encoder.open_clip_encoder import load_encoder

    return load_encoder(model, options)


def _rooms(text: str) -> tuple[str, ...]:
    if not text.endswith(".json"):
        return tuple(name.strip() for name in text.split(","))
    data = read_json(Path(text), _ROOMS_FILE)
    labels = data.get("labels") if isinstance(data, dict) else None
    if not isinstance(labels, list) or not all(isinstance(label, str) for label in labels):
        raise _ROOMS_FILE.refusal(Path(text), 'has no list "labels" of names')
    return tuple(labels)
