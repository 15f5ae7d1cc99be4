"""What the console scripts share: bad input costs one line on stderr and exit status 2, and never a traceback."""

import argparse
import errno
import io
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

import shtab

from lexis.errors import one_line
from lexis.files.replace import check_replaceable

Command: TypeAlias = Callable[[argparse.Namespace], int]
"""Runs a command; returns the exit status."""
Commands: TypeAlias = "argparse._SubParsersAction[Parser]"

MAX_LINE = 400
"""Longest message on stderr, in characters; a value from a file or a command line may have megabytes."""

_BROKEN_PIPE, _INTERRUPTED = 141, 130
"""128 and the number of the signal, as shells have it."""
_UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
"""Errors of writing; with no name of a file, it was to a stream that was open from the start."""


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
        end = f"; see {self.prog} --help"
        self.exit(2, f"{one_line(f'{self.prog}: {message}', MAX_LINE - len(end))}{end}\n")


def add_command(commands: Commands, name: str, command: Command, help: str, example: str) -> Parser:
    """Add a command with an example in its help; `run_command` will call `command`."""
    formatter = argparse.RawDescriptionHelpFormatter
    parser = commands.add_parser(name, help=help, description=f"{help[0].upper()}{help[1:]}.", formatter_class=formatter)
    parser.epilog = f"example:\n  {example}"
    parser.set_defaults(command=command)
    return parser


def add_completion(commands: Commands, root: Parser) -> None:
    """Add the command that prints a script with which a shell completes the commands and options of `root`."""
    example = f"{root.prog} completion bash > ~/.local/share/bash-completion/completions/{root.prog}"

    def complete(arguments: argparse.Namespace) -> int:
        print(shtab.complete(root, shell=arguments.shell))
        return 0

    completion = add_command(commands, "completion", complete, "a script that completes commands in a shell", example)
    completion.add_argument("shell", choices=("bash", "zsh", "fish"))


def run_command(parser: Parser, argv: Sequence[str] | None, expected: tuple[type[Exception], ...]) -> int:
    """Parse and run; the exit status.

    Errors of the `expected` classes are bad input and cost one line, and one for each of their notes; a full standard output
    is bad input too.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files need not be text in any encoding
    try:
        return _run_and_flush(parser, argv)
    except BrokenPipeError:
        # The reader has gone, as `head` does.
        _drop_output()
        return _BROKEN_PIPE
    except expected as error:
        return _bad_input(parser, str(error), *getattr(error, "__notes__", ()))
    except OSError as error:
        if error.filename is not None or error.errno not in _UNWRITABLE:
            raise
        _drop_output()
        return _bad_input(parser, f"standard output cannot be written: {error.strerror}; valid: a place with room for it")
    except KeyboardInterrupt:
        return _INTERRUPTED


def _run_and_flush(parser: Parser, argv: Sequence[str] | None) -> int:
    try:
        arguments = parser.parse_args(argv)
        status = int(arguments.command(arguments))
    except SystemExit:
        # Help was printed.
        _flush()
        raise
    _flush()
    return status


def _bad_input(parser: Parser, *messages: str) -> int:
    for message in messages:
        print(one_line(f"{parser.prog}: {message}", MAX_LINE), file=sys.stderr)
    return 2


def _flush() -> None:
    if sys.stdout is not None:  # as it is for a process that was started without one
        sys.stdout.flush()


def _drop_output() -> None:
    """Let what is unwritten go nowhere, or the interpreter would complain of it at the end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


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
