"""`Program`: a program in any language as the SLAM. It reads a recording, and writes its estimate to files."""

import shlex
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lexis.errors import LexisError, one_line
from lexis.timing import StageTimer
from sim.errors import ProgramFilesError, SimError
from sim.harness.finished_run import Given, Run
from sim.harness.last_run import last_run
from sim.harness.runner import Progress
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import CommandSlam
from sim.number_checks import is_finite
from sim.programs.limited_process import check_program, execute
from sim.programs.program_files import AT_REST, RecordedTimes, estimate_files, read_estimate
from sim.record.recording import check_format, write_take
from sim.record.take import RecordedFrame, Take, prepare
from sim.truth import Truth
from sim.wording import class_of

TIMEOUT_S, MEMORY_MB = 600.0, 8192.0
"""Usual limits of a program: wall time [s], and the memory that each of its processes may allocate [MB]."""
DATASET, OUT = "{dataset}", "{out}"
"""Placeholders in a command for the folder of the recording and the folder of the estimate."""


_OF_SHELLS = frozenset({">", ">>", "2>", "2>&1", "&>", "<", "|", "&&", "||", ";", "&"})
"""Words that only a shell understands. A program would get them as arguments."""


@dataclass(frozen=True)
class Program:
    """A program under test with its limits, as a function that runs scenarios. It can be sent to other processes.

    Raises `SimError` for a command, a format, a kind of images or a limit that is not valid.
    """

    command: str
    """The program and its arguments, separated as in a shell. "{dataset}" stands for the folder of the recording, and
    "{out}" for the empty folder into which the program writes the files of `program_files`."""
    format: str = "euroc"
    """Format of the recording: euroc, tum, ros2 or mcap."""
    timeout_s: float = TIMEOUT_S
    """Wall time after which the program is stopped [s]."""
    memory_mb: float = MEMORY_MB
    """Memory that each process of the program may allocate [MB]."""
    images: str = "png"
    """Format of the images: png, jpg or, in bags only, raw."""

    def __post_init__(self) -> None:
        _words(self.command)
        check_format(self.format, self.images)
        for name, value, unit in (("timeout_s", self.timeout_s, "s"), ("memory_mb", self.memory_mb, "MB")):
            if not is_finite(value) or value <= 0.0:
                raise SimError(f"program: {name} is {value!r:.60}; valid: a number of {unit} above 0")

    def __call__(self, scenario: Scenario, progress: Progress | None = None) -> Run:
        """Record a scenario without its truth, run the program on the recording, and return its estimate with the truth.

        Args:
            scenario: the run; its fidelity is "render", since a program needs images.
            progress: called after every recorded frame with the share of frames done, in [0, 1].

        Raises `ProgramError` if the program fails, `ProgramFilesError`, an `EstimateError`, if it writes files that are not
        valid, and whatever `sim.record.record` raises.
        """
        last = last_run()
        scenario = last.begin(scenario)
        if scenario.fidelity != "render":
            raise SimError(f"command: a program needs images, but the fidelity is {scenario.fidelity!r}; valid: 'render'")
        words = _words(self.command)
        check_program(words[0])
        timed = StageTimer()
        with timed("house_s"):
            take = prepare(scenario, with_truth=False)
        with timed("scene_s"):
            session = take.session
        with tempfile.TemporaryDirectory(prefix="lexis-sim-", ignore_cleanup_errors=True) as name:
            work = Path(name)
            dataset, out = work / "dataset", work / "out"
            dataset.mkdir()
            out.mkdir()
            words = [word.replace(DATASET, str(dataset)).replace(OUT, str(out)) for word in words]
            with timed("render_s"):
                frames = self._recorded(take, dataset, progress)
            last.done, last.command = 0.0, self.command
            with timed("slam_s"):
                printed = execute(words, work, self.timeout_s, self.memory_mb)
            try:
                estimate = read_estimate(out, _times(take, frames), take.walk.house.spec.room_labels)
            except (SimError, LexisError) as error:
                raise ProgramFilesError(str(error).replace(str(out), OUT), estimate_files(out), *printed) from error
        walked = frames[take.rest_frames :]
        last.run = Run(
            scenario,
            take.walk.house,
            take.walk.walkable,
            session,
            CommandSlam(self.command, *printed),
            estimate,
            given={frame.index: frame.given for frame in reversed(walked)},  # the first of duplicates counts
            seconds=timed.seconds,
            delivered=tuple(frame.truth for frame in walked),
        )
        return last.run

    def _recorded(self, take: Take, folder: Path, progress: Progress | None) -> "list[_Frame]":
        """Write the recording to a folder; return what the harness remembers of its frames. Raises what a run raises."""
        frames: list[_Frame] = []

        def note(frame: RecordedFrame) -> None:
            frames.append(_Frame.of(frame))

        try:
            write_take(folder, take, self.format, self.images, progress, note)
        except OSError as error:
            valid = "valid: a TMPDIR with room for the recording"
            raise SimError(f"recording in {folder}: cannot be written: {one_line(error, 160)}; {valid}") from None
        return frames


def _words(command: object) -> list[str]:
    """Split a command into words as a shell does.

    Raises `SimError` for what is no text, for open quotes, or if {dataset} or {out} is missing.
    """
    if not isinstance(command, str):
        raise SimError(f"command is {class_of(command)}; valid: text, such as './my_slam {DATASET} {OUT}'")
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise SimError(f"command {command!r:.80}: {error}; valid: words and quotes as in a shell") from None
    if shell := [word for word in words if word in _OF_SHELLS]:
        valid = "valid: a script of your own that does this"
        raise SimError(f"command {command!r:.80} has {shell[0]!r}, but it is started without a shell; {valid}")
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
