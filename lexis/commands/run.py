"""`lexis run`: maps a recorded run."""

import argparse
import sys
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

from lexis.command_line import (
    ENCODER_HELP,
    MAX_LINE,
    Commands,
    add_command,
    interrupted_later,
    note_replacement,
    positive,
)
from lexis.commands.arguments import (
    ROOMS_HELP,
    add_settings,
    check_map_folder,
    counted,
    encoder_named,
    print_summary,
    recognisable_map,
    room_names,
    settings,
)
from lexis.encoder.options import PRECISIONS, EncoderOptions
from lexis.errors import DatasetError, EncoderError, LexisError, ObservationError, one_line
from lexis.files.replace import check_outside, similar_name
from lexis.map.folder import JSON_FILE, save_map

if TYPE_CHECKING:
    from lexis.datasets.dataset import Dataset
    from lexis.slam import Slam

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
ODOMETRY_HELP = "file, sensor folder or topic of the odometry (default: odometry.tum, odom0, /odom)"
CAMERA_HELP = (
    "camera to use, or several of a rig with commas between them: cam0,cam1 (default: cam0); for TUM RGB-D, which has one "
    "camera, its file (default: camera.json)"
)
CACHE_HELP = "folder in which embeddings of images are kept, so that a recording is mapped again faster"


def add_to(commands: Commands) -> None:
    """Add the command `run`."""
    run = add_command(
        commands, "run", _run, "map a recorded run", 'lexis run recording --rooms "kitchen,office,corridor,stairs" -o map'
    )
    run.epilog = f"{run.epilog}\n\n{DATASET_NOTE}"
    run.add_argument("dataset", type=Path, metavar="DATASET", help=DATASET_HELP)
    run.add_argument("--rooms", help=f"{ROOMS_HELP} (with --map: those of the map)")
    run.add_argument("-o", "--out", type=Path, required=True, metavar="MAP", help="folder of the map")
    run.add_argument("--map", type=Path, metavar="OLD", help="map that the recording continues; MAP then holds both")
    run.add_argument("--save-every", type=positive, metavar="N", help="also save the map after every N keyframes")
    add_settings(run)
    run.add_argument("--encoder", default="mini", help=ENCODER_HELP)
    run.add_argument("--cache", type=Path, metavar="DIR", help=CACHE_HELP)
    run.add_argument("--device", default="cpu", help="cpu, cuda or cuda:N, for the encoder (default: %(default)s)")
    run.add_argument(
        "--precision", choices=PRECISIONS, default="fp32", help="precision of the encoder (default: %(default)s)"
    )
    run.add_argument("--odometry", metavar="NAME", help=ODOMETRY_HELP)
    run.add_argument("--camera", metavar="NAME", help=CAMERA_HELP)


def _run(arguments: argparse.Namespace) -> int:
    from lexis.datasets.dataset import DatasetConfig, open_dataset
    from lexis.merging import holds_image
    from lexis.slam import Slam

    check_map_folder(arguments.out)
    if arguments.map is not None and arguments.map.resolve() != arguments.out.resolve():  # it may be replaced as a whole
        check_outside(arguments.out, arguments.map)
    options = EncoderOptions(arguments.device, arguments.precision, cache=arguments.cache)
    dataset = open_dataset(arguments.dataset, DatasetConfig(arguments.odometry, arguments.camera))
    old = recognisable_map(arguments.map) if arguments.map else None
    if old is None and arguments.rooms is None:
        raise LexisError("--rooms is missing; valid: --rooms with names of rooms, or --map with a map that has them")
    names = old.room_names if old and arguments.rooms is None else room_names(arguments.rooms)
    config, encoder = settings(arguments), encoder_named(arguments.encoder, options)
    slam = Slam(dataset.camera, encoder, names, config, map=old)
    if old is not None and holds_image(old, next(iter(dataset)), encoder):
        print(f"note: {arguments.map} already holds this recording; the new map will hold it twice", file=sys.stderr)
    note_replacement(arguments.out, JSON_FILE)
    before, is_kept = slam.keyframe_count, (arguments.out / JSON_FILE).is_file() and not arguments.save_every
    with interrupted_later() as pressed:
        try:
            _process(slam, dataset, pressed, arguments)
        except (DatasetError, ObservationError, EncoderError, _Stopped):
            _save_part(slam, before, arguments.out, is_kept)
            raise
        lexis_map = slam.finish()
        save_map(lexis_map, arguments.out)
    print_summary(lexis_map, arguments.out)
    return 0


def _process(slam: "Slam", dataset: "Dataset", pressed: Event, arguments: argparse.Namespace) -> None:
    """Give all observations to the SLAM, and save the map as often as `--save-every` asks.

    Raises `_Stopped` after the observation during which Ctrl-C was pressed.
    """
    from rich.console import Console
    from rich.progress import track

    saved = slam.keyframe_count
    for observation in track(dataset, "mapping", console=Console(stderr=True), disable=not sys.stderr.isatty()):
        slam.process(observation)
        if arguments.save_every and slam.keyframe_count >= saved + arguments.save_every:
            save_map(slam.snapshot(), arguments.out)
            saved = slam.keyframe_count
        if pressed.is_set():
            raise _Stopped


class _Stopped(KeyboardInterrupt):
    """Ctrl-C, between two observations."""


def _save_part(slam: "Slam", before: int, out: Path, is_kept: bool) -> None:
    """Save the map of a run that ends early, and print a line about it.

    Nothing is saved if the run has added no keyframe to the `before` keyframes of an earlier map. If a map in `out` is to be
    kept, because it may be a finished one, the part is saved under a similar name.
    """
    try:
        part = slam.finish()
    except LexisError:  # there was no observation
        return
    if len(part.keyframes) > before:
        folder = similar_name(out) if is_kept else out
        save_map(part, folder)
        told = f"lexis: the run ended early; {folder} holds the map until then, {counted(len(part.keyframes), 'keyframe')}"
        kept = f"; {out} is unchanged" if is_kept else ""
        print(one_line(f"{told}{kept}", MAX_LINE), file=sys.stderr)
