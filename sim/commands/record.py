"""`lexis-sim record`: a run as a dataset for other programs."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from lexis.command_line import Commands, add_command, tell_of_replacement
from sim.commands.arguments import add_walk, folder, number, numbers, walk_options

FORMATS = {
    "euroc": "EuRoC ASL: stereo, 200 Hz IMU, true states, odometry; ORB-SLAM3 reads it, from PNG",
    "tum": "TUM RGB-D: colour, 16-bit depth, the camera's true path, accelerometer, odometry; ORB-SLAM3 reads it as RGB-D",
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

LEVER_ARM = "X,Y,Z[,ROLL,PITCH,YAW]"
LEVER_ARM_HELP = (
    "place of the cameras on the IMU: forward, left, up in metres, up to 0.15 in all, and their rotation in degrees "
    "(default: in the IMU, looking ahead); --lever-arm=-0.02,... where the first is negative"
)
IMU_BIAS_HELP = (
    "biases with which the IMU starts, drawn with standard deviations of FACTOR x 0.5 deg/s and FACTOR x 20 mg "
    "(default: none; without a number: 1)"
)
DISTORTION_HELP = (
    "radial-tangential distortion of the images, as in --distortion=-0.1,0.008,0,0, or barrel, usual of a lens this "
    "wide; calibrations and settings say so (default: none)"
)
BARREL = (-0.1, 0.008, 0.0005, -0.0003)
"""Like a wide lens, not like EuRoC's: coefficients fitted to 78 degrees make straight lines wavy at 100."""


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
    _add_calibration(record)
    formats = "; ".join(f"{name}: {text}" for name, text in FORMATS.items())
    record.add_argument("--format", choices=FORMATS, default="euroc", help=f"{formats} (default: %(default)s)")
    record.add_argument("--images", choices=("png", "jpg", "raw"), default="png", help=IMAGES_HELP)
    record.add_argument(
        "-o", "--out", type=folder, default=Path("recording"), metavar="DIR", help="folder (default: %(default)s)"
    )


def _add_calibration(record: argparse.ArgumentParser) -> None:
    """Imperfections that a real rig has and an ideal one has not."""
    record.add_argument(
        "--lever-arm", type=numbers(LEVER_ARM, (3, 6)), default=(0.0,) * 3, metavar=LEVER_ARM, help=LEVER_ARM_HELP
    )
    record.add_argument(
        "--imu-bias", type=number(0.0, 10.0), nargs="?", const=1.0, default=0.0, metavar="FACTOR", help=IMU_BIAS_HELP
    )
    record.add_argument("--distortion", type=_distortion, metavar="K1,K2,P1,P2", help=DISTORTION_HELP)


def _distortion(text: str) -> tuple[float, ...]:
    return BARREL if text == "barrel" else numbers("K1,K2,P1,P2, or barrel", (4,))(text)


def _record(arguments: argparse.Namespace) -> int:
    from sim.harness import RunConfig
    from sim.odometry.imu import TURN_ON, ImuConfig
    from sim.record import record
    from sim.record.rooms import ROOMS
    from sim.render.lens import Distortion
    from sim.render.rig import displaced, make_rig

    arm = arguments.lever_arm
    rig = displaced(make_rig(arguments.rig), arm[:3], arm[3:] or (0.0, 0.0, 0.0))
    gyroscope, accelerometer = (arguments.imu_bias * deviation for deviation in TURN_ON)
    config = RunConfig(rig=rig, **walk_options(arguments))
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
            imu_config=ImuConfig(gyroscope_turn_on=gyroscope, accelerometer_turn_on=accelerometer),
            distortion=Distortion(*arguments.distortion) if arguments.distortion else None,
        )
    print(f"{arguments.out}: {arguments.format}, {size / 1e6:.0f} MB")
    return 0
