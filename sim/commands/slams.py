"""Options that choose the SLAM under test: LEXIS, a class of the user's own, or a program in any language."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sim.commands.arguments import IMAGE_FORMATS, number
from sim.commands.named_object import named_object
from sim.commands.record import FORMATS
from sim.errors import SimError

if TYPE_CHECKING:
    from sim.harness.claims import Claim
    from sim.harness.crash import Runner
    from sim.harness.failures.failure_folder import Replay
    from sim.harness.slam_under_test import SlamUnderTest
    from sim.programs.program import Program

SLAM_HELP = (
    "a class in a module of the current folder or on Python's path, which is called without arguments (default: LEXIS); "
    "also sim.harness.adapters:OdometryOnly and :GeometricRooms"
)
COMMAND_HELP = (
    "a program that reads the recording in {dataset} and writes trajectory.tum, and optionally rooms.json and loops.json, "
    "into {out}"
)

_PROGRAM_OPTIONS = ("format", "image_format", "timeout", "memory")


def add_slam(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose the SLAM under test."""
    slam = parser.add_mutually_exclusive_group()
    slam.add_argument("--slam", metavar="MODULE:CLASS", help=SLAM_HELP)
    slam.add_argument("--command", dest="program", metavar='"PROGRAM {dataset} {out}"', help=COMMAND_HELP)
    parser.add_argument("--format", choices=FORMATS, help="format of the recording for --command (default: euroc)")
    parser.add_argument(
        "--image-format",
        choices=IMAGE_FORMATS,
        help="images in the recording for --command; raw in bags only (default: png)",
    )
    parser.add_argument(
        "--timeout", type=number(0.1, 1e6), metavar="S", help="seconds after which --command is stopped (default: 600)"
    )
    parser.add_argument(
        "--memory", type=number(1.0, 1e7), metavar="MB", help="memory for each process of --command (default: 8192)"
    )


def is_lexis(arguments: argparse.Namespace) -> bool:
    """Return whether the options of `add_slam` choose LEXIS."""
    return arguments.slam is None and arguments.program is None


def check_claimable(arguments: argparse.Namespace, claim: "Claim") -> None:
    """Raise `SimError` for a claim about plans if the SLAM is a program, because programs have no way to state plans."""
    if arguments.program is not None and claim.is_about_plans:
        raise SimError(
            f"{str(claim)!r}: a program of --command makes no plans, so {claim.figure} is null; "
            "valid: figures of trajectory, labels, rooms, floors or loops, or --slam"
        )


def runner_of(arguments: argparse.Namespace) -> "Runner":
    """Return a function that runs the SLAM chosen by `add_slam`. Raises `SimError` for an unusable class or command."""
    if arguments.program is not None:
        return program_of(arguments)
    refuse_program_options(arguments)
    if arguments.slam is not None:
        return runner_of_class(arguments.slam)
    from sim.harness import run

    return lambda scenario, progress: run(scenario, None, progress)


def runner_of_class(text: str, option: str = "--slam") -> "Runner":
    """Return a function that runs the SLAM named MODULE:CLASS. Raises `SimError` as `slam_factory` does."""
    from sim.harness import run
    from sim.harness.slam_under_test import made_slam

    new_slam = slam_factory(text, option)
    return lambda scenario, progress: run(scenario, made_slam(new_slam), progress)


def replay_of(arguments: argparse.Namespace) -> "Replay":
    """Return the code by which the test in a failure folder runs the SLAM that the options choose.

    The test has to be started in the folder in which this command was started.
    """
    from sim.harness.failures.failure_folder import LEXIS_REPLAY, Replay

    if arguments.program is not None:
        given = ", ".join(map(repr, (arguments.program, *_settings(arguments))))
        return Replay("from sim.programs import Program", f"Program({given})(scenario)", f"Program({given})")
    if arguments.slam is not None:
        imports = "from sim.commands.slams import slam_factory\nfrom sim.harness import run"
        before = f"    new_slam = slam_factory({arguments.slam!r})\n"
        return Replay(imports, "run(scenario, new_slam())", "new_slam", before)
    return LEXIS_REPLAY


def slam_options(arguments: argparse.Namespace) -> list[str]:
    """Return the options of `add_slam` as they were given, for a command that is shown to the user."""
    given = {"--slam": arguments.slam, "--command": arguments.program}
    given |= {f"--{option.replace('_', '-')}": getattr(arguments, option) for option in _PROGRAM_OPTIONS}
    return [text for option, value in given.items() if value is not None for text in (option, f"{value}")]


def refuse_program_options(arguments: argparse.Namespace) -> None:
    """Raise `SimError` if an option for programs is given without a program."""
    for option in _PROGRAM_OPTIONS:
        if getattr(arguments, option) is not None:
            raise SimError(f"--{option.replace('_', '-')} is for programs; valid: with --command")


def program_of(arguments: argparse.Namespace) -> "Program":
    """Return the program that `--command` names, with its limits. Raises `SimError` for a command that is not valid."""
    from sim.programs.program import Program

    return Program(arguments.program, *_settings(arguments))


def _settings(arguments: argparse.Namespace) -> tuple[str, float, float, str]:
    """Return the format of the recording, the program's limits of time [s] and memory [MB], and the kind of images."""
    from sim.programs.program import MEMORY_MB, TIMEOUT_S

    limits = arguments.timeout or TIMEOUT_S, arguments.memory or MEMORY_MB
    return arguments.format or "euroc", *limits, arguments.image_format or "png"


@dataclass(frozen=True)
class SlamFactory:
    """Makes SLAMs of the class that is named MODULE:CLASS.

    Unpickling imports the module, so that kinds of furniture and other things that the module declares exist in a worker
    before the worker draws its first house.
    """

    text: str

    def __reduce__(self) -> "tuple[Callable[[str], SlamFactory], tuple[str]]":
        """Tell pickle to make a copy with `slam_factory`, which imports the module."""
        return slam_factory, (self.text,)

    def __call__(self) -> "SlamUnderTest":
        """Make a SLAM. Raises `SimError` if its class cannot be imported, and whatever the class raises."""
        return _imported(self.text)()


def slam_factory(text: str, option: str = "--slam") -> SlamFactory:
    """Return a function that makes the SLAM named MODULE:CLASS.

    Raises `SimError` if the class cannot be imported, or cannot be called without arguments. The message begins with the
    `option` that names the class.
    """
    from sim.harness.slam_under_test import check_slam_factory

    check_slam_factory(f"{option} {text!r:.80}", _imported(text, option))
    return SlamFactory(text)


def _imported(text: str, option: str = "--slam") -> "Callable[[], SlamUnderTest]":
    place = f"{option} {text!r:.80}"
    found = named_object(text, place, "MODULE:CLASS", "my_slam:MySlam")
    if not callable(found):
        raise SimError(f"{place}: the module has no class {text.partition(':')[2]}; valid: the name of a class in it")
    return found
