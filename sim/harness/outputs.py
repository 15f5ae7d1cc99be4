"""Writes the folder of a run or of a crash; the folder is written completely or not at all."""

import json
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

from lexis.files.replace import replaced_folder
from lexis.files.tum_trajectory import write_tum
from sim.errors import EstimateError, ProgramError, ProgramFilesError
from sim.harness.crash import TRACEBACK, Crash
from sim.harness.finished_run import Run
from sim.harness.last_run import last_run
from sim.harness.report_data import report_data
from sim.harness.results import RESULT, RunResult
from sim.harness.slam_under_test import SavesFiles, write_printed
from sim.harness.trial import Trial
from sim.harness.world_tests import SCENARIO, TEST_REPLAY
from sim.report import ShownFailure, write_report

REPORT = "report.html"
MARKERS = (RESULT, TRACEBACK, TEST_REPLAY)
"""Files that identify a folder as the output of a run, of a crash or of a failed check, which a new run may replace."""
_NO_FILES: Mapping[str, bytes] = MappingProxyType({})


def write_run(
    run: Run,
    result: RunResult,
    trials: Sequence[Trial],
    out: Path,
    more: Mapping[str, bytes] = _NO_FILES,
    failure: ShownFailure | None = None,
) -> None:
    """Write result.json, scenario.json, house.json, report.html, the trajectories and the SLAM's own files to `out`.

    `more` contains further files: their contents, by file name. The report shows the `failure`, if there is one. A folder of
    an earlier run is replaced. Raises `LexisError` where `out` holds anything else or cannot be written, `EstimateError`
    where a file of the SLAM has the name of a file of the harness, and whatever the SLAM raises.
    """
    with _folder_with(more, out) as folder:
        fill_run_folder(run, result, trials, folder, failure)


def write_crash(crash: Crash, out: Path, more: Mapping[str, bytes]) -> None:
    """Write failure-traceback.txt and scenario.json to `out`, and for a program also what it printed.

    If the program has written files that are not valid, these files are written, too. `more` contains further files: their
    contents, by file name. A folder of an earlier run is replaced. Raises `LexisError` where `out` holds anything else or
    cannot be written.
    """
    with _folder_with(more, out) as folder:
        fill_crash_folder(crash, folder)


@contextmanager
def _folder_with(more: Mapping[str, bytes], out: Path) -> Iterator[Path]:
    """Yield a folder to fill, which contains the files `more`. After the block, the folder replaces `out`."""
    with replaced_folder(out, *MARKERS) as folder:
        for name, content in more.items():
            (folder / name).write_bytes(content)
        yield folder


def fill_crash_folder(crash: Crash, folder: Path) -> None:
    """Write the files of `write_crash` into an existing folder."""
    (folder / TRACEBACK).write_text(crash.traceback, encoding="utf-8")
    crash.scenario.save(folder / SCENARIO)
    if isinstance(crash.error, ProgramError):
        write_printed(crash.error.stdout, crash.error.stderr, folder)
    if isinstance(crash.error, ProgramFilesError):
        for name, content in crash.error.files.items():
            (folder / name).write_bytes(content)


def fill_run_folder(
    run: Run, result: RunResult, trials: Sequence[Trial], folder: Path, failure: ShownFailure | None
) -> None:
    """Write the files of `write_run` into an existing folder."""
    (folder / RESULT).write_text(json.dumps(result.data(), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    (folder / "house.json").write_text(run.house.spec.to_json(), encoding="utf-8")
    run.scenario.save(folder / SCENARIO)
    if run.estimate.T_W_B is not None:
        write_tum(folder / "trajectory.tum", run.stamps, run.estimate.T_W_B)
    write_tum(folder / "ground_truth.tum", run.stamps, run.true_poses)
    write_tum(folder / "odometry.tum", run.stamps, run.odometry_poses)
    write_report(folder / REPORT, report_data(run, result, trials, failure))
    if isinstance(run.slam, SavesFiles):
        _save_files_of(run.slam, folder)


def _save_files_of(slam: SavesFiles, folder: Path) -> None:
    """Let a SLAM write files into an empty folder, and move them into the folder of the run."""
    with tempfile.TemporaryDirectory(dir=folder.parent) as name:
        with last_run().calling_slam():
            slam.save(Path(name))
        for path in sorted(Path(name).iterdir()):
            if (folder / path.name).exists():
                raise EstimateError(
                    f"SLAM under test: save() wrote {path.name!r}, a name of the harness; valid: other names"
                )
            path.rename(folder / path.name)
