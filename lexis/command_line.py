"""Parsing and error reporting shared by the console scripts.

Bad input is reported in one line on stderr with exit status 2, never by a traceback.
"""

import argparse
import errno
import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn, TypeAlias

import shtab

from lexis.__main__ import INTERRUPTED
from lexis.errors import one_line
from lexis.files.replace import check_replaceable

Command: TypeAlias = Callable[[argparse.Namespace], int]
"""A function that runs a command and returns the exit status."""
Commands: TypeAlias = "argparse._SubParsersAction[Parser]"

ENCODER_HELP = "mini, MODEL[:PRETRAINED] or MODEL:PATH of open_clip (default: %(default)s)"
MAX_LINE = 400
"""Longest message on stderr, in characters. Longer messages are shortened, because a message may quote a value of several
megabytes."""

_VALUES: Mapping[object, str] = MappingProxyType({None: " with one value", "+": " with one value or more"})
"""How many values an option takes, by its `nargs`, for messages."""
_BROKEN_PIPE = 141
"""Exit status after a broken pipe, as shells define it: 128 plus the number of the signal."""
_UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
"""Error numbers of an output that cannot be written, for example to a full disk."""


class Parser(argparse.ArgumentParser):
    """An argument parser that reports bad arguments in one line, and does not accept abbreviated options."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        """Create a parser as `argparse.ArgumentParser` does."""
        super().__init__(*args, **kwargs | {"allow_abbrev": False})

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Refuse unknown arguments in the command's own parser, so that the message points to the command's own help.

        By default, argparse refuses unknown arguments in the parser of the whole program, whose help does not list the
        arguments of the command.
        """
        known, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._hint(unknown)}")
        return known, unknown

    def _hint(self, unknown: Sequence[str]) -> str:
        """Name the option that has an s more or less than an unknown one, such as --preset for --presets; "" without one."""
        for name in (word.partition("=")[0] for word in unknown):
            other = name.removesuffix("s") if name.endswith("s") else f"{name}s"
            if action := self._option_string_actions.get(other):
                return f"; valid: {other}{_VALUES.get(action.nargs, '')}"
        return ""

    def error(self, message: str) -> NoReturn:
        """Print the message in one line and exit with status 2."""
        end = f"; see {self.prog} --help"
        self.exit(2, f"{one_line(f'{self.prog}: {message}', MAX_LINE - len(end))}{end}\n")


def add_command(commands: Commands, name: str, command: Command, help: str, example: str) -> Parser:
    """Add a command that calls the function `command`, and return the command's parser, to which arguments can be added.

    The help of the command shows `example`.
    """
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
    shells = ("bash", "zsh", "fish")
    completion.add_argument("shell", choices=shells, metavar="SHELL", help=", ".join(shells))


def run_command(parser: Parser, argv: Sequence[str] | None, expected: tuple[type[Exception], ...]) -> int:
    """Parse the arguments, run the command and return the exit status.

    Errors of the `expected` classes count as bad input: they are reported in one line, plus one line for each note that
    is attached to the error. A standard output that cannot be written, for example to a full disk, counts as bad input too.
    SIGTERM acts as Ctrl-C.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names need not be valid in any encoding
    try:
        with _terminated_as_interrupted():
            return _run_and_flush(parser, argv)
    except BrokenPipeError:
        # The reader closed the pipe, as `head` does.
        _drop_output()
        return _BROKEN_PIPE
    except expected as error:
        return _bad_input(parser, str(error), *getattr(error, "__notes__", ()))
    except OSError as error:
        # Only an error of a standard stream has no file name.
        if error.filename is not None or error.errno not in _UNWRITABLE:
            raise
        _drop_output()
        return _bad_input(parser, f"standard output cannot be written: {error.strerror}; valid: a place with room for it")
    except KeyboardInterrupt as error:
        print(f"interrupted: {error}" if error.args else "interrupted", file=sys.stderr)
        return INTERRUPTED


@contextmanager
def interrupted_later() -> Iterator[threading.Event]:
    """Let the first Ctrl-C only set the event, so that the caller can stop where nothing is half done.

    A second Ctrl-C interrupts at once. Where Ctrl-C is not handled as usual, as in a thread or under nohup, nothing changes.
    """
    pressed = threading.Event()

    def note(number: int, frame: object) -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        pressed.set()

    with _handled(signal.SIGINT, signal.default_int_handler, note):
        yield pressed


@contextmanager
def _handled(number: int, usual: object, handler: Callable[[int, Any], None]) -> Iterator[None]:
    """Handle a signal by `handler` while the block runs.

    Nothing changes outside of the main thread, and where the signal is not handled as `usual`.
    """
    before = signal.getsignal(number)
    if before is not usual or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, before)


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """While the block runs, let SIGTERM act as Ctrl-C: a CI system sends it to a job that takes too long."""

    def interrupt(number: int, frame: object) -> None:
        import multiprocessing

        for child in multiprocessing.active_children():
            if child.pid is not None:  # the terminal sends Ctrl-C to all processes, and nobody sends SIGTERM to these
                os.kill(child.pid, signal.SIGINT)
        if not callable(signal.getsignal(signal.SIGINT)):  # Ctrl-C is ignored, as in the background of a shell
            raise KeyboardInterrupt
        signal.raise_signal(signal.SIGINT)

    with _handled(signal.SIGTERM, signal.SIG_DFL, interrupt):
        yield


def _run_and_flush(parser: Parser, argv: Sequence[str] | None) -> int:
    try:
        arguments = parser.parse_args(argv)
        status = int(arguments.command(arguments))
    except SystemExit:
        # argparse exits after it has printed help or an error.
        _flush()
        raise
    _flush()
    return status


def _bad_input(parser: Parser, *messages: str) -> int:
    for message in messages:
        print(one_line(f"{parser.prog}: {message}", MAX_LINE), file=sys.stderr)
    return 2


def _flush() -> None:
    if sys.stdout is not None:  # it is None for a process that was started without one
        sys.stdout.flush()


def _drop_output() -> None:
    """Redirect unwritten output to the null device; otherwise, the interpreter reports an error when it exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def warn_of_replacement(out: Path, *markers: str) -> None:
    """Check before long work that `out` can be replaced, and print the note of `note_replacement`.

    Raises LexisError as `check_replaceable` does.
    """
    check_replaceable(out, *markers)
    note_replacement(out, *markers)


def note_replacement(out: Path, *markers: str) -> None:
    """Print a note if `out` holds an earlier result, which means that it contains any of the files `markers`."""
    if any((out / marker).is_file() for marker in markers):
        print(f"note: {out} holds an earlier result; the new one will replace it", file=sys.stderr)


def positive(text: str) -> int:
    """Parse an argument that is a whole number of at least 1."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}; valid: a whole number from 1")
    return int(text)


def seed(text: str) -> int:
    """Parse an argument that seeds random generators, a whole number from 0 to 2**63 - 1."""
    if not text.isdecimal() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(f"{text!r}; valid: a whole number from 0 to 2**63 - 1")
    return int(text)
