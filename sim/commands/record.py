"""`lexis-sim record`: write a run as a dataset for other programs."""

import argparse
from pathlib import Path

from lexis.command_line import Commands, add_command, warn_of_replacement
from sim.commands.arguments import (
    IMAGE_FORMATS,
    PINHOLE_RIGS,
    add_walk,
    folder,
    number,
    numbers,
    walk_options,
    whole_number,
)
from sim.commands.progress import progress_bar
from sim.record.stamps import MAX_DAY

FORMATS = {
    "euroc": "EuRoC ASL: stereo, 200 Hz IMU, true states, odometry; ORB-SLAM3 reads it if images are png",
    "tum": "TUM RGB-D: colour, 16-bit depth, true camera trajectory, accelerometer, odometry; ORB-SLAM3 reads it as RGB-D",
    "ros2": "ROS 2 bag (sqlite3): stereo, IMU, odometry, tf; VINS-Fusion and OpenVINS read it if images are raw",
    "mcap": "ROS 2 bag with the same topics, stored as MCAP",
}
IMAGE_FORMAT_HELP = (
    "png: LEXIS makes the same map from the recording as in the live run, bit by bit; jpg: lossy, so labels and loops may "
    "differ a little; raw: uncompressed, in bags only (default: %(default)s)"
)

RIG_HELP = f"cameras: {', '.join(PINHOLE_RIGS)}; wide gets a second camera 0.11 m to the right (default: %(default)s)"

LEVER_ARM = "X,Y,Z[,ROLL,PITCH,YAW]"
LEVER_ARM_HELP = (
    "position of the cameras relative to the IMU: forward, left, up in metres, at most 0.15 in all, and their rotation in "
    "degrees (default: at the IMU, looking ahead); write --lever-arm=-0.02,... if the first number is negative"
)
IMU_BIAS_HELP = (
    "initial biases of the IMU, drawn with standard deviations of FACTOR x 0.5 deg/s and FACTOR x 20 mg "
    "(default: none; without a number: 1)"
)
DISTORTION_HELP = (
    "radial-tangential distortion of the images, as in --distortion=-0.1,0.008,0,0, or 'barrel' for coefficients usual for "
    "a lens this wide; calibrations and settings contain it (default: none)"
)
DAY_HELP = (
    "let all stamps be N days later, so that the sessions of several days in one map have different stamps (default: 0)"
)
BARREL = (-0.1, 0.008, 0.0005, -0.0003)
"""Distortion coefficients of a typical wide lens. The coefficients of EuRoC's cameras were fitted for a field of view of 78
degrees; at 100 degrees they would make straight lines wavy."""


def add_to(commands: Commands) -> None:
    """Add the command `record`."""
    record = add_command(
        commands,
        "record",
        _record,
        "write a run as a dataset for other programs and for 'lexis run'",
        "lexis-sim record --preset home --seed 7 --format euroc -o recording\n"
        "  lexis run recording --rooms recording/rooms.json -o map",
    )
    add_walk(record)
    record.add_argument("--rig", choices=PINHOLE_RIGS, default="wide", help=RIG_HELP)
    _add_calibration(record)
    formats = "; ".join(f"{name}: {text}" for name, text in FORMATS.items())
    record.add_argument("--format", choices=FORMATS, default="euroc", help=f"{formats} (default: %(default)s)")
    record.add_argument("--image-format", choices=IMAGE_FORMATS, default="png", help=IMAGE_FORMAT_HELP)
    record.add_argument("--day", type=whole_number(0, MAX_DAY), default=0, metavar="N", help=DAY_HELP)
    record.add_argument(
        "-o", "--out", type=folder, default=Path("recording"), metavar="DIR", help="folder to write (default: %(default)s)"
    )


def _add_calibration(record: argparse.ArgumentParser) -> None:
    """Add the options for imperfections of a real rig: lever arm, IMU biases and lens distortion."""
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
    from sim.harness import Scenario
    from sim.odometry.imu import TURN_ON, ImuConfig
    from sim.record import record
    from sim.record.rooms import ROOMS
    from sim.render.lens import Distortion
    from sim.render.rig import RigConfig

    arm = arguments.lever_arm
    rig = RigConfig(arguments.rig, lever_arm_m=arm[:3], lever_arm_rpy_deg=arm[3:] or (0.0, 0.0, 0.0))
    gyroscope, accelerometer = (arguments.imu_bias * deviation for deviation in TURN_ON)
    scenario = Scenario(rig=rig, **walk_options(arguments))
    warn_of_replacement(arguments.out, ROOMS)
    with progress_bar("recording") as progress:
        size = record(
            scenario,
            arguments.out,
            arguments.format,
            arguments.image_format,
            progress=progress,
            imu_config=ImuConfig(gyroscope_turn_on=gyroscope, accelerometer_turn_on=accelerometer),
            distortion=Distortion(*arguments.distortion) if arguments.distortion else None,
            day=arguments.day,
        )
    print(f"{arguments.out}: {arguments.format}, {size / 1e6:.0f} MB")
    return 0
