"""A run's folder: written beside its place and renamed, so that a half-written one is never seen."""

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lexis.evaluation.trajectory import write_tum
from lexis.map_io import save_map

from sim.errors import SimError
from sim.harness.report_data import report_data
from sim.harness.run import Run
from sim.report import write_report


def write_run(run: Run, result: dict[str, Any], out: Path) -> None:
    """Write result.json, house.json, report.html, the three trajectories at the keyframes and the map to `out`.

    A folder of an earlier run is replaced. Raises `SimError` where `out` cannot be written.
    """
    stamps = [keyframe.stamp for keyframe in run.map.keyframes]
    with replaced_folder(out) as folder:
        (folder / "result.json").write_text(json.dumps(result, indent=1) + "\n")
        (folder / "house.json").write_text(run.house.spec.to_json())
        write_tum(folder / "trajectory.tum", stamps, run.map.T_W_B)
        write_tum(folder / "ground_truth.tum", stamps, run.true_poses)
        write_tum(folder / "odometry.tum", stamps, run.odometry_poses)
        save_map(run.map, folder / "map")
        write_report(folder / "report.html", report_data(run, result))


def check_writable(out: Path) -> None:
    """Raise `SimError` where a folder could not be made at `out`, or something that is no run's folder is there."""
    if out.exists() and not (out.is_dir() and (not any(out.iterdir()) or (out / "result.json").exists())):
        raise SimError(f"--out {out}: exists and is no earlier run's folder; name a new one")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=out.parent).close()
    except OSError as error:
        raise SimError(f"--out {out}: cannot be written: {error.strerror}; name a folder that can") from None


@contextmanager
def replaced_folder(out: Path) -> Iterator[Path]:
    """A folder beside `out` that takes its place when the block ends well, and goes when it does not."""
    check_writable(out)
    beside = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    try:
        yield beside
        if out.exists():
            shutil.rmtree(out)
        beside.chmod(0o755)
        beside.rename(out)
    finally:
        shutil.rmtree(beside, ignore_errors=True)
