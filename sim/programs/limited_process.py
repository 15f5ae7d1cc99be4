"""`execute`: runs a program of the user in a process with limits of time and memory."""

import os
import resource
import shutil
import signal
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from lexis.errors import one_line
from sim.errors import ProgramError, SimError

_KEPT_BYTES = 1_000_000
LARGEST_FILE_BYTES = 4_000_000_000
"""Largest file that a program may write. A program that prints without end would otherwise fill the disk."""


def check_program(program: str) -> None:
    """Raise `SimError` unless a program exists and may be executed. Call this before long work for the program."""
    if shutil.which(program) is None:
        if os.sep in program and os.path.lexists(program):
            raise SimError(
                f"command: {program!r} cannot be run: it is not executable; valid: chmod +x, or its interpreter first"
            )
        raise SimError(f"command: program {program!r} was not found; valid: a program on the PATH, or a path")


def execute(words: Sequence[str], work: Path, timeout_s: float, memory_mb: float) -> tuple[bytes, bytes]:
    """Run a program within its limits; return the ends of its standard output and standard error, up to 1 MB each.

    Args:
        words: the program and its arguments.
        work: folder in which the output of the program is kept while it runs.
        timeout_s: wall time after which the program and its child processes are killed [s].
        memory_mb: memory that each process of the program may allocate [MB].

    Raises `ProgramError` if the program fails or takes too long, and `SimError` if it cannot be run.
    """
    paths = work / "stdout", work / "stderr"
    with paths[0].open("wb") as stdout, paths[1].open("wb") as stderr:
        status = _exit_status(words, timeout_s, memory_mb, stdout, stderr)
    printed, errors = map(_end_of, paths)
    if status is None:
        message = f"command: {words[0]} took longer than {timeout_s:g} s; valid: a program that ends in time"
        raise ProgramError(message, f"takes longer than {timeout_s:g} s", printed, errors)
    if status:
        how = f"exit status {status}" if status > 0 else f"signal {-status} ({signal.strsignal(-status)})"
        last = errors.decode(errors="replace").strip().rpartition("\n")[2] or "nothing on stderr"
        message = f"command: {words[0]} ended with {how}: {one_line(last, 160)}"
        raise ProgramError(message, f"ends with {how}", printed, errors)
    return printed, errors


def _exit_status(words: Sequence[str], timeout_s: float, memory_mb: float, stdout: BinaryIO, stderr: BinaryIO) -> int | None:
    """Run a program in a process group of its own; return its exit status, or None if it took too long.

    A negative status is the number of the signal that ended the program, with a minus sign. At the end, all processes of the
    group are killed.
    """
    limits = {
        resource.RLIMIT_DATA: int(memory_mb * 1e6),
        resource.RLIMIT_FSIZE: LARGEST_FILE_BYTES,
        resource.RLIMIT_CORE: 0,
    }
    for kind, wanted in limits.items():
        highest = resource.getrlimit(kind)[1]
        if highest != resource.RLIM_INFINITY:  # a limit cannot be raised above that of this process
            limits[kind] = min(wanted, highest)

    def limit() -> None:
        for kind, size in limits.items():
            resource.setrlimit(kind, (size, size))

    try:
        process = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, start_new_session=True, preexec_fn=limit
        )
    except FileNotFoundError:
        check_program(words[0])  # it may have gone since the first check
        problem = "the interpreter in its first line was not found; valid: an executable file"
        raise SimError(f"command: program {words[0]!r} cannot be run: {problem}") from None
    except (OSError, subprocess.SubprocessError) as error:
        raise SimError(f"command: {words[0]!r} cannot be run: {one_line(error, 160)}; valid: an executable file") from None
    try:
        return process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        return None
    finally:
        with suppress(ProcessLookupError, PermissionError):  # macOS forbids it for a group that has ended
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _end_of(path: Path) -> bytes:
    """Return the last megabyte of a file."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - _KEPT_BYTES))
        return file.read()
