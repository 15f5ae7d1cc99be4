"""The console script `lexis`, which makes maps from recorded runs and works with them. It needs no simulator.

Each command is a module of `lexis/commands/`.

The exit status is 0 on success. On bad input it is 2, and one line on stderr says what would be valid. If a recording breaks
off, `lexis run` first saves what it has mapped and prints a line about it; then it reports the error.
"""

import argparse
from collections.abc import Sequence

from lexis.command_line import Parser, add_completion, run_command
from lexis.commands import config, info, interchange, merge, plan, query, relabel, run
from lexis.errors import LexisError

COMMANDS = (run, merge, info, plan, query, relabel, interchange, config)
"""Modules that each define a command, or two, in the order in which the help lists them."""
EXAMPLE = """example:
  lexis run recording --rooms "kitchen,office,corridor,stairs" -o map
  lexis query map "where can I wash my hands"
"""


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
    for command in COMMANDS:
        command.add_to(commands)
    add_completion(commands, root)
    return root
