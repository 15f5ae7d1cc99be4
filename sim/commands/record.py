"""`lexis-sim record`: a run as a dataset for other programs."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from lexis.command_line import Commands, add_command, tell_of_replacement
from sim.commands.arguments import add_walk, folder, walk_options

FORMATS = {
    "euroc": "EuRoC ASL: stereo, 200 Hz IMU, true states, odometry; ORB-SLAM3 reads it, from PNG",
    "tum": "TUM RGB-D: colour, 16-bit depth, the camera's true path, accelerometer, odometry",
    "ros2": "ROS 2 bag (sqlite3): stereo, IMU, odometry, tf; VINS-Fusion and OpenVINS read it, with raw images",
    "mcap": "the same as MCAP",
}
IMAGES_HELP = (
    "png: replay gives the map of the live run, bit by bit; jpg: lossy, so that labels and loops may differ a little; "
    "raw: uncompressed, in bags only (default: %(default)s)"
)

RIGS = ("wide", "stereo", "front-rear", "four")
RIG_HELP = (
    f"cameras: {', '.join(RIGS)}; LEXIS sees the first; wide gets a second one 0.11 m to the right (default: %(default)s)"
)


def add_to(commands: Commands) -> None:
    """Add the command."""
    record = add_command(
        commands,
        "record",
        _record,
        "a run as a dataset for other programs, and for 'lexis run'",
        "lexis-sim record --preset home --seed 7 --format euroc -o recording\n"
        "  lexis run recording --rooms recording/rooms.json -o map",
    )
    add_walk(record)
    record.add_argument("--rig", choices=RIGS, default="wide", help=RIG_HELP)
    formats = "; ".join(f"{name}: {text}" for name, text in FORMATS.items())
    record.add_argument("--format", choices=FORMATS, default="euroc", help=f"{formats} (default: %(default)s)")
    record.add_argument("--images", choices=("png", "jpg", "raw"), default="png", help=IMAGES_HELP)
    record.add_argument(
        "-o", "--out", type=folder, default=Path("recording"), metavar="DIR", help="folder (default: %(default)s)"
    )


def _record(arguments: argparse.Namespace) -> int:
    from sim.harness import RunConfig
    from sim.record import record
    from sim.record.rooms import ROOMS
    from sim.rig import make_rig

    config = RunConfig(rig=make_rig(arguments.rig), **walk_options(arguments))
    tell_of_replacement(arguments.out, ROOMS)
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("recording", total=1.0)
        size = record(
            config,
            arguments.out,
            arguments.format,
            arguments.images,
            progress=lambda share: bar.update(task, completed=share),
        )
    print(f"{arguments.out}: {arguments.format}, {size / 1e6:.0f} MB")
    return 0
