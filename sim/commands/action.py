"""Subcommands of a command, such as `lexis-sim house check`, declared as a table with options and examples."""

import argparse
from collections.abc import Iterable
from typing import NamedTuple

from lexis.command_line import Command, Commands, add_command
from sim.commands.arguments import Argument


class Action(NamedTuple):
    """A subcommand: the function to call, its help text, an example and its arguments."""

    name: str
    command: Command
    help: str
    example: str
    arguments: tuple[Argument, ...]


def add_actions(commands: Commands, name: str, help: str, actions: Iterable[Action], metavar: str = "ACTION") -> None:
    """Add a command that has only subcommands, `actions`. Its help text lists the examples of all subcommands."""
    actions = tuple(actions)
    examples = "\n".join(f"  {action.example}" for action in actions)
    group = commands.add_parser(
        name,
        help=help,
        description=f"{help[0].upper()}{help[1:]}.",
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    choices = group.add_subparsers(required=True, metavar=metavar)
    for action in actions:
        parser = add_command(choices, action.name, action.command, action.help, action.example)
        for add_argument in action.arguments:
            add_argument(parser)
