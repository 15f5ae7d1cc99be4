"""What the console scripts share: bad input costs one line on stderr and exit status 2, and never a traceback."""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

from lexis.files import check_replaceable

Command: TypeAlias = Callable[[argparse.Namespace], int]
"""Runs a command; returns the exit status."""
Commands: TypeAlias = "argparse._SubParsersAction[Parser]"

_BROKEN_PIPE, _INTERRUPTED = 141, 130
"""128 and the number of the signal, as shells have it."""


class Parser(argparse.ArgumentParser):
    """Reports bad arguments in one line."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Refuse unknown arguments here: argparse would let the parser of the whole program do it, whose help lists none."""
        known, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return known, unknown

    def error(self, message: str) -> NoReturn:
        """End the program with status 2."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def add_command(commands: Commands, name: str, command: Command, help: str, example: str) -> Parser:
    """Add a command with an example in its help; `run_command` will call `command`."""
    formatter = argparse.RawDescriptionHelpFormatter
    parser = commands.add_parser(name, help=help, description=f"{help[0].upper()}{help[1:]}.", formatter_class=formatter)
    parser.epilog = f"example:\n  {example}"
    parser.set_defaults(command=command)
    return parser


def run_command(parser: Parser, argv: Sequence[str] | None, expected: tuple[type[Exception], ...]) -> int:
    """Parse and run; the exit status. Errors of the `expected` classes are bad input."""
    arguments = parser.parse_args(argv)
    try:
        status = int(arguments.command(arguments))
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # Who read has gone, as `head` does. What is still unwritten goes nowhere, or the interpreter would complain of it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _BROKEN_PIPE
    except expected as error:
        print(f"{parser.prog}: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return _INTERRUPTED


def tell_of_replacement(out: Path, marker: str) -> None:
    """Say before long work that the folder `out`, one of ours by its `marker`, will be replaced by what comes of it."""
    check_replaceable(out, marker)
    if (out / marker).is_file():
        print(f"note: {out} holds an earlier one; the new one will replace it", file=sys.stderr)


def positive(text: str) -> int:
    """An argument that is a whole number from 1."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}; valid: a whole number from 1")
    return int(text)


def seed(text: str) -> int:
    """An argument that seeds generators."""
    if not text.isdecimal() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(f"{text!r}; valid: a whole number from 0 to 2**63 - 1")
    return int(text)
