"""`run_command`: a program in any language as the SLAM. The program reads a recording, and writes its estimate to files."""

import math
import os
import resource
import shlex
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from lexis.errors import LexisError, one_line
from lexis.timing import StageTimer
from sim.errors import ProgramError, ProgramFilesError, SimError
from sim.harness.finished_run import Given, Run
from sim.harness.last_run import last_run
from sim.harness.runner import Progress
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import CommandSlam
from sim.programs.program_files import AT_REST, RecordedTimes, estimate_files, read_estimate
from sim.record.recording import check_format, write_take
from sim.record.take import RecordedFrame, Take, prepare
from sim.truth import Truth

TIMEOUT_S, MEMORY_MB = 600.0, 8192.0
"""Usual limits of a program: wall time [s], and the memory that each of its processes may allocate [MB]."""
DATASET, OUT = "{dataset}", "{out}"
"""Placeholders in a command for the folder of the recording and the folder of the estimate."""
_KEPT_BYTES = 1_000_000


@dataclass(frozen=True)
class Program:
    """A program under test with its limits. It runs scenarios as `run_command` does, and can be sent to other processes.

    Raises `SimError` for a command, a format, a kind of images or a limit that is not valid.
    """

    command: str
    format: str = "euroc"
    timeout_s: float = TIMEOUT_S
    memory_mb: float = MEMORY_MB
    images: str = "png"

    def __post_init__(self) -> None:
        command_words(self.command)
        check_format(self.format, self.images)
        for name, value, unit in (("timeout_s", self.timeout_s, "s"), ("memory_mb", self.memory_mb, "MB")):
            if not 0.0 < value < math.inf:
                raise SimError(f"program: {name} is {value}; valid: a number of {unit} above 0")

    def __call__(self, scenario: Scenario, progress: Progress | None = None) -> Run:
        """Run the program on a scenario."""
        return run_command(scenario, self.command, self.format, self.timeout_s, self.memory_mb, self.images, progress)


def run_command(
    scenario: Scenario,
    command: str,
    format: str = "euroc",
    timeout_s: float = TIMEOUT_S,
    memory_mb: float = MEMORY_MB,
    images: str = "png",
    progress: Progress | None = None,
) -> Run:
    """Record a scenario without its truth, run a program on the recording, and return its estimate with the truth.

    Args:
        scenario: the run; its fidelity is "render", since a program needs images.
        command: the program and its arguments, separated as in a shell. "{dataset}" stands for the folder of the recording,
            and "{out}" for the empty folder into which the program writes the files of `program_files`.
        format: format of the recording: euroc, tum, ros2 or mcap.
        timeout_s: wall time after which the program is stopped [s].
        memory_mb: memory that each process of the program may allocate [MB].
        images: png, jpg or, in bags only, raw.
        progress: called after every recorded frame with the share of frames done, in [0, 1].

    Raises `ProgramError` if the program fails, `ProgramFilesError`, a `EstimateError`, if it writes files that are not
    valid, and whatever `Program` and `sim.record.record` raise.
    """
    Program(command, format, timeout_s, memory_mb, images)  # checks the arguments
    words = command_words(command)
    last = last_run()
    scenario = last.begin(scenario)
    if scenario.fidelity != "render":
        raise SimError(f"command: a program needs images, but the fidelity is {scenario.fidelity!r}; valid: 'render'")
    timed = StageTimer()
    with timed("house_s"):
        take = prepare(scenario, with_truth=False)
    with timed("scene_s"):
        session = take.session
    with tempfile.TemporaryDirectory(prefix="lexis-sim-", ignore_cleanup_errors=True) as name:
        work = Path(name)
        folders = {DATASET: work / "dataset", OUT: work / "out"}
        for placeholder, folder in folders.items():
            folder.mkdir()
            words = [word.replace(placeholder, str(folder)) for word in words]
        with timed("render_s"):
            frames = _recorded(take, folders[DATASET], format, images, progress)
        last.done, last.command = 0.0, command
        with timed("slam_s"):
            printed = _execute(words, work, timeout_s, memory_mb)
        try:
            estimate = read_estimate(folders[OUT], _times(take, frames), take.walk.house.spec.room_labels)
        except (SimError, LexisError) as error:
            message = str(error).replace(str(folders[OUT]), OUT)
            raise ProgramFilesError(message, estimate_files(folders[OUT]), *printed) from error
    walked = frames[take.rest_frames :]
    last.run = Run(
        scenario,
        take.walk.house,
        take.walk.walkable,
        session,
        CommandSlam(command, *printed),
        estimate,
        given={frame.index: frame.given for frame in reversed(walked)},  # the first of duplicates counts
        seconds=timed.seconds,
        delivered=tuple(frame.truth for frame in walked),
    )
    return last.run


def _recorded(take: Take, folder: Path, format: str, images: str, progress: Progress | None) -> "list[_Frame]":
    """Write a recording to a folder; return what the harness remembers of its frames. Raises what `run_command` raises."""
    frames: list[_Frame] = []

    def note(frame: RecordedFrame) -> None:
        frames.append(_Frame.of(frame))

    try:
        write_take(folder, take, format, images, progress, note)
    except OSError as error:
        valid = "valid: a TMPDIR with room for the recording"
        raise SimError(f"recording in {folder}: cannot be written: {one_line(error, 160)}; {valid}") from None
    return frames


def command_words(command: str) -> list[str]:
    """Split a command into words as a shell does. Raises `SimError` for open quotes, or if {dataset} or {out} is missing."""
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise SimError(f"command {command!r:.80}: {error}; valid: words and quotes as in a shell") from None
    if words and any(placeholder in words[0] for placeholder in (DATASET, OUT)):
        raise SimError(f"command {command!r:.80} names no program; valid: such as './my_slam {DATASET} {OUT}'")
    for placeholder in (DATASET, OUT):
        if not any(placeholder in word for word in words):
            raise SimError(f"command {command!r:.80} has no {placeholder}; valid: such as './my_slam {DATASET} {OUT}'")
    return words


@dataclass(frozen=True, eq=False)
class _Frame:
    """What the harness remembers of a recorded frame, without its images."""

    stamp_ns: int
    index: int
    given: Given
    truth: Truth

    @staticmethod
    def of(frame: RecordedFrame) -> "_Frame":
        seen = frame.observation
        return _Frame(frame.stamp_ns, seen.index, Given(seen.stamp, seen.T_O_B), frame.truth)


def _times(take: Take, frames: Sequence[_Frame]) -> RecordedTimes:
    indices = [AT_REST if k < take.rest_frames else frame.index for k, frame in enumerate(frames)]
    return RecordedTimes(np.array([frame.stamp_ns for frame in frames], float) / 1e9, np.array(indices, int), take.frame_s)


def _execute(words: Sequence[str], work: Path, timeout_s: float, memory_mb: float) -> tuple[bytes, bytes]:
    """Run a program within its limits; return the ends of its standard output and standard error, up to 1 MB each.

    Raises `ProgramError` if the program fails or takes too long.
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
    memory, highest = int(memory_mb * 1e6), resource.getrlimit(resource.RLIMIT_DATA)[1]
    if highest != resource.RLIM_INFINITY:  # a limit cannot be raised above that of this process
        memory = min(memory, highest)

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    try:
        process = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, start_new_session=True, preexec_fn=limit
        )
    except FileNotFoundError:
        if shutil.which(words[0]):
            problem = "cannot be run: the interpreter in its first line was not found; valid: an executable file"
        else:
            problem = "was not found; valid: a program on the PATH, or a path"
        raise SimError(f"command: program {words[0]!r} {problem}") from None
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
