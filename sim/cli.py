"""The console script `lexis-sim`. Each group of commands is a module of `sim/commands/`.

Exit status: 0 on success, 1 if a check failed, 2 on invalid input. For invalid input, one line on stderr says what would be
valid.
"""

import argparse
from collections.abc import Sequence

from lexis.command_line import Parser, add_completion, run_command
from lexis.errors import LexisError
from sim.commands import calibration, check, compare, doctor, features, house, record, run, shrink, training, vocabulary
from sim.commands.benchmarks import bench
from sim.errors import SimError
from worlds.errors import WorldsError

GROUPS = (run, check, shrink, compare, house, record, bench, training, vocabulary, calibration, features, doctor)
"""Modules that each define a group of commands, in the order in which the help lists them."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command that `argv` names (None: the process's arguments) and return its exit status."""
    return run_command(parser(), argv, (WorldsError, SimError, LexisError))


def parser() -> Parser:
    """Build the parser of all commands."""
    root = Parser(
        "lexis-sim",
        description="Test indoor semantic SLAM in generated houses, against exact ground truth.",
        epilog="example:\n  lexis-sim demo --seed 7",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = root.add_subparsers(required=True, metavar="COMMAND")
    for group in GROUPS:
        group.add_to(commands)
    add_completion(commands, root)
    return root
